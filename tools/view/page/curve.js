// The panel of one scalar: its histogram and its range, under the points of the colour and opacity that follow it.

import { Axis } from "./axis.js";
import { ColorPoints, colorAt } from "./colors.js";
import { isEdited, make, makeLine, makeSvg, short } from "./elements.js";
import { OpacityPoints } from "./opacity.js";

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
        this.stop = "[data-index]"; // of Tab
        this.title = make("span", { class: "name" });
        this.log = make("input", {
            id: `option-${options.scale}`,
            type: "checkbox",
            "aria-label": `${name}: logarithmic scale`,
            change: () => this.setScale(this.log.checked),
        });
        this.opacity = new OpacityPoints(transfer, this);
        this.colors = options.range === "range" ? new ColorPoints(transfer, this) : null;
        this.element = make(
            "div",
            { class: "panel" },
            this.svg,
            makeLine(this.title, ...this.ends, make("label", {}, this.log, " log")),
            ...(this.colors ? [this.colors.element] : []),
        );
        this.svg.addEventListener("pointerdown", (event) => this.press(event));
        this.svg.addEventListener("keydown", (event) => this.goTo(event));
        this.svg.addEventListener("focusin", (event) => this.setStop(event.target));
        for (const type of ["dblclick", "contextmenu"])
            this.svg.addEventListener(type, (event) => event.preventDefault());
    }

    draw(range, scale, histogram, name, hasPoints) {
        Object.assign(this, { range, scale, histogram, hasPoints });
        this.axis = new Axis(range, scale);
        this.view = new Axis([histogram.low, histogram.high], histogram.scale);
        this.log.checked = scale === "log";
        this.title.textContent = name;
        this.ends.forEach((input, end) => {
            if (!isEdited(input)) input.value = short(range[end]);
        });
        this.redraw();
    }

    redraw() {
        const focused = this.svg.contains(document.activeElement) ? { ...document.activeElement.dataset } : {};
        this.svg.replaceChildren(
            ...this.bars(),
            ...this.ramp(),
            ...this.rangeEnds(),
            ...(this.hasPoints ? this.opacity.draw(kWidth) : []),
            ...(this.colors ? this.colors.draw(kRamp + kRampHeight / 2) : []),
        );
        this.setStop(this.stops.find((stop) => stop.matches(this.stop)) || this.stops[0]);
        for (const [name, value] of Object.entries(focused)) this.focus(name, value);
    }

    /// The points. Tab reaches one of them; from there Page Up and Page Down go to the others.
    get stops() {
        return [...this.svg.querySelectorAll("[tabindex]")];
    }

    setStop(point) {
        if (!point?.matches("[tabindex]")) return;
        for (const other of this.stops) other.setAttribute("tabindex", other === point ? 0 : -1);
        const [[name, value]] = Object.entries(point.dataset);
        this.stop = `[data-${name}="${value}"]`;
    }

    goTo(event) {
        const { stops } = this,
            at = stops.indexOf(event.target);
        const to = { PageUp: at - 1, PageDown: at + 1, Home: 0, End: stops.length - 1 }[event.key];
        if (to === undefined || at < 0) return;
        stops[Math.max(0, Math.min(to, stops.length - 1))].focus();
        event.preventDefault();
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
            scaled = Math.log1p;
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

    place(event) {
        const box = this.svg.getBoundingClientRect();
        return [((event.clientX - box.left) / box.width) * kWidth, ((event.clientY - box.top) / box.height) * kHeight];
    }

    press(event) {
        const { end, index, color } = event.target.dataset,
            [x, y] = this.place(event);
        if (end !== undefined) return this.drag(event, (toX) => this.dragEnd(Number(end), toX));
        const number = (text) => (text === undefined ? undefined : Number(text)),
            isOnRamp = y >= kRamp && y <= kRamp + kRampHeight;
        if (this.colors && isOnRamp && index === undefined) this.colors.press(event, [x, y], number(color));
        else if (this.hasPoints && (index !== undefined || y < kRamp)) this.opacity.press(event, [x, y], number(index));
    }

    /// @param move called with the places to which the hand goes
    drag(event, move) {
        event.preventDefault();
        this.transfer.dragging = true;
        this.svg.setPointerCapture(event.pointerId);
        const onMove = (moved) => move(...this.place(moved));
        const onEnd = () => {
            this.svg.removeEventListener("pointermove", onMove);
            this.transfer.letGo();
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
            changes = { ...transfer.frozenView(), [this.options.range]: this.range };
        if (transfer.scene) transfer.scene[this.colors ? "range" : "opacityRange"] = this.range;
        transfer.draw();
        if (this.hasPoints && !transfer.store.options.opacity) transfer.setPoints(transfer.points, false);
        transfer.store.change(changes, { commit });
    }
}
