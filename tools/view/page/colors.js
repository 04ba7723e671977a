// The colour points on the ramp below a histogram: drag, add, remove, choose a colour.

import { make, makeSvg, short } from "./elements.js";

const kApart = 1e-3; // least distance of two points

const channels = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
const hexOf = (color) => "#" + color.map((c) => Math.round(c).toString(16).padStart(2, "0")).join("");

/// The colour of points [position, hex] at a position, linear between them as the renderer has it.
export function colorAt(points, position) {
    const after = points.findIndex((point) => point[0] > position);
    if (after <= 0) return points.at(after)[1];
    const [before, next] = [points[after - 1], points[after]];
    const share = (position - before[0]) / (next[0] - before[0]);
    const [from, to] = [channels(before[1]), channels(next[1])];
    return hexOf(from.map((c, i) => c + (to[i] - c) * share));
}

export class ColorPoints {
    /// @param curve whose ramp the points stand on
    constructor(transfer, curve) {
        Object.assign(this, { transfer, curve });
        this.chosen = 0;
        this.name = make("label", { for: "point-color", class: "name" });
        this.input = make("input", { id: "point-color", type: "color", class: "swatch" });
        this.input.addEventListener("input", () => this.paint(false));
        this.input.addEventListener("change", () => transfer.store.commit());
        this.away = make(
            "button",
            { id: "remove-color", "aria-label": "Remove the colour point", click: () => this.remove(this.chosen) },
            "Remove",
        );
        this.element = make(
            "div",
            { class: "line" },
            this.name,
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
        this.name.textContent = `Colour ${this.chosen + 1} of ${this.points.length}`;
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

    /// @param index of the point that was hit, if any
    press(event, x, index) {
        if (index !== undefined && event.button === 2) return this.remove(index);
        const { curve } = this,
            at = index ?? this.insert(curve.positionAt(x));
        if (at < 0) return;
        curve.drag(event, (toX) => this.move(at, curve.positionAt(toX)));
        curve.focus("color", at);
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
        this.set(
            this.points.map((point, i) => (i === this.chosen ? [point[0], this.input.value] : point)),
            commit,
        );
    }

    move(index, position, commit = false) {
        const low = index > 0 ? this.points[index - 1][0] + kApart : 0;
        const high = index + 1 < this.points.length ? this.points[index + 1][0] - kApart : 1;
        const place = Math.max(low, Math.min(high, position));
        this.set(
            this.points.map((point, i) => (i === index ? [place, point[1]] : point)),
            commit,
        );
    }

    /// Add a point of the colour that is there. @return its index, or -1 where there is no room
    insert(position, commit = false) {
        const { points } = this;
        if (position < 0 || position > 1 || points.some((point) => Math.abs(point[0] - position) < 2 * kApart))
            return -1;
        const index = points.filter((point) => point[0] < position).length;
        this.chosen = index;
        this.set([...points.slice(0, index), [position, colorAt(points, position)], ...points.slice(index)], commit);
        return index;
    }

    /// Add a point between a point and the next one, or before the last one.
    addAfter(index) {
        const { points } = this,
            next = points[index + 1]?.[0] ?? (points[index][0] < 1 ? 1 : points[index - 1]?.[0] ?? 0);
        this.insert((points[index][0] + next) / 2, true);
    }

    remove(index) {
        if (this.points.length < 2) return;
        this.chosen = Math.max(0, index - 1);
        this.set(
            this.points.filter((_, i) => i !== index),
            true,
        );
    }

    key(event, index) {
        const small = event.shiftKey ? 0.002 : 0.02,
            step = { ArrowLeft: -small, ArrowDown: -small, ArrowRight: small, ArrowUp: small }[event.key];
        if (event.key === "Delete" || event.key === "Backspace") {
            this.remove(index);
            this.curve.focus("color", Math.min(index, this.points.length - 1));
        } else if (event.key === "Enter" || event.key === "Insert") this.addAfter(index);
        else if (step) this.move(index, this.points[index][0] + step, true);
        else return;
        event.preventDefault();
        event.stopPropagation();
    }
}
