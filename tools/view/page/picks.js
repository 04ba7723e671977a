// A choice among small pictures: what the shown frame would look like.

import { askThumbnail } from "./api.js";
import { make } from "./elements.js";

const kSize = [96, 64];

function ramp(background) {
    const strip = make("i");
    strip.style.background = background;
    return strip;
}

export class Picks {
    /// @param chosen (scene, options) => the value that is chosen, if any
    /// @param changes (value, options) => options that choose it
    /// @param ramps a background for each value, shown below its picture
    constructor(store, name, title, values, chosen, changes, ramps = []) {
        Object.assign(this, { store, values, chosen, changes });
        this.inputs = values.map((value) =>
            make("input", {
                type: "radio",
                name,
                value,
                id: `${name}-${value}`,
                change: () => store.change(changes(value, store.options)),
            }),
        );
        this.images = values.map(() => make("img", { alt: "", width: kSize[0], height: kSize[1] }));
        this.element = make(
            "fieldset",
            { id: `option-${name}`, class: "picks" },
            make("legend", {}, title),
            ...values.map((value, i) =>
                make(
                    "label",
                    { class: "pick" },
                    this.inputs[i],
                    this.images[i],
                    ...(ramps.length ? [ramp(ramps[i])] : []),
                    make("span", {}, value),
                ),
            ),
        );
    }

    show(scene, options) {
        const value = this.chosen(scene, options);
        for (const input of this.inputs) input.checked = input.value === value;
    }

    /// Ask for the pictures of a frame. @param version, isWanted as Controls has them
    async showPictures(state, frame, version, isWanted) {
        for (const [i, value] of this.values.entries()) {
            if (!isWanted()) return;
            const asked = { state: { ...state, ...this.changes(value, state), size: kSize }, frame },
                key = JSON.stringify([asked, version]);
            if (this.images[i].dataset.key === key) continue;
            const blob = await askThumbnail(asked);
            URL.revokeObjectURL(this.images[i].src);
            this.images[i].src = URL.createObjectURL(blob);
            this.images[i].dataset.key = key;
        }
    }
}
