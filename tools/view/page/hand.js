// Mouse, touch and keys on the picture: they turn, move and zoom the camera.

import { orbited, panned, zoomed } from "./camera.js";

const kTurn = 0.008; // radians a pixel
const kKeyTurn = 0.09; // radians a key press
const kKeyMove = 40; // pixels

const kWheelRest = 300; // milliseconds without a turn of the wheel that end its movement

/// @param look { camera() , change(camera), begin(), end() }: the camera now, a changed one, begin and end of a movement
/// @return what ends the movement of a wheel at once
export function listenToHand(canvas, look, height) {
    const pointers = new Map();
    let moves = false; // rather than turns

    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => {
        if (!look.camera()) return;
        endWheel();
        canvas.focus({ preventScroll: true });
        canvas.setPointerCapture(event.pointerId);
        pointers.set(event.pointerId, [event.clientX, event.clientY]);
        moves = event.shiftKey || event.button !== 0;
        look.begin();
    });
    canvas.addEventListener("pointermove", (event) => {
        const before = pointers.get(event.pointerId);
        if (!before) return;
        const now = [event.clientX, event.clientY],
            x = now[0] - before[0],
            y = now[1] - before[1];
        const other = [...pointers.entries()].find(([id]) => id !== event.pointerId)?.[1];
        pointers.set(event.pointerId, now);
        let camera = look.camera();
        if (other) {
            const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
            camera = panned(zoomed(camera, apart(before) / apart(now)), x / 2, y / 2, height());
        } else {
            camera = moves ? panned(camera, x, y, height()) : orbited(camera, x * kTurn, y * kTurn);
        }
        look.change(camera);
    });
    for (const type of ["pointerup", "pointercancel"]) {
        canvas.addEventListener(type, (event) => {
            if (pointers.delete(event.pointerId) && pointers.size === 0) look.end();
        });
    }

    let wheeling;
    const endWheel = () => {
        if (!wheeling) return;
        clearTimeout(wheeling);
        wheeling = undefined;
        look.end();
    };
    const once = (camera) => {
        endWheel();
        look.begin();
        look.change(camera);
        look.end();
    };
    canvas.addEventListener(
        "wheel",
        (event) => {
            event.preventDefault();
            if (!look.camera()) return;
            if (!wheeling) look.begin();
            look.change(zoomed(look.camera(), Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.003)));
            clearTimeout(wheeling);
            wheeling = setTimeout(endWheel, kWheelRest);
        },
        { passive: false },
    );
    canvas.addEventListener("keydown", (event) => {
        const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
        const camera = look.camera(),
            arrow = arrows[event.key];
        if (!camera || event.ctrlKey || event.altKey || event.metaKey) return;
        if (arrow && event.shiftKey) once(panned(camera, arrow[0] * kKeyMove, arrow[1] * kKeyMove, height()));
        else if (arrow) once(orbited(camera, arrow[0] * kKeyTurn, arrow[1] * kKeyTurn));
        else if (event.key === "+" || event.key === "=") once(zoomed(camera, 0.9));
        else if (event.key === "-") once(zoomed(camera, 1 / 0.9));
        else return;
        event.preventDefault();
    });
    return endWheel;
}
