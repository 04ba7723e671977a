// The opacity points over a histogram: drag, add, remove.

import { makeSvg, short } from "./elements.js";

const kApart = 1e-3; // least distance of two points

export class OpacityPoints {
    /// @param curve over which the points stand
    constructor(transfer, curve) {
        Object.assign(this, { transfer, curve });
    }

    get points() {
        return this.transfer.points;
    }

    /// @param width of the drawing @return the curve and its points as elements
    draw(width) {
        const { points, curve } = this;
        const at = points.map(([position, opacity]) => [curve.xOfPosition(position), curve.yOf(opacity)]);
        const path = [[0, at[0][1]], ...at, [width, at.at(-1)[1]]]
            .map((p) => p.map((c) => c.toFixed(1)).join(","))
            .join(" ");
        return [
            makeSvg("polyline", { class: "opacity", points: path }),
            ...at.map(([x, y], index) =>
                makeSvg("circle", {
                    class: "point",
                    "data-index": index,
                    cx: curve.inside(x),
                    cy: y,
                    r: 6.5,
                    tabindex: 0,
                    role: "slider",
                    "aria-valuemin": 0,
                    "aria-valuemax": 1,
                    "aria-label": `Opacity point ${index + 1} of ${at.length}`,
                    "aria-valuenow": short(points[index][1]),
                    "aria-valuetext": `opacity ${short(points[index][1])} at ${short(curve.valueAt(x))}`,
                    keydown: (event) => this.key(event, index),
                }),
            ),
        ];
    }

    /// @param index of the point that was hit, if any
    press(event, x, y, index) {
        if (index !== undefined && event.button === 2) return this.remove(index);
        const { curve } = this,
            at = index ?? this.insert(curve.positionAt(x), curve.opacityAt(y));
        if (at < 0) return;
        curve.drag(event, (toX, toY) => this.move(at, curve.positionAt(toX), curve.opacityAt(toY)));
        curve.focus("index", at);
    }

    set(points, commit) {
        this.transfer.setPoints(points, commit);
    }

    move(index, position, opacity, commit = false) {
        const { points } = this;
        const low = index > 0 ? points[index - 1][0] + kApart : 0;
        const high = index + 1 < points.length ? points[index + 1][0] - kApart : 1;
        const moved = [Math.max(low, Math.min(high, position)), opacity];
        this.set(
            points.map((point, i) => (i === index ? moved : point)),
            commit,
        );
    }

    /// @return the new point's index, or -1 where there is no room
    insert(position, opacity, commit = false) {
        const { points } = this;
        if (position < 0 || position > 1 || points.some((point) => Math.abs(point[0] - position) < 2 * kApart))
            return -1;
        const index = points.filter((point) => point[0] < position).length;
        this.set([...points.slice(0, index), [position, opacity], ...points.slice(index)], commit);
        return index;
    }

    remove(index) {
        if (this.points.length < 2) return;
        this.set(
            this.points.filter((_, i) => i !== index),
            true,
        );
    }

    key(event, index) {
        const [position, opacity] = this.points[index],
            small = event.shiftKey ? 0.002 : 0.02;
        const moves = { ArrowLeft: [-small, 0], ArrowRight: [small, 0], ArrowUp: [0, small], ArrowDown: [0, -small] };
        if (event.key === "Delete" || event.key === "Backspace") {
            this.remove(index);
            this.curve.focus("index", Math.min(index, this.points.length - 1));
        } else if (event.key === "Enter" || event.key === "Insert") {
            this.insert((position + (this.points[index + 1]?.[0] ?? 1)) / 2, opacity, true);
        } else if (moves[event.key]) {
            const height = this.transfer.heightOf(opacity) + moves[event.key][1];
            this.move(index, position + moves[event.key][0], this.transfer.opacityAt(height), true);
        } else {
            return;
        }
        event.preventDefault();
        event.stopPropagation();
    }
}
