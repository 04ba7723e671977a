// What the page asks the server; tools/view/interface.h describes the interface.

/// An answer that says why there is no result.
export class Refusal extends Error {
    constructor(status, message) {
        super(message);
        this.status = status;
    }
}

async function answerOf(path, options) {
    let response;
    try {
        response = await fetch(path, options);
    } catch (error) {
        if (error.name === "AbortError") throw error;
        throw new Refusal(0, "The server does not answer; is vdblic_view still running?");
    }
    if (response.ok) return response;
    const text = await response.text();
    let message = text;
    try {
        message = JSON.parse(text).error;
    } catch {
        /* a plain text */
    }
    throw new Refusal(response.status, message);
}

export async function get(path) {
    return (await answerOf(path)).json();
}

function post(path, body, signal) {
    return answerOf(path, {
        method: "POST",
        body: JSON.stringify(body),
        signal,
        headers: { "Content-Type": "application/json" },
    });
}

export async function ask(path, body) {
    return (await post(path, body)).json();
}

/// The file of a shader.
export async function getText(path) {
    return (await answerOf(path)).text();
}

/// Bytes that line_packet.h describes; null of a frame without lines.
export async function askLines(body) {
    const response = await post("lines", body);
    return response.status === 204 ? null : response.arrayBuffer();
}

/// End pictures of the client that are being made.
export function rest(body) {
    post("rest", body).catch(() => {}); // a request that matters will tell
}

export async function askThumbnail(body) {
    return (await post("thumbnail", body)).blob();
}

/// Why nothing is seen, by what the server says of options, in the page's words.
const kReasons = [
    [/cut everything away/, "the cuts take all away; move them, or remove them under Cuts"],
    [/sees nothing/, "the camera looks past it; Show all brings it back"],
    [/lie outside of/, "all values lie outside of the range; Automatic under Transfer function chooses it anew"],
    [/is transparent/, "all is transparent; raise the points of opacity, or choose Automatic under Transfer function"],
    [/no active voxel/, "no voxel is left to show; make the region under Cuts larger"],
];

function reasonOf(text) {
    return kReasons.find(([pattern]) => pattern.test(text))?.[1] || text;
}

/// A picture as { bitmap, samples, settled, cast, nothing }, where `cast` is what its rays took in milliseconds; null if
/// a newer request took its place.
export async function askPicture(body, signal) {
    const response = await post("picture", body, signal);
    if (response.status === 204) return null;
    const nothing = response.headers.get("Vdblic-Nothing");
    return {
        bitmap: await createImageBitmap(await response.blob()),
        samples: Number(response.headers.get("Vdblic-Samples")),
        settled: response.headers.get("Vdblic-Settled") === "1",
        cast: 1000 * Number(response.headers.get("Vdblic-Cast")),
        nothing: nothing ? reasonOf(JSON.parse(nothing)) : "",
    };
}
