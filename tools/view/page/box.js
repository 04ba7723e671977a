// A box with a handle on each side.

import { make } from "./elements.js";

export class Box {
    /// @param kind { option, name, id, title, isLive }: whether the picture follows while a side is moved
    /// @param frozenView () => options that keep the view as it is; a region chooses it anew
    constructor(store, overlay, kind, frozenView) {
        Object.assign(this, { store, overlay, kind });
        this.frozenView = kind.isLive ? frozenView : () => ({});
        this.check = make("input", { id: kind.id, type: "checkbox", change: () => this.toggle() });
        this.element = make("label", { title: kind.title }, this.check, ` ${kind.name}`);
    }

    /// Low and high corner; undefined without a box.
    get value() {
        return this.draft || this.store.options[this.kind.option];
    }

    /// @param low, high the corners of all data
    show(low, high) {
        Object.assign(this, { low, high });
        this.check.checked = Boolean(this.value);
    }

    toggle() {
        const box = this.check.checked ? [...this.low, ...this.high] : undefined;
        this.store.change({ ...this.frozenView(), [this.kind.option]: box });
        this.overlay.draw();
    }

    move(axis, high, value, commit) {
        const box = [...this.value],
            least = (this.high[axis] - this.low[axis]) / 100;
        const bounded = Math.max(this.low[axis], Math.min(this.high[axis], value));
        box[axis + 3 * high] = high ? Math.max(bounded, box[axis] + least) : Math.min(bounded, box[axis + 3] - least);
        this.draft = box.map((c) => Number(c.toPrecision(6)));
        if (this.kind.isLive)
            this.store.change({ ...this.frozenView(), [this.kind.option]: this.draft }, { commit: false });
        if (commit) this.end();
        this.overlay.draw();
    }

    end() {
        if (this.draft && !this.kind.isLive) this.store.change({ [this.kind.option]: this.draft }, { commit: false });
        this.draft = undefined;
        this.store.commit();
    }

    draw() {
        const box = this.value;
        if (!box) return;
        const { id } = this.kind,
            corner = (bits) => [0, 1, 2].map((i) => box[i + 3 * ((bits >> i) & 1)]);
        for (const face of [
            [0, 1, 3, 2],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 3, 7, 6],
        ])
            this.overlay.outline(face.map(corner), id);
        for (const axis of [0, 1, 2]) {
            for (const high of [0, 1]) {
                this.overlay.slider(
                    [0, 1, 2].map((i) => (i === axis ? box[i + 3 * high] : (box[i] + box[i + 3]) / 2)),
                    [0, 1, 2].map((i) => (i === axis ? 1 : 0)),
                    `${high ? "Upper" : "Lower"} ${"xyz"[axis]} side of the ${this.kind.name}`,
                    id,
                    (moved, commit) => this.move(axis, high, moved[axis], commit),
                    () => this.end(),
                );
            }
        }
    }
}
