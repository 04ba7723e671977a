// One distant light by its direction in the picture's world: two angles, and a handle over the picture.

import { make, makeLine, makeRow } from "./elements.js";
import { add, normalize, scale } from "./vector.js";

export class Light {
    constructor(store, overlay) {
        Object.assign(this, { store, overlay });
        overlay.layers.push(() => this.draw());
        this.on = make("input", { id: "light-on", type: "checkbox", change: () => this.turn(true) });
        const angle = (id, max) =>
            make("input", {
                id,
                type: "range",
                min: -max,
                max,
                step: 1,
                value: 0,
                input: () => {
                    this.on.checked = true;
                    this.turn(false);
                },
                change: () => store.commit(),
            });
        this.side = angle("light-side", 180);
        this.height = angle("light-height", 90);
        this.degrees = [this.side, this.height].map((slider) => make("output", { for: slider.id }));
        this.rows = [
            makeLine(make("label", {}, this.on, " distant light")),
            makeRow("Side of light", this.side.id, this.side, this.degrees[0]),
            makeRow("Height of light", this.height.id, this.height, this.degrees[1]),
        ];
        this.tell();
    }

    /// Towards the light, of length 1.
    get direction() {
        const [x, y, z] = this.store.options.light[0];
        return normalize([x, y, z]);
    }

    /// Take the direction of the sliders.
    turn(commit) {
        const a = (this.side.valueAsNumber * Math.PI) / 180,
            h = (this.height.valueAsNumber * Math.PI) / 180;
        this.set([Math.cos(h) * Math.sin(a), -Math.cos(h) * Math.cos(a), Math.sin(h)], commit);
        this.tell();
    }

    set(direction, commit) {
        this.store.change({ light: this.on.checked ? [direction] : undefined }, { commit });
        this.overlay.draw();
    }

    show(scene, options) {
        this.scene = scene;
        this.on.checked = Boolean(options.light);
        if (!options.light || this.side.matches(":active") || this.height.matches(":active")) return;
        const [x, y, z] = this.direction;
        this.side.value = (Math.atan2(x, -y) * 180) / Math.PI;
        this.height.value = (Math.asin(z) * 180) / Math.PI;
        this.tell();
    }

    tell() {
        [this.side, this.height].forEach((slider, i) => (this.degrees[i].value = `${Math.round(slider.value)}°`));
    }

    draw() {
        if (!this.scene || !this.store.options.light || !this.on.closest("details").open) return;
        const { box, stretch } = this.scene;
        const middle = scale(
            box.reduce((sum, corner) => add(sum, corner)),
            1 / box.length,
        );
        this.overlay.tip(
            middle.map((c, i) => c / stretch[i]),
            this.direction.map((c, i) => c * stretch[i]), // as a normal has it
            "Direction of the light",
            "light",
            (turned, commit) => this.set(normalize(turned.map((c, i) => c / stretch[i])), commit),
            () => {
                this.store.commit();
                this.show(this.scene, this.store.options);
            },
        );
    }
}
