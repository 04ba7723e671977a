// The state of the page: options of vdblic_render, with undo and redo, kept in the address.

const kMostSteps = 200;

export class Store extends EventTarget {
    /// @param start the state without an address that holds one
    constructor(start, frames) {
        super();
        this.options = structuredClone(start);
        this.frame = frames[0];
        this.follows = false; // the key frames of the camera
        this.past = [];
        this.future = [];
        this.readAddress(frames);
        this.settled = structuredClone(this.options);
        addEventListener("hashchange", () => {
            if (location.hash === this.hash) return;
            this.readAddress(frames);
            this.commit();
            this.tell("options");
            this.tell("frame");
            this.tell("follows");
        });
    }

    /// Change options; undefined removes one. A step of undo ends with commit().
    change(options, { commit = true } = {}) {
        for (const [name, value] of Object.entries(options)) {
            if (value === undefined) delete this.options[name];
            else this.options[name] = value;
        }
        if (commit) this.commit();
        this.tell("options", { names: Object.keys(options) });
    }

    commit() {
        const now = JSON.stringify(this.options);
        if (now === JSON.stringify(this.settled)) return;
        this.past.push(this.settled);
        if (this.past.length > kMostSteps) this.past.shift();
        this.future = [];
        this.settled = JSON.parse(now);
        this.writeAddress();
        this.tell("history");
    }

    undo() {
        this.commit();
        this.move(this.past, this.future);
    }
    redo() {
        this.move(this.future, this.past);
    }

    move(from, to) {
        if (from.length === 0) return;
        to.push(this.settled);
        this.settled = from.pop();
        this.options = structuredClone(this.settled);
        this.writeAddress();
        this.tell("options");
        this.tell("history");
    }

    setFrame(frame) {
        if (frame === this.frame) return;
        this.frame = frame;
        this.writeAddress();
        this.tell("frame");
    }

    setFollows(follows) {
        if (follows === this.follows) return;
        this.follows = follows;
        this.writeAddress();
        this.tell("follows");
    }

    /// Take the state from the address; `isBad` tells that it holds none that can be read.
    readAddress(frames) {
        if (location.hash.length < 2) return;
        try {
            const read = JSON.parse(decodeURIComponent(location.hash.slice(1)));
            if (typeof read.options === "object" && read.options !== null) this.options = read.options;
            if (frames.includes(read.frame)) this.frame = read.frame;
            this.follows = read.follows === true;
        } catch {
            this.isBad = true;
        }
    }

    /// Browsers allow few changes a second.
    writeAddress() {
        clearTimeout(this.waiting);
        this.waiting = setTimeout(() => {
            const { frame, follows, settled: options } = this;
            this.hash = "#" + encodeURIComponent(JSON.stringify({ frame, ...(follows && { follows }), options }));
            history.replaceState(null, "", this.hash);
        }, 250);
    }

    tell(type, detail = {}) {
        this.dispatchEvent(new CustomEvent(type, { detail }));
    }
}
