// Points [position, value] over a histogram: drag, add, remove.

const kApart = 1e-3; // least distance of two points

export class Points {
    /// @param curve over which the points stand @param name of the data attribute that numbers them
    constructor(transfer, curve, name) {
        Object.assign(this, { transfer, curve, name });
    }

    /// @param at the place [x, y] of the hand @param index of the point that was hit, if any
    press(event, [x, y], index) {
        if (index !== undefined && event.button === 2) return this.remove(index);
        const { curve } = this,
            at = index ?? this.insert(curve.positionAt(x), this.newValue(curve.positionAt(x), y));
        if (at < 0) return;
        curve.drag(event, (toX, toY) => this.move(at, curve.positionAt(toX), this.draggedValue(at, toY)));
        curve.focus(this.name, at);
    }

    move(index, position, value, commit = false) {
        const { points } = this;
        const low = index > 0 ? points[index - 1][0] + kApart : 0;
        const high = index + 1 < points.length ? points[index + 1][0] - kApart : 1;
        const moved = [Math.max(low, Math.min(high, position)), value];
        const all = points.map((point, i) => (i === index ? moved : point));
        this.set(all, commit);
    }

    /// @return the new point's index, or -1 where there is no room
    insert(position, value, commit = false) {
        const { points } = this;
        if (position < 0 || position > 1 || points.some((point) => Math.abs(point[0] - position) < 2 * kApart))
            return -1;
        const index = points.filter((point) => point[0] < position).length;
        this.set([...points.slice(0, index), [position, value], ...points.slice(index)], commit);
        return index;
    }

    /// Add a point between a point and the next one, or before the last one.
    addAfter(index) {
        const { points } = this,
            next = points[index + 1]?.[0] ?? (points[index][0] < 1 ? 1 : points[index - 1]?.[0] ?? 0),
            position = (points[index][0] + next) / 2;
        return this.insert(position, this.newValue(position), true);
    }

    remove(index) {
        if (this.points.length < 2) return;
        const others = this.points.filter((_, i) => i !== index);
        this.set(others, true);
    }

    key(event, index) {
        const small = event.shiftKey ? 0.002 : 0.02,
            arrows = { ArrowLeft: [-small, 0], ArrowRight: [small, 0], ArrowUp: [0, small], ArrowDown: [0, -small] };
        if (event.key === "Delete" || event.key === "Backspace") {
            this.remove(index);
            this.curve.focus(this.name, Math.min(index, this.points.length - 1));
        } else if (event.key === "Enter" || event.key === "Insert") this.addAfter(index);
        else if (arrows[event.key]) this.nudge(index, ...arrows[event.key]);
        else return;
        event.preventDefault();
        event.stopPropagation();
    }
}
