// The values of points and lines, as pages.py packs them.

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
    return { points, lines, scalars };
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
