// The time slider. Playing begins again after the last frame.

const kRate = 12; // frames a second

export class Timeline extends EventTarget {
    constructor(store, frames) {
        super();
        this.store = store;
        this.frames = frames;
        this.slider = document.getElementById("frame");
        this.button = document.getElementById("play");
        this.slider.addEventListener("input", () => {
            this.stop();
            store.setFrame(this.frames[this.slider.valueAsNumber]);
        });
        this.button.addEventListener("click", () => this.toggle());
        store.addEventListener("frame", () => this.showClock(""));
        this.setFrames(frames);
    }

    get index() {
        return Math.max(this.frames.indexOf(this.store.frame), 0);
    }
    get isPlaying() {
        return this.button.getAttribute("aria-pressed") === "true";
    }

    setFrames(frames) {
        const showsNewest = this.frames.length > 1 && this.store.frame === this.frames.at(-1);
        this.frames = frames;
        this.slider.max = frames.length - 1;
        this.button.disabled = this.slider.disabled = frames.length < 2;
        const place = Math.min(this.slider.valueAsNumber || 0, frames.length - 1);
        if (showsNewest && !this.isPlaying) this.store.setFrame(frames.at(-1));
        else if (!frames.includes(this.store.frame)) this.store.setFrame(frames[place]);
        this.show();
    }

    show() {
        this.slider.value = this.index;
        this.slider.setAttribute("aria-valuetext", `frame ${this.store.frame}`);
        document.getElementById("frame-number").value = [`frame ${this.store.frame} of ${this.frames.at(-1)}`, this.clock]
            .filter(Boolean)
            .join(", ");
    }

    /// @param clock time or date of the frame, if its file tells it
    showClock(clock) {
        this.clock = clock;
        this.show();
    }

    /// The frames that are shown next while playing, to be read ahead.
    next() {
        if (!this.isPlaying) return [];
        return [1, 2].map((step) => this.frames[(this.index + step) % this.frames.length]);
    }

    step(by) {
        this.stop();
        this.store.setFrame(this.frames[(this.index + by + this.frames.length) % this.frames.length]);
    }

    toggle() {
        if (this.isPlaying) return this.stop();
        this.press(true);
        if (this.index === this.frames.length - 1) this.store.setFrame(this.frames[0]);
        this.due = performance.now();
        this.wait();
    }

    stop() {
        if (!this.isPlaying) return;
        clearTimeout(this.timer);
        this.press(false);
    }

    press(playing) {
        this.button.setAttribute("aria-pressed", String(playing));
        this.button.setAttribute("aria-label", playing ? "Pause" : "Play");
        this.button.textContent = playing ? "❚❚" : "▶";
        this.dispatchEvent(new Event("play"));
    }

    /// A frame is on the screen: the next one follows when its time has come.
    wait() {
        if (!this.isPlaying) return;
        clearTimeout(this.timer);
        const now = performance.now();
        this.due = Math.max(this.due + 1000 / kRate, now);
        this.timer = setTimeout(() => {
            this.store.setFrame(this.frames[(this.index + 1) % this.frames.length]);
        }, this.due - now);
    }
}
