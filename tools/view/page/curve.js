// The panel of one scalar: its histogram, the range, and the opacity points if it makes opaque.

import { Axis } from "./axis.js";
import { ColorPoints, colorAt } from "./colors.js";
import { make, makeSvg, short } from "./elements.js";

// In units of the drawing.
const kWidth = 320;
const kHeight = 184;
const kTop = 12;
const kBottom = 132;
const kRamp = 141;
const kRampHeight = 16;

export class Curve {
    /// @param options { range, scale }: the names of the options that set them
    constructor(transfer, options, name) {
        this.transfer = transfer;
        this.options = options;
        this.svg = makeSvg("svg", {
            class: "curve",
            viewBox: `0 0 ${kWidth} ${kHeight}`,
            preserveAspectRatio: "none",
            role: "group",
            "aria-label": `${name}: histogram and curve`,
        });
        this.ends = [0, 1].map((end) =>
            make("input", {
                type: "number",
                step: "any",
                "aria-label": `${name}: ${end ? "upper" : "lower"} end of the range`,
                change: () => this.typeRange(),
            }),
        );
        this.title = make("span", { class: "name" });
        this.log = make("input", {
            id: `option-${options.scale}`,
            type: "checkbox",
            "aria-label": `${name}: logarithmic scale`,
            change: () => this.setScale(this.log.checked),
        });
        this.colors = options.range === "range" ? new ColorPoints(transfer, this) : null;
        this.element = make(
            "div",
            { class: "panel" },
            this.svg,
            make("div", { class: "line" }, this.title, ...this.ends, make("label", {}, this.log, " log")),
            ...(this.colors ? [this.colors.element] : []),
        );
        this.svg.addEventListener("pointerdown", (event) => this.press(event));
        this.svg.addEventListener("dblclick", (event) => event.preventDefault());
    }

    draw(range, scale, histogram, name, hasPoints) {
        Object.assign(this, { range, scale, histogram, hasPoints });
        this.axis = new Axis(range, scale);
        this.view = new Axis([histogram.low, histogram.high], histogram.scale);
        this.log.checked = scale === "log";
        this.title.textContent = name;
        this.ends.forEach((input, end) => {
            if (!input.matches(":focus")) input.value = short(range[end]);
        });
        this.redraw();
    }

    redraw() {
        const focused = this.svg.contains(document.activeElement) ? { ...document.activeElement.dataset } : {};
        this.svg.replaceChildren(
            ...this.bars(),
            ...this.ramp(),
            ...this.rangeEnds(),
            ...(this.hasPoints ? this.curve() : []),
            ...(this.colors ? this.colors.draw(kRamp + kRampHeight / 2) : []),
        );
        for (const [name, value] of Object.entries(focused)) this.focus(name, value);
    }

    /// Focus a point. @param name index of an opacity point or color of a colour point
    focus(name, value) {
        this.svg.querySelector(`[data-${name}="${value}"]`)?.focus();
    }

    xOf(value) {
        return this.view.placeOf(value) * kWidth;
    }
    valueAt(x) {
        return this.view.valueAt(x / kWidth);
    }
    valueOfPosition(position) {
        return this.axis.valueAt(position);
    }
    xOfPosition(position) {
        return this.xOf(this.valueOfPosition(position));
    }
    positionAt(x) {
        return this.axis.placeOf(this.valueAt(x));
    }

    /// A place at which a handle is not cut off.
    inside(x) {
        return Math.max(6, Math.min(kWidth - 6, x));
    }

    yOf(opacity) {
        return kBottom + (kTop - kBottom) * this.transfer.heightOf(opacity);
    }

    opacityAt(y) {
        return this.transfer.opacityAt((y - kBottom) / (kTop - kBottom));
    }

    colorAt(position) {
        return this.colors ? colorAt(this.transfer.colors, position) : "var(--quiet)";
    }

