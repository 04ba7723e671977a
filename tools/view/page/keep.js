// Keeping what was found: files, the command, the picture, a film.

import { ask } from "./api.js";
import { make, makeSection } from "./elements.js";

export class Keep {
    /// @param request () => { state, frame } of the picture as it is shown; state with its size
    constructor(request, client, folder) {
        Object.assign(this, { request, client });
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
        this.result = make("p", { id: "kept", class: "note", role: "status", "aria-live": "polite" });
        this.command = make("pre", { id: "command", hidden: true, tabindex: 0, "aria-label": "Command" });
        this.film = make("p", { id: "film", class: "note", role: "status" });
        this.stop = make("button", { id: "stop-film", hidden: true, click: () => ask("stop", {}) }, "Stop the film");
        this.rate = make("input", {
            type: "number",
            min: 1,
            max: 120,
            value: 24,
            "aria-label": "Frames a second of the film",
        });
        const button = (id, name, work) => make("button", { id, click: () => this.run(work) }, name);
        this.element = makeSection(
            "Keep",
            true,
            make("p", { class: "note" }, `Files go to ${folder}.`),
            make(
                "div",
                { class: "line" },
                button("keep-files", "Save transfer and camera", () => this.keep("files")),
                button("copy-command", "Copy command", () => this.copy()),
            ),
            make(
                "div",
                { class: "line" },
                ...this.sides,
                button("keep-png", "Save PNG", () => this.keep("picture", { format: "png" })),
                button("keep-exr", "Save EXR", () => this.keep("picture", { format: "exr" })),
            ),
            make(
                "div",
                { class: "line" },
                button("keep-film", "Make film", () => this.keep("film", { fps: this.rate.valueAsNumber || 24 })),
                make("label", {}, this.rate, " frames/s"),
                this.stop,
            ),
            this.result,
            this.command,
            this.film,
        );
    }

    asked() {
        const { state, frame } = this.request();
        const size = state.size.map((side, i) => this.sides[i].valueAsNumber || side);
        return { client: `${this.client}-keep`, state: { ...state, size }, frame };
    }

    async keep(kind, more = {}) {
        this.result.textContent = "Working …";
        const kept = await ask("keep", { ...this.asked(), kind, ...more });
        if (kind === "film") {
            this.result.textContent = "";
            return this.showFilm(kept);
        }
        this.result.textContent = `Saved ${kept.files.join(" and ")}`;
        if (kept.command) this.showCommand(kept.command);
    }

    async copy() {
        const asked = this.asked();
        const { command } = asked.state.keys
            ? await ask("keep", { ...asked, kind: "files" })
            : await ask("command", asked);
        this.showCommand(command);
        try {
            await navigator.clipboard.writeText(command);
            this.result.textContent = "The command is in the clipboard.";
        } catch {
            // browsers allow it on loopback and HTTPS only
            getSelection().selectAllChildren(this.command);
            this.result.textContent = "The command is selected; copy it with Ctrl C.";
        }
    }

    showCommand(command) {
        this.command.textContent = command;
        this.command.hidden = false;
    }

    async run(work) {
        try {
            await work();
        } catch (error) {
            this.result.textContent = error.message;
        }
    }

    /// @param film as the server's status tells it
    showFilm(film) {
        if (!film) return;
        this.stop.hidden = film.finished;
        if (!film.finished) this.film.textContent = `${film.file}: ${film.done} of ${film.total || "…"} frames`;
        else this.film.textContent = film.error ? `${film.file}: ${film.error}` : `Saved ${film.file}`;
    }
}
