// Planes and a box that cut the volume, with handles over the picture.

import { axes, project, unitsPerPixel } from "./camera.js";
import { make, makeSection, makeSvg, short } from "./elements.js";
import { add, cross, dot, length, normalize, scale, subtract } from "./vector.js";

export class Cuts {
    /// @param camera () => the camera now
    constructor(store, camera, hold) {
        Object.assign(this, { store, camera, hold });
        this.svg = document.getElementById("overlay");
        this.list = make("div", { class: "line" });
        const planeButton = (name, normal) => make("button", { click: () => this.addPlane(normal()) }, name);
        this.box = make("input", { id: "cut-box", type: "checkbox", change: () => this.toggleBox() });
        this.handles = make("input", { id: "cut-handles", type: "checkbox", checked: true, change: () => this.draw() });
        this.element = makeSection(
            "Cuts",
            false,
            make(
                "div",
                { class: "line" },
                make("span", { class: "name" }, "Add plane"),
                planeButton("x", () => [1, 0, 0]),
                planeButton("y", () => [0, 1, 0]),
                planeButton("z", () => [0, 0, 1]),
                planeButton("view", () => axes(this.camera()).forward),
            ),
            this.list,
            make(
                "div",
                { class: "line" },
                make("label", {}, this.box, " box"),
                make("label", {}, this.handles, " handles"),
            ),
        );
        this.element.addEventListener("toggle", () => this.draw());
    }

    get planes() {
        return this.store.options["clip-plane"] || [];
    }

    show(scene) {
        this.scene = scene;
        const corners = scene.box.map((corner) => corner.map((c, i) => c / scene.stretch[i])); // the data's own space
        this.low = [0, 1, 2].map((i) => Math.min(...corners.map((c) => c[i])));
        this.high = [0, 1, 2].map((i) => Math.max(...corners.map((c) => c[i])));
        this.box.checked = Boolean(this.store.options["clip-box"]);
        this.listPlanes();
        this.draw();
    }

    addPlane(normal) {
        if (!this.scene) return;
        const middle = scale(add(this.low, this.high), 0.5);
        this.store.change({
            "clip-plane": [...this.planes, [...middle, ...normal].map((c) => Number(c.toPrecision(6)))],
        });
        this.listPlanes();
    }

    setPlanes(planes, commit) {
        this.store.change({ "clip-plane": planes.length ? planes : undefined }, { commit });
        this.draw();
    }

    toggleBox() {
        this.store.change({ "clip-box": this.box.checked ? [...this.low, ...this.high] : undefined });
        this.draw();
    }

    /// A row for each plane: its place along the normal, the other side, and away with it.
    listPlanes() {
        if (
            this.list.contains(document.activeElement) &&
            this.list.querySelectorAll("input").length === this.planes.length
        )
            return;
        const reach = length(subtract(this.high, this.low)) / 2,
            middle = scale(add(this.low, this.high), 0.5);
        this.list.replaceChildren(
            ...this.planes.flatMap((plane, index) => {
                const normal = normalize(plane.slice(3));
                const slider = make("input", {
                    type: "range",
                    min: -reach,
                    max: reach,
                    step: reach / 200,
                    "aria-label": `Place of plane ${index + 1}`,
                });
                slider.value = dot(subtract(plane.slice(0, 3), middle), normal);
                const move = (commit) =>
                    this.movePlane(index, add(middle, scale(normal, slider.valueAsNumber)), commit);
                slider.addEventListener("input", () => move(false));
                slider.addEventListener("change", () => this.store.commit());
                const name = `Plane ${index + 1} (${normal.map((c) => short(c.toFixed(2))).join(" ")})`;
                return [
                    make("span", { class: "name" }, name),
                    slider,
                    make(
                        "button",
                        {
                            "aria-label": `Flip plane ${index + 1}`,
                            title: "Keep the other side",
                            click: () => this.flip(index),
                        },
                        "⇄",
                    ),
                    make(
                        "button",
                        { "aria-label": `Remove plane ${index + 1}`, title: "Remove", click: () => this.remove(index) },
                        "✕",
                    ),
                ];
            }),
        );
    }

    flip(index) {
        this.setPlanes(
            this.planes.map((p, i) => (i === index ? [...p.slice(0, 3), ...p.slice(3).map((c) => -c || 0)] : p)),
            true,
        );
        this.listPlanes();
    }

    remove(index) {
        this.setPlanes(
            this.planes.filter((_, i) => i !== index),
            true,
        );
        this.list.replaceChildren();
        this.listPlanes();
    }

    movePlane(index, point, commit) {
        const place = point.map((c) => Number(c.toPrecision(6)));
        this.setPlanes(
            this.planes.map((p, i) => (i === index ? [...place, ...p.slice(3)] : p)),
            commit,
        );
    }

