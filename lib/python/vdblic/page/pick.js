// The line at a place of the picture.

import { axes } from "./camera.js";
import { dot } from "./vector.js";

const kNear = 6; // pixels

/// Of the lines near a place the one in front. @param state as draw() takes it  @param x, y pixels from the middle, y up
/// @param focal distance of the picture from the eye in pixels  @return { line, point, share, time [ticks] } or null
export function lineAt(scene, state, x, y, focal) {
    const { flow, data, low, side } = scene,
        [px, py, pz, time] = data.points,
        [, , born, gone] = data.lines,
        { forward, right, up } = axes(state.camera),
        [now, from, to] = scene.span(state),
        rows = [right, up, forward].map((row) => [...row.map((c, i) => (c * side[i]) / flow.steps), dot(row, low) - dot(row, state.camera.eye)]),
        seen = (i) => rows.map((row) => row[0] * px[i] + row[1] * py[i] + row[2] * pz[i] + row[3]),
        clipped = (i) => state.clip[3] < [px, py, pz].reduce((sum, column, c) => sum + state.clip[c] * (low[c] + (column[i] / flow.steps) * side[c]), 0);
    let best = null,
        nearest = Infinity;
    for (let i = from; i < to; ++i) {
        const point = scene.kept[i],
            line = scene.pieces.owners[point];
        const begin = Math.max(now - flow.tail / flow.tick, born[line]),
            length = Math.max(time[point + 1] - time[point], 1);
        if (time[point + 1] <= begin || time[point] >= now || (gone[line] !== 65535 && gone[line] <= now)) continue;
        if (data.scalars[state.shownBy][point] < state.least * 254 || clipped(point)) continue;
        const [a, b] = [seen(point), seen(point + 1)];
        if (a[2] <= 0 || b[2] <= 0) continue;
        const [ax, ay, bx, by] = [a, b].flatMap((end) => [(end[0] / end[2]) * focal, (end[1] / end[2]) * focal]);
        const [dx, dy] = [bx - ax, by - ay],
            along = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1);
        const share = Math.min(Math.max(along, 0, (begin - time[point]) / length), 1, (now - time[point]) / length);
        const depth = a[2] + share * (b[2] - a[2]);
        if (Math.hypot(ax + share * dx - x, ay + share * dy - y) > kNear || depth >= nearest) continue;
        nearest = depth;
        best = { line, point, share, time: time[point] + share * length };
    }
    return best;
}
