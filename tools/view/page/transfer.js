// The transfer function over the histogram of its scalar: opacity points to drag, and the ends of the range.

import { Curve } from "./curve.js";
import { make, makeLine, makeSection } from "./elements.js";

const kLeastOpacity = 0.001; // of the logarithmic scale

export class Transfer {
    /// @param frozenView () => options that keep the view as it is @param ask asks for the scene again
    /// @param opacityBy the row that chooses opacity's scalar
    constructor(store, frozenView, ask, opacityBy) {
        Object.assign(this, { store, frozenView, ask });
        this.logarithmic = make("input", { id: "log-opacity", type: "checkbox", change: () => this.draw() });
        this.color = new Curve(this, { range: "range", scale: "color-scale" }, "Colour");
        this.opacity = new Curve(this, { range: "opacity-range", scale: "opacity-scale" }, "Opacity");
        this.element = makeSection(
            "Transfer function",
            opacityBy,
            this.color.element,
            this.opacity.element,
            makeLine(
                make("button", { id: "thinner", click: () => this.thicken(0.8) }, "Thinner"),
                make("button", { id: "denser", click: () => this.thicken(1.25) }, "Denser"),
                make(
                    "button",
                    {
                        id: "automatic",
                        title: "Range and opacity as chosen from the data",
                        click: () => store.change({ range: undefined, opacity: undefined, "opacity-range": undefined }),
                    },
                    "Automatic",
                ),
                make("label", {}, this.logarithmic, " log opacity"),
            ),
            make(
                "p",
                { class: "note" },
                "Click on the curve or on the colours to add a point. Delete removes it, arrow keys move it, " +
                    "Page Up and Page Down go to the others.",
            ),
        );
    }

    /// Show a scene. While a hand drags, all stays under the hand.
    show(scene, histograms) {
        this.histogramsNext = histograms || this.histogramsNext;
        if (this.dragging) return;
        this.scene = scene;
        this.histograms = this.histogramsNext;
        this.points = scene.opacity.map((point) => [...point]);
        this.colors = scene.colors.map((point) => [...point]);
        this.isOne =
            scene.colorBy === scene.opacityBy &&
            scene.colorScale === scene.opacityScale &&
            String(scene.range) === String(scene.opacityRange);
        this.draw();
    }

    draw() {
        if (!this.scene || !this.histograms) return;
        this.color.element.hidden = false;
        this.opacity.element.hidden = this.isOne;
        const { scene, histograms } = this;
        this.color.draw(scene.range, scene.colorScale, histograms.color, scene.colorTitle, this.isOne);
        if (this.isOne) return;
        this.opacity.draw(scene.opacityRange, scene.opacityScale, histograms.opacity, scene.opacityTitle, true);
    }

    /// The hand that dragged is gone.
    letGo() {
        this.dragging = false;
        this.store.commit();
        this.ask();
    }

    /// Options that keep the automatic ranges as they are: points have places in them.
    frozenRanges() {
        const { options } = this.store,
            frozen = {};
        if (!options.range) frozen.range = this.scene.range;
        if (!options["opacity-range"] && !this.isOne) frozen["opacity-range"] = this.scene.opacityRange;
        return frozen;
    }

    setPoints(points, commit) {
        this.points = points;
        this.draw();
        const text = points.map(
            ([position, opacity]) => `${Number(position.toFixed(4))}:${Number(opacity.toPrecision(4))}`,
        );
        this.store.change({ ...this.frozenView(), ...this.frozenRanges(), opacity: text.join(",") }, { commit });
    }

    /// @param colors [position, "#rrggbb"] by rising position
    setColors(colors, commit) {
        this.colors = colors;
        this.draw();
        const text = colors.map(([position, color]) => `${Number(position.toFixed(4))}:${color}`);
        this.store.change({ ...this.frozenRanges(), colors: text.join(","), colormap: undefined }, { commit });
    }

    /// @param factor on the optical depth of a voxel
    thicken(factor) {
        this.setPoints(
            this.points.map(([position, opacity]) => [
                position,
                opacity >= 1 ? 1 : Math.min(1 - Math.pow(1 - opacity, factor), 0.9999),
            ]),
            true,
        );
    }

    /// The height of an opacity on the scale, 0 to 1.
    heightOf(opacity) {
        if (!this.logarithmic.checked) return opacity;
        return 1 - Math.log(Math.max(opacity, kLeastOpacity)) / Math.log(kLeastOpacity);
    }

    /// @param height on the scale; clamped
    opacityAt(height) {
        const share = Math.max(0, Math.min(1, height));
        if (!this.logarithmic.checked) return share;
        return share === 0 ? 0 : Math.pow(kLeastOpacity, 1 - share);
    }
}