    moveFace(axis, high, value, commit) {
        const box = [...this.store.options["clip-box"]],
            least = (this.high[axis] - this.low[axis]) / 100;
        const bounded = Math.max(this.low[axis], Math.min(this.high[axis], value));
        box[axis + 3 * high] = high ? Math.max(bounded, box[axis] + least) : Math.min(bounded, box[axis + 3] - least);
        this.store.change({ "clip-box": box.map((c) => Number(c.toPrecision(6))) }, { commit });
        this.draw();
    }

    draw() {
        const focused = this.svg.contains(document.activeElement) && document.activeElement.getAttribute("aria-label");
        this.svg.replaceChildren();
        if (!this.scene || !this.element.open || !this.handles.checked || !this.camera()) return;
        this.planes.forEach((plane, index) => this.drawPlane(plane, index));
        if (this.store.options["clip-box"]) this.drawBox(this.store.options["clip-box"]);
        if (focused) this.svg.querySelector(`[aria-label="${focused}"]`)?.focus();
    }

    onScreen(point) {
        const stretched = point.map((c, i) => c * this.scene.stretch[i]);
        return project(this.camera(), stretched, this.svg.clientWidth, this.svg.clientHeight);
    }

    outline(points) {
        const places = points.map((point) => this.onScreen(point));
        if (places.some((place) => !place)) return;
        this.svg.append(makeSvg("polygon", { class: "outline", points: places.map((p) => p.join(",")).join(" ") }));
    }

    drawPlane(plane, index) {
        const point = plane.slice(0, 3),
            normal = normalize(plane.slice(3));
        const side = normalize(cross(normal, Math.abs(normal[2]) > 0.9 ? [1, 0, 0] : [0, 0, 1])),
            other = cross(normal, side);
        const reach = length(subtract(this.high, this.low)) / 3;
        this.outline(
            [
                [1, 1],
                [1, -1],
                [-1, -1],
                [-1, 1],
            ].map(([a, b]) => add(point, add(scale(side, a * reach), scale(other, b * reach)))),
        );
        this.handle(point, normal, `Plane ${index + 1}`, (moved, commit) => this.movePlane(index, moved, commit));
    }

    drawBox(box) {
        const corner = (bits) => [0, 1, 2].map((i) => box[i + 3 * ((bits >> i) & 1)]);
        for (const face of [
            [0, 1, 3, 2],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 3, 7, 6],
        ])
            this.outline(face.map(corner));
        for (let axis = 0; axis < 3; ++axis) {
            for (const high of [0, 1]) {
                const point = [0, 1, 2].map((i) => (i === axis ? box[i + 3 * high] : (box[i] + box[i + 3]) / 2));
                const direction = [0, 1, 2].map((i) => (i === axis ? 1 : 0));
                this.handle(
                    point,
                    direction,
                    `${high ? "Upper" : "Lower"} ${"xyz"[axis]} side of the box`,
                    (moved, commit) => this.moveFace(axis, high, moved[axis], commit),
                );
            }
        }
    }

    /// A handle that moves along a line. @param move (point, commit)
    handle(point, direction, name, move) {
        const at = this.onScreen(point);
        if (!at) return;
        const unit = 40 * unitsPerPixel(this.camera(), this.svg.clientHeight);
        const further = this.onScreen(add(point, scale(direction, unit)));
        const along = further ? [further[0] - at[0], further[1] - at[1]] : [1, 0];
        const square = Math.max(along[0] ** 2 + along[1] ** 2, 25);
        const circle = makeSvg("circle", {
            class: "handle",
            cx: at[0],
            cy: at[1],
            r: 8,
            tabindex: 0,
            role: "slider",
            "aria-label": name,
            "aria-valuenow": short(dot(point, direction)),
        });
        const moved = (x, y) => add(point, scale(direction, (unit * (x * along[0] + y * along[1])) / square));
        circle.addEventListener("keydown", (event) => {
            const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
            if (!sign) return;
            event.preventDefault();
            move(add(point, scale(direction, (sign * unit) / 4)), true);
        });
        circle.addEventListener("pointerdown", (event) => {
            event.preventDefault();
            this.hold(true);
            const onMove = (now) => move(moved(now.clientX - event.clientX, now.clientY - event.clientY), false);
            const onEnd = () => {
                removeEventListener("pointermove", onMove);
                this.hold(false);
                this.store.commit();
                this.listPlanes();
            };
            addEventListener("pointermove", onMove);
            for (const type of ["pointerup", "pointercancel"]) addEventListener(type, onEnd, { once: true });
        });
        this.svg.append(circle);
    }
}
