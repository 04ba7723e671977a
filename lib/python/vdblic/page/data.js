// The values of points, lines and the solid, as pages.py packs them.

import { cross, subtract } from "./vector.js";

export async function unpacked(flow, text) {
    const letters = atob(text),
        zipped = new Uint8Array(letters.length);
    for (let i = 0; i < zipped.length; ++i) zipped[i] = letters.charCodeAt(i);
    const stream = new Blob([zipped]).stream().pipeThrough(new DecompressionStream("gzip"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
    let at = 0;
    const column = (count) => {
        const values = new Uint16Array(count);
        for (let i = 0, sum = 0; i < count; ++i) {
            const folded = bytes[at + i] | (bytes[at + count + i] << 8);
            values[i] = sum += (folded >> 1) ^ -(folded & 1);
        }
        at += 2 * count;
        return values;
    };
    const points = Array.from({ length: 4 }, () => column(flow.points));
    const lines = Array.from({ length: 4 }, () => column(flow.lines));
    const scalars = flow.scalars.map(() => {
        const values = bytes.slice(at, (at += flow.points));
        for (let i = 1; i < values.length; ++i) values[i] += values[i - 1];
        return values;
    });
    const columns = (count) => Array.from({ length: 3 }, () => column(count));
    const solid = flow.solid && { points: columns(flow.solid.points), corners: columns(flow.solid.triangles) };
    return { points, lines, scalars, solid };
}

/// The pieces of lines by the time of their ends. @return points that begin them, and by tick how many end before it
export function pieces(counts, time) {
    const starts = new Uint32Array(65538);
    const owners = new Uint32Array(time.length);
    let longest = 0;
    for (let line = 0, i = 0; line < counts.length; ++line)
        for (const end = i + counts[line]; i < end; ++i) {
            owners[i] = line;
            if (i + 1 === end) continue;
            ++starts[time[i + 1] + 1];
            longest = Math.max(longest, time[i + 1] - time[i]);
        }
    for (let t = 1; t < starts.length; ++t) starts[t] += starts[t - 1];
    const order = new Uint32Array(starts.at(-1)),
        next = starts.slice();
    for (let i = 0; i + 1 < time.length; ++i) if (owners[i] === owners[i + 1]) order[next[time[i + 1]]++] = i;
    return { order, starts, owners, longest };
}

/// Places and directions away from a surface, of all its points. @param low, side its box
export function surface({ points, corners }, low, side) {
    const count = points[0].length,
        places = new Float32Array(3 * count),
        normals = new Float32Array(3 * count);
    for (let i = 0; i < 3 * count; ++i) places[i] = low[i % 3] + (points[i % 3][Math.floor(i / 3)] / 8191) * side[i % 3];
    const placeOf = (i) => [places[3 * i], places[3 * i + 1], places[3 * i + 2]];
    for (let t = 0; t < corners[0].length; ++t) {
        const [a, b, c] = corners.map((column) => placeOf(column[t]));
        const across = cross(subtract(b, a), subtract(c, a));
        for (const column of corners) for (let i = 0; i < 3; ++i) normals[3 * column[t] + i] += across[i];
    }
    const order = new Uint16Array(3 * corners[0].length);
    for (let i = 0; i < order.length; ++i) order[i] = corners[i % 3][Math.floor(i / 3)];
    return { places, normals, order };
}