    bars() {
        const { counts } = this.histogram,
            scaled = (count) => (this.transfer.logCounts.checked ? Math.log1p(count) : count);
        const most = Math.max(...counts.map(scaled)) || 1,
            width = kWidth / counts.length;
        return counts.map((count, i) => {
            const height = (scaled(count) / most) * (kBottom - kTop);
            return makeSvg("rect", {
                class: "bars",
                x: i * width,
                y: kBottom - height,
                width: width + 0.2,
                height,
                fill: this.colorAt(this.positionAt((i + 0.5) * width)),
            });
        });
    }

    ramp() {
        if (!this.colors) return [];
        const count = 128,
            width = kWidth / count;
        return Array.from({ length: count }, (_, i) =>
            makeSvg("rect", {
                x: i * width,
                y: kRamp,
                width: width + 0.3,
                height: kRampHeight,
                fill: this.colorAt(this.positionAt((i + 0.5) * width)),
            }),
        );
    }

    rangeEnds() {
        return [0, 1].flatMap((end) => {
            const x = this.xOfPosition(end);
            return [
                makeSvg("line", { class: "end", x1: x, x2: x, y1: kTop, y2: kHeight - 9 }),
                makeSvg("circle", {
                    class: "grip",
                    "data-end": end,
                    cx: this.inside(x),
                    cy: kHeight - 9,
                    r: 7,
                }),
            ];
        });
    }

    curve() {
        const { points } = this.transfer;
        const at = points.map(([position, opacity]) => [this.xOfPosition(position), this.yOf(opacity)]);
        const path = [[0, at[0][1]], ...at, [kWidth, at.at(-1)[1]]]
            .map((p) => p.map((c) => c.toFixed(1)).join(","))
            .join(" ");
        return [
            makeSvg("polyline", { class: "opacity", points: path }),
            ...at.map(([cx, cy], index) =>
                makeSvg("circle", {
                    class: "point",
                    "data-index": index,
                    cx: this.inside(cx),
                    cy,
                    r: 6.5,
                    tabindex: 0,
                    role: "slider",
                    "aria-valuemin": 0,
                    "aria-valuemax": 1,
                    "aria-label": `Opacity point ${index + 1} of ${at.length}`,
                    "aria-valuenow": short(points[index][1]),
                    "aria-valuetext": `opacity ${short(points[index][1])} at ${short(this.valueAt(cx))}`,
                    keydown: (event) => this.key(event, index),
                }),
            ),
        ];
    }

    place(event) {
        const box = this.svg.getBoundingClientRect();
        return [((event.clientX - box.left) / box.width) * kWidth, ((event.clientY - box.top) / box.height) * kHeight];
    }

    press(event) {
        const { end, index, color } = event.target.dataset,
            [x, y] = this.place(event);
        if (end !== undefined) return this.drag(event, (toX) => this.dragEnd(Number(end), toX));
        if (this.colors && index === undefined && y >= kRamp && y <= kRamp + kRampHeight)
            return this.pressColor(event, x, color);
        if (!this.hasPoints) return;
        if (index !== undefined && event.button === 2) return this.remove(Number(index));
        const at = index !== undefined ? Number(index) : y < kRamp ? this.insert(x, y) : -1;
        if (at < 0) return;
        this.drag(event, (toX, toY) => this.movePoint(at, this.positionAt(toX), this.opacityAt(toY)));
        this.focus("index", at);
    }

    /// @param color index of the colour point that was hit, if any
    pressColor(event, x, color) {
        if (color !== undefined && event.button === 2) return this.colors.remove(Number(color));
        const at = color !== undefined ? Number(color) : this.colors.insert(this.positionAt(x));
        if (at < 0) return;
        this.drag(event, (toX) => this.colors.move(at, this.positionAt(toX)));
        this.focus("color", at);
    }

