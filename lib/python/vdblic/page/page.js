// The page: its state, settings, legend and address.

import { panned, project, unitsPerPixel, zoomed } from "./camera.js";
import { Clock } from "./clock.js";
import { unpacked } from "./data.js";
import { channels, make, makeRow, short } from "./elements.js";
import { listenToHand } from "./hand.js";
import { lineAt } from "./pick.js";
import { Scene } from "./scene.js";

const byId = (id) => document.getElementById(id);
const flow = JSON.parse(byId("flow").textContent),
    canvas = byId("picture");
const storedOf = (scale, value) => (Math.asinh(value / scale.bend) - scale.low) / (scale.high - scale.low || 1);
const valueOf = (scale, stored) => scale.bend * Math.sinh(scale.low + stored * (scale.high - scale.low));

/// The camera that sees all points above the threshold, or nearly all.
function wholeView() {
    const { points, scalars } = scene.data,
        step = Math.ceil(flow.points / 30000),
        seen = [[], [], []];
    for (let i = 0; i < flow.points; i += step)
        if (scalars[state.shownBy][i] >= state.least * 254) seen.forEach((places, axis) => places.push(points[axis][i]));
    const ends = seen.map((places, axis) => {
        places.sort((a, b) => a - b);
        const at = (share) => places[Math.floor(share * (places.length - 1))] ?? flow.steps * share;
        return [0.005, 0.995].map((share) => scene.low[axis] + (at(share) / flow.steps) * scene.side[axis]);
    });
    const sides = ends.map(([low, high]) => high - low || 1),
        target = ends.map(([low, high]) => (low + high) / 2),
        corners = [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => ends.map((end, i) => end[(corner >> i) & 1])),
        isFlat = sides[2] < 0.3 * Math.max(sides[0], sides[1]),
        from = isFlat ? [0.2, -0.7, 0.7] : [0.45, -0.95, 0.5],
        [width, height] = [canvas.clientWidth, canvas.clientHeight];
    let camera = { eye: target.map((c, i) => c + 3 * Math.hypot(...sides) * from[i]), target, up: [0, 0, 1], fov: 40 };
    for (let step = 0; step < 5; ++step) {
        const seen = corners.map((corner) => project(camera, corner, width, height)),
            [x, y] = [0, 1].map((i) => [Math.min(...seen.map((at) => at[i])), Math.max(...seen.map((at) => at[i]))]);
        camera = panned(camera, width / 2 - (x[0] + x[1]) / 2, 0.47 * height - (y[0] + y[1]) / 2, height);
        camera = zoomed(camera, Math.max((x[1] - x[0]) / (0.92 * width), (y[1] - y[0]) / (0.75 * height)));
    }
    return camera;
}

const numberOf = (name) => flow.scalars.findIndex((scale) => scale.name === name);
const q = numberOf("q"),
    speed = Math.max(0, numberOf(numberOf("speed") < 0 ? "magnitude" : "speed"));
const nameOf = (scale) => (scale.name === "magnitude" && numberOf("speed") < 0 ? "speed" : scale.name);
const state = {
    frame: flow.frames[0], speed: 8, loop: true, camera: null, colorBy: speed, map: null, range: null,
    part: 0, shownBy: q < 0 ? speed : q, least: q < 0 ? 0 : storedOf(flow.scalars[q], flow.scalars[q].shown[1]),
    clip: "none", cut: 1, box: true, ground: false, dark: true,
};
try {
    Object.assign(state, JSON.parse(decodeURIComponent(location.hash.slice(1)) || "{}"));
} catch {
    // an address of something else
}
let scene, wanted, picked;
const mapNow = () => state.map ?? (state.dark ? "ember" : "turbo");

const kFew = 16; // lines, of which one is drawn to see how fast the machine is
const kPatience = 500; // milliseconds for a picture

/// The picture's state as the scene takes it.
function drawn() {
    const ratio = Math.min(devicePixelRatio || 1, 2),
        size = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    const scale = flow.scalars[state.colorBy],
        range = state.range ?? [scale.shown[0], scale.shown[2]],
        axis = "xyz".indexOf(state.clip);
    const clip = [0, 0, 0, 1e30];
    if (axis >= 0) clip[axis] = 1;
    if (axis >= 0) clip[3] = scene.low[axis] + state.cut * scene.side[axis];
    document.documentElement.classList.toggle("dark", state.dark);
    const background = channels(state.dark ? "#0a0d12" : "#f4f5f7").map((c) => c / 255);
    const side = range[1] - range[0] || 1e-30,
        toColor = [scale.low, scale.high - scale.low, scale.bend / side, -range[0] / side];
    const least = state.least > 0 ? state.least : -1;
    return { ...state, map: mapNow(), scale, range, toColor, least, soft: 0.02, clip, background, picked };
}

