// The opacity points over a histogram.

import { makeSvg, short } from "./elements.js";
import { Points } from "./points.js";

export class OpacityPoints extends Points {
    constructor(transfer, curve) {
        super(transfer, curve, "index");
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

    set(points, commit) {
        this.transfer.setPoints(points, commit);
    }

    /// @param y of the hand; undefined: as the last point before the position
    newValue(position, y) {
        return y === undefined ? this.points.findLast((point) => point[0] <= position)[1] : this.curve.opacityAt(y);
    }

    draggedValue(index, y) {
        return this.curve.opacityAt(y);
    }

    nudge(index, x, y) {
        const [position, opacity] = this.points[index];
        this.move(index, position + x, this.transfer.opacityAt(this.transfer.heightOf(opacity) + y), true);
    }
}