    drag(event, move) {
        event.preventDefault();
        this.transfer.dragging = true;
        this.svg.setPointerCapture(event.pointerId);
        const onMove = (moved) => move(...this.place(moved));
        const onEnd = () => {
            this.svg.removeEventListener("pointermove", onMove);
            this.transfer.dragging = false;
            this.transfer.store.commit();
        };
        this.svg.addEventListener("pointermove", onMove);
        for (const type of ["pointerup", "pointercancel"]) this.svg.addEventListener(type, onEnd, { once: true });
    }

    dragEnd(end, x) {
        const range = [...this.range],
            other = this.xOf(range[1 - end]),
            least = kWidth / 200;
        const bounded = Math.max(0, Math.min(kWidth, x));
        range[end] = this.valueAt(end ? Math.max(bounded, other + least) : Math.min(bounded, other - least));
        this.setRange(range, false);
    }

    typeRange() {
        const range = this.ends.map((input) => input.valueAsNumber);
        const isPossible = range.every(Number.isFinite) && range[0] < range[1] && (range[0] > 0 || !this.axis.isLog);
        if (isPossible) this.setRange(range, true);
        else this.transfer.draw();
    }

    /// Positions stay, so points move to other values; a range that cannot be logarithmic becomes automatic.
    setScale(isLog) {
        const changes = { [this.options.scale]: isLog ? "log" : "linear" };
        if (isLog && !(this.range[0] > 0)) changes[this.options.range] = undefined;
        this.transfer.store.change(changes);
    }

    setRange(range, commit) {
        this.range = range.map((value) => Number(value.toPrecision(6)));
        const { transfer } = this,
            changes = { [this.options.range]: this.range };
        if (transfer.scene) transfer.scene[this.colors ? "range" : "opacityRange"] = this.range;
        transfer.draw();
        if (this.hasPoints && !transfer.store.options.opacity) transfer.setPoints(transfer.points, false);
        transfer.store.change(changes, { commit });
    }

    movePoint(index, position, opacity, commit = false) {
        const points = this.transfer.points.map((point) => [...point]);
        const before = index > 0 ? points[index - 1][0] + 1e-3 : 0;
        const after = index + 1 < points.length ? points[index + 1][0] - 1e-3 : 1;
        points[index] = [Math.max(before, Math.min(after, position)), opacity];
        this.transfer.setPoints(points, commit);
    }

    /// @return the new point's index, or -1 where there is no room
    insert(x, y) {
        const position = this.positionAt(x),
            { points } = this.transfer;
        if (position < 0 || position > 1 || points.some((point) => Math.abs(point[0] - position) < 2e-3)) return -1;
        const index = points.filter((point) => point[0] < position).length;
        this.transfer.setPoints(
            [...points.slice(0, index), [position, this.opacityAt(y)], ...points.slice(index)],
            false,
        );
        return index;
    }

    remove(index) {
        if (this.transfer.points.length < 2) return;
        this.transfer.setPoints(
            this.transfer.points.filter((_, i) => i !== index),
            true,
        );
    }

    key(event, index) {
        const [position, opacity] = this.transfer.points[index],
            small = event.shiftKey ? 0.002 : 0.02;
        const moves = { ArrowLeft: [-small, 0], ArrowRight: [small, 0], ArrowUp: [0, small], ArrowDown: [0, -small] };
        if (event.key === "Delete" || event.key === "Backspace") {
            this.remove(index);
        } else if (event.key === "Enter" || event.key === "Insert") {
            const next = this.transfer.points[index + 1]?.[0] ?? 1;
            if (next - position > 4e-3) this.insert(this.xOfPosition((position + next) / 2), this.yOf(opacity));
            this.transfer.store.commit();
        } else if (moves[event.key]) {
            const y = this.yOf(opacity) - moves[event.key][1] * (kBottom - kTop);
            this.movePoint(index, position + moves[event.key][0], this.opacityAt(y), true);
        } else {
            return;
        }
        event.preventDefault();
        event.stopPropagation();
    }
}
