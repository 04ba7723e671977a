// Time: playing runs smoothly from the first frame to the last.

export class Clock {
    constructor(frames, state, changed) {
        Object.assign(this, { frames, state, changed });
        this.button = document.getElementById("play");
        this.button.addEventListener("click", () => this.toggle());
        document.getElementById("back").addEventListener("click", () => this.step(-1));
        document.getElementById("on").addEventListener("click", () => this.step(1));
    }

    get isPlaying() {
        return this.button.getAttribute("aria-pressed") === "true";
    }

    toggle(plays = !this.isPlaying) {
        this.button.setAttribute("aria-pressed", String(plays));
        this.button.setAttribute("aria-label", plays ? "Pause" : "Play");
        this.button.textContent = plays ? "❚❚" : "▶";
        if (!plays) return;
        if (this.state.frame >= this.frames.at(-1)) this.state.frame = this.frames[0];
        let before = performance.now();
        const run = (time) => {
            if (!this.isPlaying) return;
            const [first, last] = [this.frames[0], this.frames.at(-1)];
            this.state.frame += Math.max(0, Math.min(time - before, 500)) * 0.001 * this.state.speed;
            before = time;
            if (this.state.frame > last && !this.state.loop) this.toggle(false);
            if (this.state.frame > last) this.state.frame = this.state.loop ? first : last;
            this.changed();
            requestAnimationFrame(run);
        };
        requestAnimationFrame(run);
    }

    step(by) {
        this.toggle(false);
        const next = by > 0 ? Math.floor(this.state.frame + 1) : Math.ceil(this.state.frame - 1);
        this.state.frame = Math.max(this.frames[0], Math.min(this.frames.at(-1), next));
        this.changed();
    }
}
