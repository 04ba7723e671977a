// Lines that the page draws itself while something moves.

import { askLines, getText } from "./api.js";
import { Axis } from "./axis.js";
import { colorAt } from "./colors.js";
import { channels } from "./elements.js";
import { Scene } from "./scene.js";
import { add, dot, normalize, scale, subtract } from "./vector.js";

const kShaders = ["shade.frag", ...["lines", "box", "solid", "ground"].flatMap((name) => [`${name}.vert`, `${name}.frag`])];
const kOfFrames = ["look", "by", "color-by", "opacity-by", "shading", "roi-box", "stretch"]; // options of a frame's lines
const kMostBytes = 256e6; // of frames that are kept
const kAim = 1000 / 24; // milliseconds a picture
const kCoarsest = 0.5; // scale
const kFewest = 64; // one in so many lines is drawn at least
const kSolid = 0.95; // opacity of what the scene draws without a threshold
const kLevels = 254; // of a stored scalar; one more stands for no value
const kColors = 32; // of a map
const kNow = 65534; // time of heads
const kFar = 3000; // lengths of the box from which a picture is as without perspective

/// @param look () => { scene, camera, version, transfer } of the page @return null without WebGL 2
export async function beginDrawing(sequence, look) {
    const canvas = document.createElement("canvas");
    if (!canvas.getContext("webgl2", { antialias: true, alpha: false })) return null;
    const texts = await Promise.all(kShaders.map(getText));
    return new Drawing(canvas, Object.fromEntries(kShaders.map((name, i) => [name, texts[i]])), sequence, look);
}

class Drawing {
    constructor(canvas, shaders, sequence, look) {
        Object.assign(this, { canvas, shaders, sequence, look });
        this.frames = new Map(); // promises of lines, the last ones used last
        this.scale = 1; // of the drawn picture's sides
        this.part = 1; // one in so many lines is drawn
        canvas.addEventListener("webglcontextlost", (event) => {
            event.preventDefault();
            this.isLost = true;
        });
        canvas.addEventListener("webglcontextrestored", () => {
            this.scene?.begin();
            this.shown = null;
            this.isLost = false;
        });
    }

    /// The lines of a frame; null if it has none or cannot be read, which the program's picture tells.
    load({ state, frame }) {
        const key = JSON.stringify([frame, this.look().version, kOfFrames.map((name) => state[name])]);
        const found = this.frames.get(key) ?? askLines({ state, frame }).then((bytes) => bytes && unpacked(bytes), () => null);
        this.frames.delete(key);
        this.frames.set(key, found);
        this.forget();
        return found;
    }

    async forget() {
        let bytes = 0;
        for (const [i, [key, frame]] of [...this.frames].reverse().entries()) {
            bytes += (await frame)?.bytes ?? 0;
            if (bytes > kMostBytes && i > 0) this.frames.delete(key);
        }
    }

    /// A picture as { bitmap, frame, text }; null if the program is to make it.
    async picture({ state, frame, next }, size) {
        if (state.keys || state.orbit || this.isLost || !this.look().transfer.scene) return null;
        const lines = await this.load({ state, frame });
        if (!lines || this.isLost) return null;
        for (const other of next) this.load({ state, frame: other });
        await new Promise(requestAnimationFrame);
        const begun = performance.now();
        this.isNew = this.shown !== lines;
        const [width, height] = size.map((side) => Math.max(1, Math.round(side * this.scale)));
        this.isNew ||= this.canvas.width !== width || this.canvas.height !== height;
        if (this.isNew) Object.assign(this.canvas, { width, height });
        const part = Math.max(this.part, lines.part);
        this.isNew ||= this.drawnPart !== part;
        this.drawnPart = part;
        try {
            this.show(lines, state);
            this.scene.draw({ ...this.sceneState(state, lines), part });
            await this.scene.finish();
        } catch (error) {
            console.warn(error);
            this.isLost = true;
            return null;
        }
        if (!this.isNew) this.choose(performance.now() - begun);
        return { bitmap: this.canvas, frame, text: part > 1 ? `, 1 of ${part} lines` : "" };
    }

    /// How fine the next pictures are. @param spent milliseconds for this one
    choose(spent) {
        if (spent > 1.2 * kAim && this.scale > kCoarsest) this.scale = kCoarsest;
        else if (spent > 1.2 * kAim && this.part < kFewest) this.part *= 2;
        else if (spent < 0.4 * kAim && this.part > 1) this.part /= 2;
        else if (spent < 0.2 * kAim) this.scale = 1;
    }

