// The colour points on the ramp below a histogram: as others, and choose a colour.

import { channels, hexOf, make, makeLine, makeSvg, short } from "./elements.js";
import { Points } from "./points.js";

/// The colour of points [position, hex] at a position, linear between them as the renderer has it.
export function colorAt(points, position) {
    const after = points.findIndex((point) => point[0] > position);
    if (after <= 0) return points.at(after)[1];
    const [before, next] = [points[after - 1], points[after]];
    const share = (position - before[0]) / (next[0] - before[0]);
    const [from, to] = [channels(before[1]), channels(next[1])];
    return hexOf(from.map((c, i) => c + (to[i] - c) * share));
}

export class ColorPoints extends Points {
    constructor(transfer, curve) {
        super(transfer, curve, "color");
        this.chosen = 0;
        this.label = make("label", { for: "point-color", class: "name" });
        this.input = make("input", { id: "point-color", type: "color", class: "swatch" });
        this.input.addEventListener("input", () => this.paint(false));
        this.input.addEventListener("change", () => transfer.store.commit());
        this.away = make(
            "button",
            { id: "remove-color", "aria-label": "Remove the colour point", click: () => this.remove(this.chosen) },
            "Remove",
        );
        this.element = makeLine(
            this.label,
            this.input,
            make(
                "button",
                { id: "add-color", "aria-label": "Add a colour point", click: () => this.addAfter(this.chosen) },
                "Add",
            ),
            this.away,
        );
    }

    get points() {
        return this.transfer.colors;
    }

    /// @param y of the ramp's middle @return the points as elements
    draw(y) {
        this.chosen = Math.min(this.chosen, this.points.length - 1);
        this.label.textContent = `Colour ${this.chosen + 1} of ${this.points.length}`;
        if (!this.input.matches(":focus")) this.input.value = this.points[this.chosen][1];
        this.away.disabled = this.points.length < 2;
        return this.points.map(([position, color], index) =>
            makeSvg("circle", {
                class: index === this.chosen ? "color chosen" : "color",
                "data-color": index,
                cx: this.curve.inside(this.curve.xOfPosition(position)),
                cy: y,
                r: 7,
                fill: color,
                tabindex: 0,
                role: "slider",
                "aria-valuemin": 0,
                "aria-valuemax": 1,
                "aria-valuenow": short(position),
                "aria-valuetext": `${color} at ${short(this.curve.valueOfPosition(position))}`,
                "aria-label": `Colour point ${index + 1} of ${this.points.length}`,
                focus: () => this.choose(index),
                keydown: (event) => this.key(event, index),
            }),
        );
    }

    choose(index) {
        if (index === this.chosen) return;
        this.chosen = index;
        this.input.value = this.points[index][1]; // also while it has the focus
        this.curve.redraw();
    }

    set(points, commit) {
        this.transfer.setColors(points, commit);
    }

    paint(commit) {
        const all = this.points.map((point, i) => (i === this.chosen ? [point[0], this.input.value] : point));
        this.set(all, commit);
    }

    newValue(position) {
        return colorAt(this.points, position);
    }

    draggedValue(index) {
        return this.points[index][1];
    }

    nudge(index, x, y) {
        const [position, color] = this.points[index];
        this.move(index, position + x + y, color, true);
    }

    insert(position, color, commit) {
        const index = super.insert(position, color, commit);
        if (index >= 0) this.choose(index);
        return index;
    }

    remove(index) {
        this.chosen = Math.max(0, index - 1);
        super.remove(index);
    }
}