function render() {
    wanted = 0;
    const { scale, range, ...picture } = drawn();
    scene.draw(picture);
    showLegend(scale, range);
    byId("moment").value = state.frame;
    byId("date").value = dateText();
    byId("moment").setAttribute("aria-valuetext", dateText());
}
function dateText(frame = state.frame) {
    const seconds = (flow.time ?? 0) + (frame - flow.frames[0]) * (flow.dt ?? 0),
        start = Date.parse(flow.start);
    if (Number.isFinite(start)) return new Date(start + 1000 * seconds).toISOString().slice(0, 16).replace("T", " ");
    if (flow.dt && Math.abs(seconds) >= 7200) return `${(seconds / 3600).toFixed(1)} h`;
    return flow.dt ? `${seconds.toPrecision(3)} s` : `frame ${frame.toFixed(1)}`;
}

/// Tell the scalars of the line at a place. @param x, y pixels of the picture
function pick(x, y) {
    const { clientWidth: width, clientHeight: height } = canvas,
        focal = height / 2 / Math.tan((state.camera.fov * Math.PI) / 360),
        found = lineAt(scene, drawn(), x - width / 2, height / 2 - y, focal);
    picked = found?.line;
    const told = flow.scalars.map((scale, i) => {
        if (!found) return "";
        const ends = [0, 1].map((end) => scene.data.scalars[i][found.point + end]),
            value = valueOf(scale, (ends[0] + found.share * (ends[1] - ends[0])) / 254),
            step = (Math.hypot(value, scale.bend) * (scale.high - scale.low)) / 254, // as it is stored
            digit = 10 ** Math.floor(Math.log10(step || 1));
        return Math.max(...ends) > 254 ? `no ${nameOf(scale)}` : `${nameOf(scale)} ${short(Math.round(value / digit) * digit)} ${scale.unit}`.trim();
    });
    byId("picked").textContent = found ? [...told, dateText(flow.begin + found.time * flow.tick)].join(", ") : "";
    changed();
}
function listenToPicks() {
    let down;
    canvas.addEventListener("pointerdown", (event) => (down = event.isPrimary ? [event.offsetX, event.offsetY] : null));
    canvas.addEventListener("pointerup", ({ offsetX, offsetY }) => {
        if (down && Math.hypot(offsetX - down[0], offsetY - down[1]) < 4) pick(offsetX, offsetY);
    });
    canvas.addEventListener("keydown", (event) => {
        if (event.key === "Enter") pick(canvas.clientWidth / 2, canvas.clientHeight / 2);
        if (event.key === "Escape") pick(-1e6, 0);
    });
}

function showLegend(scale, range) {
    byId("legend-name").textContent = nameOf(scale) + (scale.unit && ` [${scale.unit}]`);
    [...byId("legend-ends").children].forEach((end, i) => (end.textContent = short(range[i])));
    const context = byId("bar").getContext("2d"),
        colors = flow.maps[mapNow()];
    colors.forEach((color, i) => {
        context.fillStyle = color;
        context.fillRect(i * 8, 0, 8, 1);
    });
    const unit = unitsPerPixel(state.camera, canvas.clientHeight),
        power = 10 ** Math.floor(Math.log10(100 * unit));
    byId("scale").style.width = `${power / unit}px`;
    byId("scale").firstChild.textContent = `${short(power)} ${flow.length_unit ?? ""}`;
}
let saving;
function changed() {
    wanted ||= requestAnimationFrame(render);
    clearTimeout(saving);
    saving = setTimeout(() => {
        try {
            history.replaceState(null, "", "#" + encodeURIComponent(JSON.stringify(state)));
        } catch {
            // a frame without an address of its own
        }
    }, 400);
}

