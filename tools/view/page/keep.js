// Keeping what was found: files, the command, the picture, a film.

import { ask, get } from "./api.js";
import { make, makeLine, makeSection } from "./elements.js";

const kPause = 300; // milliseconds between questions after the jobs of this page

export class Keep {
    /// @param shown () => { state, frame } of the picture as it is shown; state with its size
    /// @param keys () => the key frames, which files and films hold whether or not the picture follows them
    constructor(shown, keys, folder) {
        Object.assign(this, { shown, keys });
        this.sides = ["Width", "Height"].map((name) =>
            make("input", {
                id: `keep-${name.toLowerCase()}`,
                type: "number",
                min: 1,
                max: 8192,
                "aria-label": name,
                placeholder: name.toLowerCase(),
            }),
        );
        this.results = document.getElementById("results");
        this.result = document.getElementById("kept");
        this.command = document.getElementById("command");
        this.list = document.getElementById("jobs");
        document.getElementById("close-results").addEventListener("click", () => this.say(""));
        this.jobs = new Map(); // that run, by their number: their rows
        this.rate = make("input", {
            type: "number",
            min: 1,
            max: 120,
            value: 24,
            "aria-label": "Frames a second of the film",
        });
        document
            .getElementById("keep-png")
            .addEventListener("click", () =>
                this.run(() => this.make({ kind: "picture", format: "png", ...this.sized() })),
            );
        const button = (id, name, work) => make("button", { id, click: () => this.run(work) }, name);
        this.element = makeSection(
            "Save",
            make("p", { class: "note" }, `Files go to ${folder}.`),
            makeLine(
                button("keep-files", "Save transfer and camera", () => this.saveFiles()),
                button("copy-command", "Copy command", () => this.copy()),
            ),
            makeLine(
                make("span", { class: "name" }, "Size"),
                this.sides[0],
                "×",
                this.sides[1],
            ),
            makeLine(
                button("keep-exr", "Save EXR", () => this.make({ kind: "picture", format: "exr", ...this.sized() })),
            ),
            makeLine(
                button("keep-film", "Make film", () =>
                    this.make({ kind: "film", fps: this.rate.valueAsNumber || 24, ...this.withKeys() }),
                ),
                make("label", {}, this.rate, " frames/s"),
            ),
        );
    }

    /// The picture as it is shown, in the size of the fields.
    sized() {
        const { state, frame } = this.shown();
        return { state: { ...state, size: state.size.map((side, i) => this.sides[i].valueAsNumber || side) }, frame };
    }

    withKeys() {
        const { state, frame } = this.sized();
        return { state: { ...state, keys: this.keys() }, frame };
    }

    async saveFiles() {
        const kept = await ask("keep", { kind: "files", ...this.withKeys() });
        this.say(`Saved ${kept.files.join(" and ")}`, kept.command);
    }

    async copy() {
        const asked = this.sized();
        const { command } = asked.state.keys
            ? await ask("keep", { kind: "files", ...asked })
            : await ask("command", asked);
        try {
            await navigator.clipboard.writeText(command);
            this.say("The command is in the clipboard.", command);
        } catch {
            // browsers allow it on loopback and HTTPS only
            this.say("The command is selected; copy it with Ctrl C.", command);
            getSelection().selectAllChildren(this.command);
        }
    }

    /// Begin a job, and follow it to its end.
    async make(asked) {
        this.say("");
        const job = await ask("keep", asked);
        this.showJobs([job]);
        while (this.jobs.has(job.job)) {
            await new Promise((done) => setTimeout(done, kPause));
            this.showJobs((await get("status")).jobs);
        }
    }

    say(text, command = "") {
        this.result.textContent = text;
        this.command.textContent = command;
        this.command.hidden = !command;
        this.show();
    }

    show() {
        this.results.hidden = !this.result.textContent && this.jobs.size === 0;
    }

    async run(work) {
        try {
            await work();
        } catch (error) {
            this.say(error.message);
        }
    }

    /// @param jobs as the server's status tells them
    showJobs(jobs) {
        for (const { job, file, done, total, finished, error } of jobs) {
            const row = this.jobs.get(job);
            if (!finished && !row) this.addRow(job, file);
            if (!finished) this.jobs.get(job).show(done, total);
            if (!finished || !row) continue;
            row.element.remove();
            this.jobs.delete(job);
            this.say(error ? `${file}: ${error}` : `Saved ${file}`);
        }
        this.show();
    }

    addRow(job, file) {
        const bar = make("progress", { "aria-label": `Progress of ${file}` }),
            count = make("span", {});
        const stop = make(
            "button",
            { "aria-label": `Stop ${file}`, click: () => this.run(() => ask("stop", { job })) },
            "Stop",
        );
        const element = makeLine(file, bar, count, stop);
        this.list.append(element);
        const unit = file.endsWith(".mp4") ? "frames" : "samples";
        const show = (done, total) => {
            if (total) Object.assign(bar, { max: total, value: done });
            count.textContent = total ? `${done} of ${total} ${unit}` : "…";
        };
        this.jobs.set(job, { element, show });
    }
}
