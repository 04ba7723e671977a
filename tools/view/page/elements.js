// Making elements of the page.

/// @param properties attributes; functions listen to the event of their name
export function make(tag, properties = {}, ...children) {
    return fill(document.createElement(tag), properties, children);
}

export function makeSvg(tag, properties = {}, ...children) {
    return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), properties, children);
}

function fill(element, properties, children) {
    for (const [name, value] of Object.entries(properties)) {
        if (typeof value === "function") element.addEventListener(name, value);
        else if (value === true) element.setAttribute(name, "");
        else if (value !== false && value !== undefined) element.setAttribute(name, value);
    }
    element.append(...children);
    return element;
}

/// A part of the panel that opens and closes.
export function makeSection(title, ...children) {
    return make("details", {}, make("summary", {}, title), make("div", {}, ...children));
}

/// A row with a name. @param id of the control
export function makeRow(name, id, ...controls) {
    return make("div", { class: "row" }, make("label", { for: id }, name), ...controls);
}

export function makeLine(...children) {
    return make("div", { class: "line" }, ...children);
}

const edited = new WeakSet(); // fields with text that is not applied yet
addEventListener("input", (event) => edited.add(event.target), { capture: true });
for (const type of ["change", "focusout"])
    addEventListener(type, (event) => edited.delete(event.target), { capture: true });

/// Whether somebody types into a field.
export function isEdited(field) {
    return edited.has(field) && field.matches("input[type=number], input[type=text]");
}

/// A number with at most four significant digits.
export function short(value) {
    return String(Number(Number(value).toPrecision(4)));
}

/// The channels, 0 to 255, of a colour "#rrggbb".
export const channels = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
export const hexOf = (color) => "#" + color.map((c) => Math.round(c).toString(16).padStart(2, "0")).join("");