function settings() {
    const choice = (id, values, names = values, now = state[id]) =>
        make("select", { id, change: (e) => set(id, values[e.target.selectedIndex]) },
            ...values.map((value, i) => make("option", { selected: value === now }, names[i])));
    const set = (id, value) => {
        state[id] = value;
        if (id === "colorBy") state.range = null;
        if (id === "shownBy") state.least = 0;
        settings();
        changed();
    };
    const slider = (id, min, max, step) =>
        make("input", { id, type: "range", min, max, step, value: state[id],
            input: (e) => { state[id] = e.target.valueAsNumber; words(); changed(); } });
    const tick = (id) => make("input", { id, type: "checkbox", checked: state[id], change: (e) => set(id, e.target.checked) });
    const scale = flow.scalars[state.colorBy],
        shown = flow.scalars[state.shownBy],
        least = make("output", { for: "least" });
    const words = () => (least.value = state.least > 0 ? `≥ ${short(valueOf(shown, state.least))} ${shown.unit}` : "all");
    words();
    const names = flow.scalars.map(nameOf),
        numbers = names.map((_, i) => i);
    const end = (i) => make("input", { id: `end${i}`, type: "number", step: "any", "aria-label": ["Least", "Most"][i],
        value: short((state.range ?? [scale.shown[0], scale.shown[2]])[i]),
        change: (e) => { const range = [...(state.range ?? [scale.shown[0], scale.shown[2]])];
            range[i] = e.target.valueAsNumber; if (Number.isFinite(range[i])) set("range", range); } });
    const focused = document.activeElement?.id;
    byId("settings").replaceChildren(
        makeRow("Colour", "colorBy", choice("colorBy", numbers, names)),
        makeRow("Colours", "map", choice("map", Object.keys(flow.maps), undefined, mapNow())),
        makeRow("Range", "end0", end(0), end(1)),
        makeRow("Show by", "shownBy", choice("shownBy", numbers, names)),
        makeRow("From", "least", slider("least", 0, 1, 0.002), least),
        makeRow("Lines", "part", choice("part", [1, 2, 4, 8, 16], ["all", ...[2, 4, 8, 16].map((part) => `1 of ${part}`)])),
        makeRow("Cut", "clip", choice("clip", ["none", "x", "y", "z"])),
        makeRow("Cut at", "cut", slider("cut", 0, 1, 0.005)),
        makeRow("Frames/s", "speed", choice("speed", [1, 2, 4, 8, 16, 24])),
        makeRow("Loop", "loop", tick("loop")),
        makeRow("Box", "box", tick("box")),
        makeRow("Ground", "ground", tick("ground")),
        makeRow("Dark", "dark", tick("dark")),
        make("button", { id: "all", click: () => set("camera", wholeView()) }, "Show all (0)"),
        make("button", { id: "png", click: keepPng }, "Save PNG"),
    );
    if (focused) byId(focused)?.focus();
}
function keepPng() {
    render();
    canvas.toBlob((blob) => {
        const link = make("a", { href: URL.createObjectURL(blob), download: "flow.png" });
        link.click();
        URL.revokeObjectURL(link.href);
    });
}

/// Choose as many lines as the machine draws in time.
async function choosePart() {
    const timeOf = (part) => scene.timeOf({ ...drawn(), part }),
        few = await timeOf(kFew),
        more = Math.max((await timeOf(kFew / 2)) - few, 0); // for as many lines again
    if (state.part !== kFew) return; // somebody chose
    state.part = [1, 2, 4, 8].find((part) => few + more * (kFew / part - 1) <= kPatience) ?? kFew;
    settings();
    changed();
}

async function begin() {
    scene = new Scene(canvas, kShaders);
    scene.fill(flow, await unpacked(flow, byId("data").textContent));
    byId("data").remove();
    state.camera ??= wholeView();
    const isAsked = state.part > 0;
    if (!isAsked) state.part = kFew;
    const last = flow.frames.at(-1);
    Object.assign(byId("moment"), { min: flow.frames[0], max: last });
    const clock = new Clock(flow.frames, state, changed);
    byId("moment").addEventListener("input", (event) => {
        clock.toggle(false);
        state.frame = event.target.valueAsNumber;
        changed();
    });
    const camera = { camera: () => state.camera, change: (now) => { state.camera = now; changed(); }, begin() {}, end() {} };
    listenToHand(canvas, camera, () => canvas.clientHeight);
    listenToPicks();
    document.addEventListener("keydown", (event) => {
        if (event.target.matches("input, select, button, summary") || event.ctrlKey || event.metaKey) return;
        const acts = { " ": () => clock.toggle(), ",": () => clock.step(-1), ".": () => clock.step(1), 0: () => byId("all").click() };
        if (!acts[event.key]) return;
        event.preventDefault();
        acts[event.key]();
    });
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { scene.begin(); scene.fill(flow, scene.data); changed(); });
    new ResizeObserver(changed).observe(canvas);
    settings();
    await scene.timeOf(drawn()); // the first takes longer
    render();
    byId("message").textContent = "";
    if (!isAsked) await choosePart();
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) clock.toggle(true);
}
begin().catch((error) => {
    byId("message").textContent = error.message;
    document.documentElement.classList.add("still");
});
