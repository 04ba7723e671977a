// Places along a range of values: 0 at its low end, 1 at its high end.

export class Axis {
    /// @param scale linear or log
    constructor([low, high], scale) {
        Object.assign(this, { low, high, isLog: scale === "log" });
    }

    placeOf(value) {
        if (!this.isLog) return (value - this.low) / (this.high - this.low);
        return value > 0 ? Math.log(value / this.low) / Math.log(this.high / this.low) : -Infinity;
    }

    valueAt(place) {
        if (!this.isLog) return this.low + place * (this.high - this.low);
        return this.low * Math.pow(this.high / this.low, place);
    }
}
