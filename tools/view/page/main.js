// The page: one state, what shows it, and what changes it.

import { ask, get } from "./api.js";
import { optionsOf } from "./camera.js";
import { Cameras } from "./cameras.js";
import { Controls } from "./controls.js";
import { Cuts } from "./cuts.js";
import { beginDrawing } from "./drawing.js";
import { hexOf, isEdited } from "./elements.js";
import { listenToHand } from "./hand.js";
import { Keep } from "./keep.js";
import { Light } from "./light.js";
import { Overlay } from "./overlay.js";
import { Picture } from "./picture.js";
import { Store } from "./store.js";
import { Timeline } from "./timeline.js";
import { Transfer } from "./transfer.js";

const kOfCamera = new Set(["eye", "target", "up", "view-height"]);
const kOfLines = new Set([
    ...kOfCamera,
    "range",
    "opacity-range",
    "color-scale",
    "opacity-scale",
    "opacity",
    "colors",
    "colormap",
    "clip-plane",
    "background",
]); // what lines that are drawn here follow
const kOfHistograms = [
    "look",
    "by",
    "color-by",
    "opacity-by",
    "range",
    "opacity-range",
    "color-scale",
    "opacity-scale",
    "roi-box",
    "stretch",
    "shading",
];
const byId = (id) => document.getElementById(id);

