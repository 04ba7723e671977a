// A choice among small pictures, of what the shown frame would look like, or among ramps of colours.

import { askThumbnail } from "./api.js";
import { make } from "./elements.js";

const kSize = [96, 64];

function ramp(background) {
    const strip = make("i");
    strip.style.background = background;
    return strip;
}

/// @param colors [position, "#rrggbb"] by rising position
export const gradient = (colors) =>
    `linear-gradient(90deg, ${colors.map(([position, color]) => `${color} ${position * 100}%`).join()})`;

export class Picks {
    /// @param chosen (scene, options) => the value that is chosen, if any
    /// @param changes (value, options) => options that choose it
    /// @param ramps a background for each value, in place of its picture
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
        this.images = ramps.map(ramp);
        if (ramps.length === 0) this.images = values.map(() => make("img", { alt: "", width: kSize[0], height: kSize[1] }));
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
                    make("span", {}, value),
                ),
            ),
        );
    }

    show(scene, options) {
        const value = this.chosen(scene, options);
        for (const input of this.inputs) input.checked = input.value === value;
    }

    /// Ask for the pictures of a frame. A value that the frame has no data for cannot be chosen, and tells why.
    /// @param version of the sequence @param isWanted () => whether there is still time for it
    async showPictures(state, frame, version, isWanted) {
        for (const [i, value] of this.values.entries()) {
            if (!isWanted()) return;
            const asked = { state: { ...state, ...this.changes(value, state), size: kSize }, frame },
                key = JSON.stringify([asked, version]);
            if (this.images[i].dataset.key === key) continue;
            const label = this.inputs[i].closest("label");
            URL.revokeObjectURL(this.images[i].src);
            try {
                this.images[i].src = URL.createObjectURL(await askThumbnail(asked));
                label.title = "";
            } catch (error) {
                if (error.status !== 422) throw error;
                this.images[i].removeAttribute("src");
                label.title = error.message;
            }
            this.inputs[i].disabled = Boolean(label.title);
            this.images[i].dataset.key = key;
        }
    }
}
