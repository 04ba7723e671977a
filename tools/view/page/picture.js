// The picture: small ones while something moves, then better ones step by step.

import { askPicture, rest } from "./api.js";

const kAim = 55; // milliseconds for the rays of a picture while something moves; what else it takes follows no scale
const kSmallest = 0.2; // scale
const kMovingStep = 1.5; // voxels between samples while something moves: rays far apart share little of the cache
const kRest = 140; // milliseconds without a change until the picture is refined
const kMostPixels = 4e6;

export class Picture extends EventTarget {
    /// @param request () => { state, frame, next }
    /// @param drawing what draws lines here while something moves; null: the program makes all pictures
    constructor(canvas, request, drawing) {
        super();
        this.canvas = canvas;
        this.request = request;
        this.drawing = drawing;
        this.client = Math.random().toString(36).slice(2);
        this.scale = 0.5;
        this.turn = 0; // of the newest request
        this.wanted = false; // a picture while something moves
        new ResizeObserver(() => this.resize()).observe(canvas);
    }

    get isBusy() {
        return Boolean(this.busy || this.refining);
    }
    get height() {
        return this.canvas.clientHeight;
    }
    get size() {
        const ratio = Math.min(devicePixelRatio || 1, 2);
        const width = Math.max(this.canvas.clientWidth, 1),
            height = Math.max(this.canvas.clientHeight, 1);
        const most = Math.sqrt(kMostPixels / (width * height * ratio * ratio));
        return [width, height].map((side) => Math.max(Math.round(side * ratio * Math.min(most, 1)), 1));
    }

    resize() {
        const size = this.size;
        if (this.canvas.width === size[0] && this.canvas.height === size[1]) return;
        const old = this.canvas.width > 1 ? this.shown : null;
        [this.canvas.width, this.canvas.height] = size;
        if (old) this.draw(old);
        this.refine();
        this.tell("resize");
    }

    /// Something moves: show it soon, and refine the picture once it rests. @param draws whether it may be drawn here
    update(draws = true) {
        this.wanted = true;
        this.draws = draws;
        this.tell("text", "…");
        this.abortRefinement();
        this.refineLater();
        if (!this.busy) this.follow();
    }

    /// Show the picture as it is now, first coarse, then refined.
    refine() {
        this.tell("text", "…");
        this.wanted = false;
        this.abortRefinement();
        this.refineNow(true);
    }

    async follow() {
        this.busy = true;
        while (this.wanted) {
            this.wanted = false;
            const scale = this.scale,
                before = performance.now();
            const drawn = this.draws && this.drawing ? await this.drawing.picture(this.request(), this.size) : null;
            if (drawn) {
                this.show({ ...drawn, turn: ++this.turn }, this.rateText(before) + drawn.text);
                continue;
            }
            const shown = await this.ask({ scale, samples: 1, quality: 75, step: kMovingStep });
            if (!shown) continue;
            const text = this.rateText(before);
            this.scale = Math.min(
                1,
                Math.max(kSmallest, scale * Math.min(1.5, Math.max(0.5, Math.sqrt(kAim / Math.max(shown.cast, 1))))),
            );
            this.show(shown, text);
        }
        this.busy = false;
        this.tell("rest");
    }

    rateText(before) {
        const rate = 1000 / (performance.now() - before);
        this.rate = 0.8 * (this.rate || rate) + 0.2 * rate;
        return `${this.rate.toFixed(0)} pictures/s`;
    }

    refineLater() {
        clearTimeout(this.resting);
        this.resting = setTimeout(() => (this.busy || this.held ? this.refineLater() : this.refineNow(false)), kRest);
    }

    /// While held, the picture is not refined.
    hold(held) {
        this.held = held;
    }

    async refineNow(coarseFirst) {
        clearTimeout(this.resting);
        const work = (this.refining = new AbortController());
        const final = this.request().state.samples || 1,
            begun = performance.now();
        const steps = [];
        if (coarseFirst) steps.push({ scale: 0.25, samples: 1 });
        for (let samples = 1; samples < final; samples *= 2) steps.push({ scale: 1, samples });
        steps.push({ scale: 1, samples: final });
        for (const step of steps) {
            const shown = await this.ask({ ...step, quality: 92 }, work.signal);
            if (this.refining !== work) return;
            if (!shown) break;
            const seconds = ((performance.now() - begun) / 1000).toFixed(1);
            this.show(shown, step.scale < 1 ? "…" : `${step.samples} of ${final} samples, ${seconds} s`);
            this.settled = shown.settled;
        }
        this.refining = null;
        this.tell("refined");
    }

    abortRefinement() {
        if (!this.refining) return;
        this.refining.abort();
        this.refining = null;
        if (this.drawing) rest({ client: this.client, turn: ++this.turn });
    }

    async ask({ scale, samples, quality, step = 0 }, signal) {
        const { state, frame, next } = this.request();
        const turn = ++this.turn;
        try {
            const size = this.size.map((side) => Math.max(1, Math.round(side * scale)));
            const asked = { ...state, size, samples };
            if (step > 0) asked.step = Math.max(step, state.step || 0);
            const shown = await askPicture({ client: this.client, turn, state: asked, frame, next, quality }, signal);
            if (!shown) return null;
            this.tell("message", shown.nothing && `Nothing is seen: ${shown.nothing}`);
            return { ...shown, frame, turn };
        } catch (error) {
            if (error.name !== "AbortError") this.tell("message", error.message);
            if (error.status === 0) this.tell("lost");
            return null;
        }
    }

    /// Show a picture, unless a newer one is there: answers may change places.
    show(shown, text) {
        if (this.shown?.turn > shown.turn) return;
        this.shown?.bitmap.close?.();
        this.shown = shown;
        this.draw(shown);
        this.tell("text", text);
        this.tell("shown", { frame: shown.frame });
    }

    draw(shown) {
        const context = this.canvas.getContext("2d");
        context.imageSmoothingQuality = "high";
        context.drawImage(shown.bitmap, 0, 0, this.canvas.width, this.canvas.height);
    }

    tell(type, detail) {
        this.dispatchEvent(new CustomEvent(type, { detail }));
    }
}
