// The controls of single options: lists, sliders and checkboxes. Each shows what the server takes if nothing is chosen.

import { channels, hexOf, isEdited, make, makeRow, makeSection, short } from "./elements.js";
import { gradient, Picks } from "./picks.js";

/// name: [label, least, most, step]
const kSliders = {
    modulate: ["Modulation", 0, 1, 0.01],
    "limb-darkening": ["Limb darkening", 0, 1, 0.01],
    halo: ["Halos", 0, 2, 0.01],
    "depth-cue": ["Depth cue", 0, 1, 0.01],
    shadows: ["Shadows", 0, 1, 0.01],
    occlusion: ["Ambient occlusion", 0, 1, 0.01],
    "head-light": ["Head light", 0, 2, 0.01],
    exposure: ["Exposure", -3, 5, 0.1],
};
/// What a look sets, and so what choosing another one gives up. Ranges and the scalar of opacity stay: the look vortex
/// alone is named for one.
const kOfLooks = [...Object.keys(kSliders), "opacity", "shading", "light", "background", "background-top"];
const kOfOpacity = ["opacity-by", "opacity-range", "opacity-scale"];
const none = (names) => Object.fromEntries(names.map((name) => [name, undefined]));

export class Controls {
    constructor(store, sequence, distantLight) {
        this.store = store;
        this.shows = [(scene, options) => distantLight.show(scene, options)]; // called with the scene
        const scalars = [...sequence.scalars, sequence.texture];
        /// The few that are always there.
        this.element = make(
            "section",
            {},
            this.looks(sequence.looks),
            this.colorMaps(sequence.colorMaps),
            this.list("color-by", "Colour by", scalars, (scene) => scene.colorBy, (name) =>
                store.change({ "color-by": name, ...none(["range", "color-scale"]) }),
            ),
            this.legend(),
        );
        this.opacityBy = this.list("opacity-by", "Opacity by", scalars, (scene) => scene.opacityBy, (name) =>
            store.change({ "opacity-by": name, opacity: undefined, ...none(kOfOpacity.slice(1)) }),
        );
        const slider = (name) => this.slider(name);
        const light = makeSection(
            "Light and depth",
            ...["modulate", "limb-darkening", "halo", "depth-cue", "shadows", "occlusion", "exposure"].map(slider),
            this.list("shading", "Shading", ["phong", "lines", "none"], (scene) => scene.values.shading),
            slider("head-light"),
            ...distantLight.rows,
        );
        const scene = makeSection(
            "Scene",
            this.background(),
            this.solid(sequence),
            this.annotations(),
            this.stretch(),
            this.list(
                "samples",
                "Rays a pixel",
                ["1", "2", "4", "8", "16", "32"],
                (scene, options) => String(options.samples || 1),
                (count) => store.change({ samples: Number(count) }),
            ),
            this.list(
                "step",
                "Step in voxels",
                ["0.25", "0.5", "1", "2"],
                (scene) => String(scene.values.step),
                (step) => store.change({ step: Number(step) }),
            ),
        );
        this.sections = { light, scene };
    }

    /// Show a scene's values, unless a control is being used.
    show(scene) {
        this.scene = scene;
        for (const show of this.shows) show(scene, this.store.options);
    }

    looks(names) {
        const changes = (look, options) => {
            const opacityBy = this.scene?.opacityBy;
            const asNamed = look === "vortex" && opacityBy !== "q";
            const ofOpacity = asNamed ? none(kOfOpacity) : { "opacity-by": opacityBy };
            return { ...none(kOfLooks), ...ofOpacity, look };
        };
        this.lookPicks = this.picks("look", "Look", names, (scene) => scene.look, changes);
        return this.lookPicks.element;
    }

    /// @param maps { name, colors } of each
    colorMaps(maps) {
        const changes = (colormap) => ({ colormap, colors: undefined });
        const names = maps.map(({ name }) => name),
            ramps = maps.map(({ colors }) => `linear-gradient(90deg, ${colors.join()})`);
        return this.picks("colormap", "Colours", names, (scene) => scene.colorMap, changes, ramps).element;
    }

    picks(...of) {
        const picks = new Picks(this.store, ...of);
        this.shows.push((scene, options) => picks.show(scene, options));
        return picks;
    }

    /// The colours of the scalar between the ends of its range.
    legend() {
        const title = make("span", { class: "name" }),
            ramp = make("i"),
            ends = [0, 1].map(() => make("output", {}));
        this.shows.push((scene) => {
            title.textContent = scene.colorTitle;
            ramp.style.background = gradient(scene.colors);
            ends.forEach((end, i) => (end.value = short(scene.range[i])));
        });
        return make("div", { id: "legend" }, title, ends[0], ramp, ends[1]);
    }