async function begin() {
    const sequence = await get("sequence");
    document.title = byId("title").textContent = sequence.pattern.split("/").at(-1);
    const store = new Store({ samples: 4, ...sequence.start }, sequence.frames);
    const view = { scene: null, camera: null, version: sequence.version }; // as the server told last

    const timeline = new Timeline(store, sequence.frames);
    const overlay = new Overlay(
        () => view.camera,
        (held) => picture.hold(held),
    );
    const controls = new Controls(store, sequence, new Light(store, overlay)),
        { light, scene } = controls.sections,
        looks = controls.lookPicks;
    /// Options that keep the automatic camera where it is: it follows what is visible, so it would move under the hand.
    const frozenView = () => {
        if (cameras.follows || store.options.orbit || !view.camera) return {};
        return Object.fromEntries(Object.entries(optionsOf(view.camera)).filter(([name]) => !store.options[name]));
    };
    const transfer = new Transfer(store, frozenView, () => askScene(), controls.opacityBy);
    const cameras = new Cameras(
        store,
        () => view.camera,
        () => picture.size,
    );
    /// What the server is asked to show: key frames only while they are followed.
    const shown = () => {
        const state = { ...store.options };
        if (!cameras.follows) delete state.keys;
        return { state, frame: store.frame, next: timeline.next() };
    };
    const drawing = sequence.lines ? await beginDrawing(sequence, () => ({ ...view, transfer })) : null;
    const picture = new Picture(byId("picture"), shown, drawing);
    const cuts = new Cuts(store, overlay, frozenView);
    const keep = new Keep(
        () => ({ state: { ...shown().state, size: picture.size }, frame: store.frame }),
        () => store.options.keys,
        sequence.folder,
    );
    light.addEventListener("toggle", () => overlay.draw());
    byId("panel").append(
        ...[controls, transfer].map(({ element }) => element),
        light,
        ...[cuts, cameras].map(({ element }) => element),
        scene,
        keep.element,
    );

    const message = (text) => {
        byId("message").textContent = text || "";
    };
    /// What found no server is asked for once more when it answers.
    const complain = (error) => {
        message(error.message);
        view.isLost ||= error.status === 0;
    };

    /// The page is dark or bright as the picture's background is.
    const showGround = (background) => {
        const { style, classList } = document.documentElement;
        style.setProperty("--stage", hexOf(background.map((c) => c * 255)));
        classList.toggle("bright", background.reduce((sum, c) => sum + c) > 1.5);
    };

    let asking = false,
        again = false;
    /// Ask what the server takes for the state, and show it.
    async function askScene() {
        if (asking) {
            again = true;
            return;
        }
        asking = true;
        do {
            again = false;
            const { state, frame } = shown(),
                options = JSON.stringify(kOfHistograms.map((name) => state[name]));
            try {
                const scene = await ask("scene", { state: { ...state, size: picture.size }, frame });
                const stale = options + scene.settled !== view.histogramsOf;
                const histograms = stale ? await ask("histograms", { state }) : null;
                if (stale) view.histogramsOf = options + scene.settled;
                view.scene = scene;
                if (!view.moving) view.camera = scene.camera;
                showGround(scene.values.background);
                timeline.showClock(scene.clock);
                controls.show(scene);
                cameras.show(scene);
                cuts.show(scene);
                overlay.show(scene);
                transfer.show(scene, histograms);
                if (!picture.nothing) message("");
            } catch (error) {
                complain(error);
            }
        } while (again);
        asking = false;
        showThumbnails();
    }

    let sceneTimer;
    store.addEventListener("options", (event) => {
        const { names } = event.detail;
        picture.update(Boolean(names?.every((name) => kOfLines.has(name))));
        if (names && names.every((name) => kOfCamera.has(name)) && view.moving) return overlay.draw();
        clearTimeout(sceneTimer);
        sceneTimer = setTimeout(askScene, 60);
    });
    store.addEventListener("frame", () => {
        picture.update();
        if (!timeline.isPlaying) askScene();
    });
    store.addEventListener("history", () => {
        byId("undo").disabled = store.past.length === 0;
        byId("redo").disabled = store.future.length === 0;
    });
    store.tell("history");

    picture.addEventListener("text", (event) => {
        byId("progress").textContent = event.detail;
    });
    picture.addEventListener("shown", (event) => {
        byId("hint").hidden = true;
        picture.canvas.dataset.frame = event.detail.frame;
        if (event.detail.frame === store.frame) timeline.wait();
    });
    picture.addEventListener("message", (event) => {
        picture.nothing = event.detail;
        message(event.detail);
    });
    picture.addEventListener("lost", () => {
        view.isLost = true;
    });
    picture.addEventListener("resize", () => {
        if (view.scene) askScene();
    });
    /// Small pictures of what the frame would look like, made while nothing else is to be made: at first and whenever
    /// somebody turns to them.
    async function showThumbnails() {
        const isWanted = () => !timeline.isPlaying && !picture.isBusy;
        const isTurnedTo = !view.hasThumbnails || looks.element.matches(":hover, :focus-within");
        if (view.makesThumbnails || !view.scene?.settled || !isTurnedTo || !isWanted()) return;
        const { state, frame } = shown(),
            key = JSON.stringify([state, frame]);
        const isShown = () => key === JSON.stringify([shown().state, store.frame]);
        view.makesThumbnails = true;
        view.hasThumbnails = false;
        try {
            await looks.showPictures(state, frame, view.version, () => isWanted() && isShown());
            view.hasThumbnails = isWanted() && isShown();
        } catch (error) {
            if (isShown()) complain(error);
        }
        view.makesThumbnails = false;
        if (!isShown()) showThumbnails();
    }
    for (const type of ["pointerenter", "focusin"]) looks.element.addEventListener(type, showThumbnails);
    picture.addEventListener("refined", showThumbnails);
    picture.addEventListener("refined", () => drawing?.load(shown()));

    timeline.addEventListener("play", () => {
        if (timeline.isPlaying && cameras.keys.length) store.setFollows(true);
        picture.hold(timeline.isPlaying);
        if (!timeline.isPlaying) {
            picture.update();
            askScene();
        }
    });
    /// The camera is no longer that of the key frames, and where it is now.
    const free = () => {
        if (!cameras.follows) return;
        const { camera } = view;
        store.change({ ...optionsOf(camera), ...(camera.fov && { fov: camera.fov }) }, { commit: false });
        store.setFollows(false);
    };
    cameras.addEventListener("free", free);
    cameras.addEventListener("message", (event) => message(event.detail));
    store.addEventListener("follows", () => {
        picture.update();
        askScene();
    });

    const endWheel = listenToHand(
        picture.canvas,
        {
            camera: () => view.camera,
            begin() {
                free();
                view.moving = true;
            },
            change(camera) {
                view.camera = camera;
                store.change(optionsOf(camera), { commit: false });
            },
            end() {
                view.moving = false;
                store.commit();
            },
        },
        () => picture.height,
    );

    byId("frame-all").addEventListener("click", () => cameras.showAll());
    const undo = () => {
        endWheel();
        store.undo();
    };
    const redo = () => {
        endWheel();
        store.redo();
    };
    byId("undo").addEventListener("click", undo);
    byId("redo").addEventListener("click", redo);
    addEventListener("keydown", (event) => {
        if (isEdited(event.target)) return;
        const command = event.ctrlKey || event.metaKey,
            key = event.key.toLowerCase();
        if (command && key === "z") event.shiftKey ? redo() : undo();
        else if (command && key === "y") redo();
        else if (event.target.matches("input[type=number], input[type=text], select, pre")) return;
        else if (command || event.altKey) return;
        else if (key === " " && !event.target.matches("button, summary, input")) timeline.toggle();
        else if (key === ",") timeline.step(-1);
        else if (key === ".") timeline.step(1);
        else if (key === "0") cameras.showAll();
        else if (key === "?") byId("help-text").togglePopover();
        else return;
        event.preventDefault();
    });

    /// Follow what happens to the sequence and to what is being saved.
    async function follow() {
        let pause = 1500;
        try {
            const status = await get("status");
            if (String(status.frames) !== String(timeline.frames)) timeline.setFrames(status.frames);
            keep.showJobs(status.jobs);
            if (status.version !== view.version || view.isLost) {
                view.isLost = false;
                await askScene();
                if (!timeline.isPlaying) picture.refine();
            }
            view.version = status.version;
            if (!view.scene?.settled) pause = 300;
        } catch (error) {
            complain(error);
            pause = 5000;
        }
        setTimeout(follow, pause);
    }

    picture.refine();
    await askScene();
    if (store.isBad) message("The address holds no state that can be read; this is how the viewer begins.");
    follow();
}

begin().catch((error) => {
    byId("message").textContent = error.message;
});
