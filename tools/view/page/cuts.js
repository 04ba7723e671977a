// Planes and a box that cut the volume, and the region of interest, with handles over the picture.

import { Box } from "./box.js";
import { axes } from "./camera.js";
import { make, makeLine, makeSection, short } from "./elements.js";
import { add, cross, dot, length, normalize, scale, subtract } from "./vector.js";

const kCutBox = {
    option: "clip-box",
    name: "box",
    id: "cut-box",
    title: "What is outside is cut away",
    isLive: true,
};
const kRegion = {
    option: "roi-box",
    name: "region",
    id: "region",
    title: "Only voxels inside are shown; range, opacity and view are chosen from them",
    isLive: false, // each is read again
};

export class Cuts {
    /// @param frozenView () => options that keep the view as it is
    constructor(store, overlay, frozenView) {
        Object.assign(this, { store, overlay, frozenView });
        overlay.layers.push(() => this.draw());
        this.boxes = [kCutBox, kRegion].map((kind) => new Box(store, this.overlay, kind, frozenView));
        this.list = make("div", { class: "list" });
        const planeButton = (name, normal) => make("button", { click: () => this.scene && this.addPlane(normal()) }, name);
        this.handles = make("input", { id: "cut-handles", type: "checkbox", checked: true, change: () => overlay.draw() });
        this.element = makeSection(
            "Cuts",
            makeLine(
                make("span", { class: "name" }, "Add plane"),
                planeButton("x", () => [1, 0, 0]),
                planeButton("y", () => [0, 1, 0]),
                planeButton("z", () => [0, 0, 1]),
                planeButton("view", () => this.viewNormal()),
            ),
            this.list,
            makeLine(
                ...this.boxes.map((box) => box.element),
                make("label", {}, this.handles, " handles"),
            ),
        );
        this.element.addEventListener("toggle", () => overlay.draw());
    }

    get planes() {
        return this.store.options["clip-plane"] || [];
    }

    show(scene) {
        this.scene = scene;
        const corners = scene.box.map((corner) => corner.map((c, i) => c / scene.stretch[i])); // the data's own space
        this.low = [0, 1, 2].map((i) => Math.min(...corners.map((c) => c[i])));
        this.high = [0, 1, 2].map((i) => Math.max(...corners.map((c) => c[i])));
        for (const box of this.boxes) box.show(this.low, this.high);
        this.listPlanes();
    }

    addPlane(normal) {
        const middle = scale(add(this.low, this.high), 0.5);
        this.store.change({
            ...this.frozenView(),
            "clip-plane": [...this.planes, [...middle, ...normal].map((c) => Number(c.toPrecision(6)))],
        });
        this.listPlanes();
    }

    /// The normal, in the data's own space, of a plane across the view.
    viewNormal() {
        return normalize(axes(this.overlay.camera()).forward.map((c, i) => c * this.scene.stretch[i]));
    }

    setPlanes(planes, commit) {
        this.store.change({ ...this.frozenView(), "clip-plane": planes.length ? planes : undefined }, { commit });
        this.overlay.draw();
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
            ...this.planes.map((plane, index) => {
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
                const title = `Normal ${normal.map((c) => short(c.toFixed(2))).join(" ")}`;
                return make(
                    "div",
                    { class: "plane" },
                    make("span", { class: "name", title }, `Plane ${index + 1}`),
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
                );
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

    turnPlane(index, normal, commit) {
        const turned = normal.map((c) => Number(c.toFixed(5)));
        this.setPlanes(
            this.planes.map((p, i) => (i === index ? [...p.slice(0, 3), ...turned] : p)),
            commit,
        );
    }

    draw() {
        if (!this.scene || !this.element.open || !this.handles.checked) return;
        this.planes.forEach((plane, index) => this.drawPlane(plane, index));
        for (const box of this.boxes) box.draw();
    }

    drawPlane(plane, index) {
        const point = plane.slice(0, 3),
            normal = normalize(plane.slice(3));
        const side = normalize(cross(normal, Math.abs(normal[2]) > 0.9 ? [1, 0, 0] : [0, 0, 1])),
            other = cross(normal, side);
        const reach = length(subtract(this.high, this.low)) / 3;
        this.overlay.outline(
            [
                [1, 1],
                [1, -1],
                [-1, -1],
                [-1, 1],
            ].map(([a, b]) => add(point, add(scale(side, a * reach), scale(other, b * reach)))),
            "plane",
        );
        const end = () => {
            this.store.commit();
            this.listPlanes();
        };
        const move = (moved, commit) => this.movePlane(index, moved, commit);
        this.overlay.slider(point, normal, `Plane ${index + 1}`, "plane", move, end);
        const tilt = (turned, commit) => this.turnPlane(index, turned, commit);
        this.overlay.tip(point, normal, `Tilt of plane ${index + 1}`, "", tilt, end);
    }
}