    list(name, label, values, valueIn, choose = (value) => this.store.change({ [name]: value })) {
        const select = make(
            "select",
            { id: `option-${name}`, change: () => choose(select.value) },
            ...values.map((value) => make("option", { value }, value)),
        );
        this.shows.push((scene, options) => {
            const value = valueIn(scene, options);
            for (const option of [...select.options])
                if (!values.includes(option.value) && option.value !== value) option.remove();
            if (![...select.options].some((option) => option.value === value))
                select.append(make("option", { value }, value));
            select.value = value;
        });
        return makeRow(label, select.id, select);
    }

    slider(name) {
        const [label, min, max, step] = kSliders[name],
            id = `option-${name}`;
        const range = make("input", { id, type: "range", min, max, step }),
            number = make("output", { for: id });
        range.addEventListener("input", () => {
            number.value = range.value;
            this.store.change({ [name]: range.valueAsNumber }, { commit: false });
        });
        range.addEventListener("change", () => this.store.commit());
        this.shows.push((scene) => {
            if (range.matches(":active")) return;
            range.value = scene.values[name];
            number.value = short(scene.values[name]);
        });
        return makeRow(label, id, range, number);
    }

    /// Two colours, at the bottom and at the top; a new one at the bottom is that of all.
    background() {
        const hex = (color) => hexOf(color.map((c) => c * 255));
        const chosen = (value) => channels(value).map((c) => Number((c / 255).toFixed(4)));
        const inputs = [
            ["background", "Background at the bottom"],
            ["background-top", "Background at the top"],
        ].map(([name, title]) => {
            const input = make("input", { id: `option-${name}`, type: "color", class: "wide", "aria-label": title });
            // What a look has at the bottom is given, too: an option for the top alone would keep it.
            const both = () => ({ background: chosen(inputs[0].value), [name]: chosen(input.value) });
            input.addEventListener("input", () => this.store.change(both(), { commit: false }));
            input.addEventListener("change", () => this.store.commit());
            this.shows.push((scene) => {
                input.value = hex(scene.values[name]);
            });
            return input;
        });
        return makeRow("Background", "option-background", ...inputs);
    }

    solid(sequence) {
        const values = ["none", "domain", ...(sequence.solid ? [sequence.solid] : [])];
        return this.list(
            "solid",
            "Solid",
            values,
            (scene, options) => options.solid || "none",
            (solid) => this.store.change({ solid: solid === "none" ? undefined : solid }),
        );
    }

    annotations() {
        const boxes = ["box", "axes", "colorbar", "time", "scalebar", "triad"].map((name) =>
            make("input", { type: "checkbox", value: name }),
        );
        const title = make("input", { type: "text", "aria-label": "Title" });
        const change = () => {
            const names = boxes.filter((box) => box.checked).map((box) => box.value);
            if (title.value) names.push(`title=${title.value}`);
            this.store.change({ annotate: names.length ? names.join(",") : undefined });
        };
        for (const control of [...boxes, title]) control.addEventListener("change", change);
        this.shows.push((scene, options) => {
            const [names, text] = (options.annotate || "").split(/,?title=/);
            for (const box of boxes) box.checked = names.split(",").includes(box.value);
            if (!isEdited(title)) title.value = text || "";
        });
        return make(
            "div",
            { class: "line", role: "group", "aria-label": "Annotations" },
            ...boxes.map((box) => make("label", {}, box, ` ${box.value}`)),
            make("div", { class: "line whole" }, make("span", { class: "name" }, "Title"), title),
        );
    }

    stretch() {
        const inputs = ["x", "y", "z"].map((axis) =>
            make("input", { type: "number", min: 0.001, step: "any", "aria-label": `Stretch ${axis}` }),
        );
        for (const input of inputs) {
            input.addEventListener("change", () => {
                const stretch = inputs.map((other) => other.valueAsNumber || 1);
                this.store.change({
                    stretch: stretch.every((factor) => factor === 1) ? undefined : stretch,
                    eye: undefined,
                    target: undefined,
                    up: undefined,
                    "view-height": undefined,
                });
            });
        }
        this.shows.push((scene) =>
            inputs.forEach((input, i) => {
                if (!isEdited(input)) input.value = short(scene.stretch[i]);
            }),
        );
        return make("div", { class: "line whole" }, make("span", { class: "name" }, "Stretch"), ...inputs);
    }
}
