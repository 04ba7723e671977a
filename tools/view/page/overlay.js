// Outlines and handles over the picture.

import { axes, project, unitsPerPixel } from "./camera.js";
import { makeSvg, short } from "./elements.js";
import { add, dot, normalize, scale, turn } from "./vector.js";

const kTip = 55; // pixels from a plane's point to the tip of its normal
const kKeyTurn = (5 * Math.PI) / 180;

export class Overlay {
    /// @param camera () => the camera now @param hold (held): tells that a hand is on a handle
    constructor(camera, hold) {
        Object.assign(this, { camera, hold });
        this.layers = []; // () => adds outlines and handles
        this.svg = document.getElementById("overlay");
        this.svg.addEventListener("contextmenu", (event) => event.preventDefault());
    }

    /// @param scene as the server tells it
    show(scene) {
        this.stretch = scene.stretch;
        this.draw();
    }

    /// Draw again; the focus stays.
    draw() {
        if (!this.stretch || !this.camera()) return;
        const focused = this.svg.contains(document.activeElement) && document.activeElement.getAttribute("aria-label");
        this.svg.replaceChildren();
        for (const layer of this.layers) layer();
        if (focused) this.svg.querySelector(`[aria-label="${focused}"]`)?.focus();
    }

    get pixel() {
        return unitsPerPixel(this.camera(), this.svg.clientHeight);
    }

    /// @param point in the data's own space
    onScreen(point) {
        return this.seen(point.map((c, i) => c * this.stretch[i]));
    }
    seen(point) {
        return project(this.camera(), point, this.svg.clientWidth, this.svg.clientHeight);
    }

    outline(points, kind) {
        const places = points.map((point) => this.onScreen(point));
        if (places.some((place) => !place)) return;
        const text = places.map((p) => p.join(",")).join(" ");
        this.svg.append(makeSvg("polygon", { class: `outline ${kind}`, points: text }));
    }

    /// A handle that moves a point along a line. @param move (point, commit) @param end once the hand lets go
    slider(point, direction, name, kind, move, end) {
        const at = this.onScreen(point);
        if (!at) return;
        const unit = 40 * this.pixel;
        const further = this.onScreen(add(point, scale(direction, unit)));
        const along = further ? [further[0] - at[0], further[1] - at[1]] : [1, 0];
        const square = Math.max(along[0] ** 2 + along[1] ** 2, 25);
        const moved = (x, y) => add(point, scale(direction, (unit * (x * along[0] + y * along[1])) / square));
        const handle = this.handle(at, name, kind, {
            "aria-valuenow": short(dot(point, direction)),
            keydown: (event) => {
                const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
                if (!sign) return;
                event.preventDefault();
                move(add(point, scale(direction, (sign * unit) / 4)), true);
            },
        });
        this.drag(handle, () => (x, y) => move(moved(x, y), false), end);
    }

    /// A handle at the tip of a plane's normal: the tip follows the hand on a sphere around the plane's point, and
    /// beyond the sphere's outline goes on at its back. @param move (normal, commit)
    tip(point, normal, name, kind, move, end) {
        const { forward, right, up } = axes(this.camera());
        const seen = normalize(normal.map((c, i) => c / this.stretch[i])); // normals are covectors
        const told = (turned, commit) => move(normalize(turned.map((c, i) => c * this.stretch[i])), commit);
        const center = point.map((c, i) => c * this.stretch[i]);
        const from = this.seen(center),
            at = this.seen(add(center, scale(seen, kTip * this.pixel)));
        if (!from || !at) return;
        this.svg.append(makeSvg("line", { class: "normal", x1: from[0], y1: from[1], x2: at[0], y2: at[1] }));
        const text = normal.map((c) => short(c.toFixed(2))).join(" ");
        const handle = this.handle(at, name, `tip ${kind}`, {
            "aria-valuenow": Math.round((Math.acos(Math.max(-1, Math.min(1, normal[2]))) * 180) / Math.PI),
            "aria-valuetext": `normal ${text}`,
            keydown: (event) => {
                const angle = event.shiftKey ? kKeyTurn / 5 : kKeyTurn;
                const turns = {
                    ArrowRight: [up, angle],
                    ArrowLeft: [up, -angle],
                    ArrowUp: [right, -angle],
                    ArrowDown: [right, angle],
                }[event.key];
                if (!turns) return;
                event.preventDefault();
                told(turn(seen, ...turns), true);
            },
        });
        this.drag(
            handle,
            () => {
                let side = dot(seen, forward) > 0.01 ? -1 : 1, // towards the eye or away from it
                    isBeyond = false;
                return (x, y) => {
                    const place = [dot(seen, right) + x / kTip, dot(seen, up) - y / kTip];
                    const reach = Math.hypot(...place);
                    if (isBeyond && reach <= 1) side = -side;
                    isBeyond = reach > 1;
                    const [a, b] = isBeyond ? place.map((c) => c / reach) : place;
                    const depth = side * Math.sqrt(Math.max(0, 1 - a * a - b * b));
                    told(add(add(scale(right, a), scale(up, b)), scale(forward, -depth)), false);
                };
            },
            end,
        );
    }

    handle([cx, cy], name, kind, properties) {
        const circle = makeSvg("circle", {
            class: `handle ${kind}`,
            cx,
            cy,
            r: 8,
            tabindex: 0,
            role: "slider",
            "aria-label": name,
            ...properties,
        });
        this.svg.append(circle);
        return circle;
    }

    /// @param begin () => a function of the pixels that the hand has gone to the right and down
    drag(handle, begin, end) {
        handle.addEventListener("pointerdown", (event) => {
            event.preventDefault();
            this.hold(true);
            const go = begin();
            const onMove = (now) => go(now.clientX - event.clientX, now.clientY - event.clientY);
            const onEnd = () => {
                removeEventListener("pointermove", onMove);
                for (const type of ["pointerup", "pointercancel"]) removeEventListener(type, onEnd);
                this.hold(false);
                end();
            };
            addEventListener("pointermove", onMove);
            for (const type of ["pointerup", "pointercancel"]) addEventListener(type, onEnd);
        });
    }
}
