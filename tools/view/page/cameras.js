// Projection, views along the axes, and key frames of the camera.

import { ask } from "./api.js";
import { axes, optionsOf } from "./camera.js";
import { make, makeLine, makeRow, makeSection } from "./elements.js";

const kViews = [
    ["+x", [-1, 0, 0]],
    ["−x", [1, 0, 0]],
    ["+y", [0, -1, 0]],
    ["−y", [0, 1, 0]],
    ["+z", [0, 0, -1]],
    ["−z", [0, 0, 1]],
];

export class Cameras extends EventTarget {
    /// @param camera () => the camera now @param size () => of the picture
    constructor(store, camera, size) {
        super();
        Object.assign(this, { store, camera, size });
        this.projection = make(
            "select",
            { id: "option-projection", change: () => this.chooseProjection() },
            ...["perspective", "orthographic"].map((value) => make("option", { value }, value)),
        );
        this.fov = make("input", { id: "option-fov", type: "range", min: 5, max: 100, step: 1 });
        this.fovNumber = make("output", { for: "option-fov" });
        this.fov.addEventListener("input", () => store.change({ fov: this.fov.valueAsNumber }, { commit: false }));
        this.fov.addEventListener("change", () => store.commit());
        this.follow = make("input", {
            id: "follow-keys",
            type: "checkbox",
            change: () => store.setFollows(this.follow.checked),
        });
        store.addEventListener("follows", () => this.showFollows());
        this.list = makeLine();
        this.element = makeSection(
            "Camera",
            makeRow("Projection", "option-projection", this.projection),
            makeRow("Field of view", "option-fov", this.fov, this.fovNumber),
            make(
                "div",
                { class: "line tight" },
                make("span", { class: "name" }, "From"),
                ...kViews.map(([name, direction]) =>
                    make("button", { click: () => this.fit(direction, direction[2] ? [0, 1, 0] : [0, 0, 1]) }, name),
                ),
                make(
                    "button",
                    { id: "auto-view", title: "The view as chosen from the data", click: () => this.reset() },
                    "auto",
                ),
            ),
            makeLine(
                make("button", { id: "add-key", click: () => this.addKey() }, "Set key at this frame"),
                make("label", {}, this.follow, " follow keys"),
            ),
            this.list,
        );
    }

    get keys() {
        return this.store.options.keys || [];
    }
    /// Whether pictures follow the key frames' camera.
    get follows() {
        return this.store.follows && this.keys.length > 0;
    }

    showFollows() {
        this.follow.checked = this.follows;
        this.follow.disabled = this.keys.length === 0;
    }

    show(scene) {
        this.projection.value = scene.camera.projection;
        if (!this.fov.matches(":active")) this.fov.value = scene.camera.fov;
        this.fovNumber.value = `${Math.round(scene.camera.fov)}°`;
        this.showFollows();
        this.list.replaceChildren(
            ...this.keys.map((key) =>
                make(
                    "span",
                    {},
                    make("button", { title: "Go to this key", click: () => this.goTo(key) }, `frame ${key.frame}`),
                    make(
                        "button",
                        {
                            "aria-label": `Remove the key of frame ${key.frame}`,
                            title: "Remove",
                            click: () => this.remove(key),
                        },
                        "✕",
                    ),
                ),
            ),
        );
    }

    chooseProjection() {
        const options = { projection: this.projection.value, "view-height": undefined };
        this.store.change(options);
    }

    /// See all in a direction.
    async fit(forward, up) {
        try {
            const camera = await ask("fit", { state: { ...this.store.options, size: this.size() }, forward, up });
            this.dispatchEvent(new Event("free"));
            this.store.change(optionsOf(camera));
        } catch (error) {
            this.dispatchEvent(new CustomEvent("message", { detail: error.message }));
        }
    }

    /// See all in the direction of now.
    showAll() {
        const camera = this.camera();
        if (camera) this.fit(axes(camera).forward, camera.up);
    }

    /// Back to the automatic view.
    reset() {
        this.dispatchEvent(new Event("free"));
        this.store.change({ eye: undefined, target: undefined, up: undefined, "view-height": undefined });
    }

    addKey() {
        const camera = this.camera(),
            { frame } = this.store;
        const key = { frame, eye: camera.eye, target: camera.target, up: camera.up };
        if (camera.projection === "orthographic") key.height = camera.height;
        else key.fov = camera.fov;
        const keys = [...this.keys.filter((other) => other.frame !== frame), key].sort((a, b) => a.frame - b.frame);
        this.store.change({ keys });
    }

    goTo(key) {
        this.store.setFollows(true);
        this.store.setFrame(key.frame);
    }

    remove(key) {
        const keys = this.keys.filter((other) => other !== key);
        this.store.change({ keys: keys.length ? keys : undefined });
    }
}