    /// Upload what the scene does not have yet.
    show(lines, state) {
        const { scene, transfer } = this.look(),
            axes = [
                new Axis(state.range ?? transfer.scene.range, state["color-scale"] ?? scene.colorScale),
                new Axis(state["opacity-range"] || (transfer.isOne && state.range) || transfer.scene.opacityRange, scene.opacityScale),
            ];
        const key = JSON.stringify([axes, transfer.points]);
        if (this.shown === lines && this.key === key) return;
        const opacities = table(transfer.points);
        const columns = [
            stored(lines.color, axes[0], (place) => place * kLevels),
            stored(lines.driver, axes[1], (place) => opacities[Math.round(place * kLevels)]),
        ];
        if (this.shown === lines) this.scene.setScalars(columns);
        else {
            this.scene ??= new Scene(this.canvas, this.shaders);
            this.scene.fill(lines.flow, { ...lines.data, scalars: columns });
        }
        Object.assign(this, { shown: lines, key });
    }

    /// The state as the scene takes it.
    sceneState(state, { flow }) {
        const { scene, camera, transfer } = this.look(),
            named = !state.colors && this.sequence.colorMaps.find(({ name }) => name === state.colormap),
            colors = named ? named.colors.map((color, i) => [i / (named.colors.length - 1), color]) : transfer.colors,
            grounds = state.background ? [state.background] : [scene.values.background, scene.values["background-top"]];
        const map = JSON.stringify(colors);
        flow.maps = { [map]: Array.from({ length: kColors }, (_, i) => colorAt(colors, i / (kColors - 1))) };
        return {
            camera: drawnCamera({ ...camera, ...optionsIn(state) }, flow),
            frame: kNow,
            colorBy: 0,
            toColor: [0, 1e-3, 1e3, 0], // its sinh is linear
            shownBy: 1,
            least: 0.51,
            soft: 0.49,
            clip: clipOf(state["clip-plane"]?.[0], scene.stretch),
            map,
            background: [0, 1, 2].map((c) => grounds.reduce((sum, ground) => sum + ground[c], 0) / grounds.length),
            box: /\bbox\b/.test(state.annotate),
            ground: false,
        };
    }
}

/// The camera of a state.
function optionsIn(state) {
    const { eye, target, up, fov, projection, "view-height": height } = state;
    return Object.fromEntries(Object.entries({ eye, target, up, fov, projection, height }).filter(([, value]) => value));
}

/// A camera with perspective; for one without from far away.
function drawnCamera(camera, { low, high }) {
    if (camera.projection !== "orthographic") return camera;
    const far = kFar * Math.hypot(...subtract(high, low)),
        eye = add(camera.target, scale(normalize(subtract(camera.eye, camera.target)), far));
    return { ...camera, eye, fov: (360 / Math.PI) * Math.atan(camera.height / 2 / far) };
}

/// @param plane point and normal in the data's own space @return what is cut away
function clipOf(plane, stretch) {
    if (!plane) return [0, 0, 0, 1e30];
    const away = plane.slice(3).map((c, i) => -c / stretch[i]);
    return [...away, dot(away, plane.slice(0, 3).map((c, i) => c * stretch[i]))];
}

/// Stored opacities of all levels, linear between points. The scene's smooth step from 0.02 to 1 makes them opacities.
function table(points) {
    const opacityAt = (place) => {
        const after = points.findIndex((point) => point[0] > place);
        if (after <= 0) return points.at(after)[1];
        const [before, next] = [points[after - 1], points[after]];
        return before[1] + ((next[1] - before[1]) * (place - before[0])) / (next[0] - before[0]);
    };
    return Array.from({ length: kLevels + 1 }, (_, i) => {
        const opacity = opacityAt(i / kLevels);
        const share = Math.min(opacity / kSolid, 1);
        return opacity > 0 ? kLevels * (0.02 + 0.98 * (0.5 - Math.sin(Math.asin(1 - 2 * share) / 3))) : 0;
    });
}

/// @param store of a place from 0 to 1
function stored(values, axis, store) {
    const result = new Uint8Array(values.length);
    for (let i = 0; i < values.length; ++i) {
        const place = axis.placeOf(values[i]);
        result[i] = Number.isNaN(place) ? kLevels + 1 : Math.round(store(Math.max(0, Math.min(1, place))));
    }
    return result;
}

/// @param bytes as line_packet.h describes them
function unpacked(bytes) {
    const [length] = new Uint32Array(bytes, 0, 1),
        told = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
    let at = 4 + length;
    const column = (Values, count) => {
        const values = new Values(bytes, at, count);
        at += values.byteLength;
        return values;
    };
    const driver = column(Float32Array, told.points),
        color = told.hasColor ? column(Float32Array, told.points) : driver,
        ids = column(Uint32Array, told.lines),
        counts = column(Uint32Array, told.lines),
        points = Array.from({ length: 4 }, () => column(Uint16Array, told.points)),
        own = column(Uint16Array, told.lines);
    const { low, high, radius, part } = told,
        flow = { low, high, radius, stretch: [1, 1, 1], steps: 65535, begin: 0, tick: 1, tail: kNow };
    const lines = [counts, own, new Uint16Array(told.lines), new Uint16Array(told.lines).fill(65535)];
    return { flow, part, driver, color, data: { points, lines, ids }, bytes: bytes.byteLength };
}
