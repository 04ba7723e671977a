// Turning, moving and zooming a camera { projection, eye, target, up, fov, height }, and its projection.

import { add, cross, dot, length, normalize, scale, subtract, turn } from "./vector.js";

const kNearestToPole = 0.02; // radians between the view and the up direction

export function axes(camera) {
    const forward = normalize(subtract(camera.target, camera.eye));
    const right = normalize(cross(forward, camera.up));
    return { forward, right, up: cross(right, forward) };
}

/// World units that a pixel covers at the target. @param height of the picture in pixels
export function unitsPerPixel(camera, height) {
    if (camera.projection === "orthographic") return camera.height / height;
    const distance = length(subtract(camera.target, camera.eye));
    return (2 * distance * Math.tan((camera.fov * Math.PI) / 360)) / height;
}

/// @param x, y angles in radians: the volume follows the hand
export function orbited(camera, x, y) {
    const up = normalize(camera.up),
        { right } = axes(camera);
    const arm = subtract(camera.eye, camera.target);
    const fromUp = Math.acos(Math.max(-1, Math.min(1, dot(normalize(arm), up))));
    const rise = Math.max(kNearestToPole, Math.min(Math.PI - kNearestToPole, fromUp - y)) - fromUp;
    const raised = turn(arm, right, rise);
    return { ...camera, eye: add(camera.target, turn(raised, up, -x)) };
}

/// @param x, y pixels to the right and down
export function panned(camera, x, y, height) {
    const { right, up } = axes(camera),
        unit = unitsPerPixel(camera, height);
    const shift = add(scale(right, -x * unit), scale(up, y * unit));
    return { ...camera, eye: add(camera.eye, shift), target: add(camera.target, shift) };
}

/// @param factor on the distance, or on the height of an orthographic picture
export function zoomed(camera, factor) {
    if (camera.projection === "orthographic") return { ...camera, height: camera.height * factor };
    return { ...camera, eye: add(camera.target, scale(subtract(camera.eye, camera.target), factor)) };
}

/// The options that set a camera.
export function optionsOf(camera) {
    const options = { eye: camera.eye, target: camera.target, up: camera.up };
    if (camera.projection === "orthographic") options["view-height"] = camera.height;
    return options;
}

/// A point's place in a picture of this size; null behind the eye.
export function project(camera, point, width, height) {
    const { forward, right, up } = axes(camera);
    const from = subtract(point, camera.eye),
        depth = dot(from, forward);
    if (camera.projection !== "orthographic" && depth <= 0) return null;
    const half =
        camera.projection === "orthographic" ? camera.height / 2 : depth * Math.tan((camera.fov * Math.PI) / 360);
    const pixels = height / 2 / half;
    return [width / 2 + dot(from, right) * pixels, height / 2 - dot(from, up) * pixels];
}
