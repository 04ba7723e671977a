// Lines, their box and the solid by WebGL 2, in pages of lines and in the viewer. All values are uploaded once.

import { axes } from "./camera.js";
import { channels } from "./elements.js";
import { pieces, surface } from "./data.js";
import { dot } from "./vector.js";

const kWidth = 4096; // of textures
const kAtOnce = 16384; // pieces, whose corners have numbers of 16 bits

export class Scene {
    /// Compiles the shaders; fill() comes next. @param shaders texts by file
    constructor(canvas, shaders) {
        Object.assign(this, { canvas, shaders });
        this.begin();
    }

    place(flow) {
        this.flow = flow;
        this.low = flow.low.map((c, i) => c * flow.stretch[i]);
        this.side = flow.high.map((c, i) => c * flow.stretch[i] - this.low[i]);
        const ends = [flow.low, flow.high, ...(flow.solid ? [flow.solid.low, flow.solid.high] : [])];
        this.reach = [Math.min, Math.max].map((most) => flow.stretch.map((s, i) => s * most(...ends.map((end) => end[i]))));
        const fade = 0.4 * (this.side[0] + this.side[1]), // as vdblic_render has it
            [low, high] = this.reach;
        this.ground = { height: low[2], fade, reach: [[low[0] - fade, low[1] - fade, low[2]], [high[0] + fade, high[1] + fade, high[2]]] };
    }

    /// Compile the shaders, which the machine does while values are unpacked; again after the context was lost.
    begin() {
        const gl = (this.gl = this.canvas.getContext("webgl2", { antialias: true, alpha: false }));
        if (!gl) throw new Error("This browser has no WebGL 2, which moves the flow. This is a still.");
        [this.lines, this.box, this.surface, this.plane] = ["lines", "box", "solid", "ground"].map((name) => this.program(name));
        gl.useProgram(this.lines.program);
        const textures = ["points", "lines", "owners", "colorBy", "shownBy", "map", "order"];
        textures.forEach((name, i) => gl.uniform1i(this.lines.at(name), i));
        const corners = new Uint16Array(6 * kAtOnce).map((_, i) => 4 * Math.floor(i / 6) + [0, 1, 2, 2, 1, 3][i % 6]);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
        gl.enable(gl.DEPTH_TEST);
        this.drawLines(0, 1); // nothing yet, but some compile at the first use
        this.map = this.mapTexture = null;
        this.textures = this.scalars = [];
    }

    /// Upload all values; again after begin(). @param data as unpacked() gives it; `ids` of lines, if there, choose parts
    fill(flow, data) {
        this.checkShaders();
        this.place(flow);
        if (this.data !== data) this.pieces = pieces(data.lines[0], data.points[3]);
        this.data = data;
        for (const texture of this.textures) this.gl.deleteTexture(texture);
        const gl = this.gl,
            [x, y, z, t] = data.points,
            [, own, born, gone] = data.lines;
        this.textures = [
            this.texture(0, gl.RGBA16UI, gl.RGBA_INTEGER, gl.UNSIGNED_SHORT, Uint16Array, [x, y, z, t]),
            this.texture(1, gl.RGBA16UI, gl.RGBA_INTEGER, gl.UNSIGNED_SHORT, Uint16Array, [own, born, gone, gone]),
            this.texture(2, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, Uint32Array, [this.pieces.owners]),
        ];
        this.setScalars(data.scalars);
        this.solid = data.solid && this.uploadSolid();
    }

    /// @param columns stored values of the points, by the numbers in states
    setScalars(columns) {
        const { gl } = this;
        for (const texture of this.scalars) gl.deleteTexture(texture);
        this.data.scalars = columns;
        this.scalars = columns.map((v) => this.texture(3, gl.R8, gl.RED, gl.UNSIGNED_BYTE, Uint8Array, [v]));
        this.chosen = null;
    }

    uploadSolid() {
        const gl = this.gl,
            { low, high } = this.flow.solid,
            stretched = (place) => place.map((c, i) => c * this.flow.stretch[i]),
            { places, normals, order } = surface(this.data.solid, stretched(low), stretched(high.map((c, i) => c - low[i])));
        const vertices = gl.createVertexArray();
        gl.bindVertexArray(vertices);
        [places, normals].forEach((values, i) => {
            gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
            gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
            gl.enableVertexAttribArray(i);
            gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 0, 0);
        });
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, order, gl.STATIC_DRAW);
        gl.bindVertexArray(null);
        return { vertices, count: order.length };
    }

    /// Tell what a browser refuses; not sooner, because it waits for the compiler.
    checkShaders() {
        const { gl } = this;
        for (const { program } of [this.lines, this.box, this.surface, this.plane])
            if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
                throw new Error(`This browser cannot draw the flow. This is a still. (${gl.getProgramInfoLog(program)})`);
    }

    program(name) {
        const gl = this.gl,
            program = gl.createProgram();
        for (const [kind, end] of [[gl.VERTEX_SHADER, "vert"], [gl.FRAGMENT_SHADER, "frag"]]) {
            const shader = gl.createShader(kind);
            gl.shaderSource(shader, (end === "frag" ? this.shaders["shade.frag"] : "") + this.shaders[`${name}.${end}`]);
            gl.compileShader(shader);
            gl.attachShader(program, shader);
        }
        gl.linkProgram(program);
        return { program, at: (uniform) => gl.getUniformLocation(program, uniform) };
    }

    texture(unit, internal, format, type, Values, columns) {
        const gl = this.gl,
            texture = gl.createTexture(),
            rows = Math.max(1, Math.ceil(columns[0].length / kWidth));
        const values = new Values(rows * kWidth * columns.length);
        if (columns.length === 1) values.set(columns[0]);
        else columns.forEach((column, c) => {
            for (let i = 0; i < column.length; ++i) values[i * columns.length + c] = column[i];
        });
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
        gl.texImage2D(gl.TEXTURE_2D, 0, internal, kWidth, rows, 0, format, type, values);
        for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
            gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
        return texture;
    }

    useMap(name) {
        if (this.map === name) return;
        this.map = name;
        const gl = this.gl,
            colors = new Uint8Array(this.flow.maps[name].flatMap((hex) => [...channels(hex), 255]));
        this.mapTexture ??= gl.createTexture();
        gl.activeTexture(gl.TEXTURE5);
        gl.bindTexture(gl.TEXTURE_2D, this.mapTexture);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 32, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, colors);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    }

    /// The milliseconds that a picture takes to be drawn.
    async timeOf(state) {
        const before = performance.now();
        this.draw(state);
        await this.finish();
        return performance.now() - before;
    }

    /// Wait until all is drawn.
    async finish() {
        const { gl } = this,
            end = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
        if (!end) return; // the context is lost
        gl.flush();
        while (gl.clientWaitSync(end, 0, 0) === gl.TIMEOUT_EXPIRED) await new Promise((done) => setTimeout(done));
        gl.deleteSync(end);
    }

    /// Upload the pieces that can be seen with a threshold, of one in `part` lines, by the time of their ends.
    choose({ shownBy, least, soft, part }) {
        const key = `${shownBy} ${least} ${part}`;
        if (this.chosen === key) return;
        this.chosen = key;
        const { order, starts, owners } = this.pieces,
            values = this.data.scalars[shownBy],
            { ids } = this.data,
            bound = least < 0 ? 0 : Math.floor((least - soft) * 254);
        const kept = new Uint32Array(order.length);
        this.starts = new Uint32Array(starts.length);
        for (let tick = 0, i = 0, count = 0; tick < starts.length; ++tick) {
            for (; i < starts[tick]; ++i) {
                const piece = order[i],
                    number = ids ? ids[owners[piece]] : owners[piece];
                if (number % part === 0 && Math.max(values[piece], values[piece + 1]) >= bound) kept[count++] = piece;
            }
            this.starts[tick] = count;
        }
        const { gl } = this;
        this.kept = kept;
        gl.deleteTexture(this.order);
        this.order = this.texture(6, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, Uint32Array, [kept.subarray(0, this.starts.at(-1))]);
    }

    /// @param state { camera, frame, colorBy, toColor, shownBy, least, soft, part, clip, map, background, box, ground,
    ///        picked }; stored values
    draw(state) {
        const { gl, flow, canvas } = this,
            { camera } = state;
        const { forward, right, up } = axes(camera);
        const rows = [right, up, forward.map((c) => -c)];
        const view = [0, 1, 2].flatMap((i) => [...rows.map((row) => row[i]), 0]);
        view.push(...rows.map((row) => -dot(row, camera.eye)), 1);
        const depthsOf = (low, side) => {
            const middle = dot(low.map((c, i) => c + side[i] / 2 - camera.eye[i]), forward),
                half = dot(side, forward.map(Math.abs)) / 2;
            return [middle - half, middle + half];
        };
        const [low, high] = state.ground ? this.ground.reach : this.reach,
            [first, last] = depthsOf(low, high.map((c, i) => c - low[i])),
            deep = last - first || Math.abs(last),
            far = Math.max(last + 0.1 * deep, deep / 100),
            near = Math.max(first - 0.1 * deep, far / 3000);
        const fog = depthsOf(this.low, this.side);
        const f = 1 / Math.tan((camera.fov * Math.PI) / 360);
        const projection = [(f * canvas.height) / canvas.width, 0, 0, 0, 0, f, 0, 0];
        projection.push(0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0);
        const common = (program) => {
            gl.useProgram(program.program);
            gl.uniformMatrix4fv(program.at("view"), false, view);
            gl.uniformMatrix4fv(program.at("projection"), false, projection);
            gl.uniform3fv(program.at("low"), this.low);
            gl.uniform3fv(program.at("side"), this.side);
            gl.uniform3fv(program.at("background"), state.background);
            gl.uniform2f(program.at("depths"), Math.max(fog[0], 0), Math.max(fog[1], fog[0] + 1e-6 * deep));
        };
        gl.viewport(0, 0, canvas.width, canvas.height);
        gl.clearColor(...state.background, 1);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        if (state.ground && camera.eye[2] > this.ground.height) {
            common(this.plane);
            for (const name of ["height", "fade"]) gl.uniform1f(this.plane.at(name), this.ground[name]);
            gl.enable(gl.POLYGON_OFFSET_FILL); // behind the edges of the box
            gl.polygonOffset(1, 1);
            gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
            gl.disable(gl.POLYGON_OFFSET_FILL);
        }
        common(this.box);
        if (state.box) gl.drawArrays(gl.LINES, 0, 24);
        if (this.solid) {
            common(this.surface);
            gl.bindVertexArray(this.solid.vertices);
            gl.drawElements(gl.TRIANGLES, this.solid.count, gl.UNSIGNED_SHORT, 0);
            gl.bindVertexArray(null);
        }
        common(this.lines);
        this.choose(state);
        this.useMap(state.map);
        [this.scalars[state.colorBy], this.scalars[state.shownBy]].forEach((texture, i) => {
            gl.activeTexture(gl.TEXTURE3 + i);
            gl.bindTexture(gl.TEXTURE_2D, texture);
        });
        const [now, from, to] = this.span(state),
            tail = flow.tail / flow.tick;
        const numbers = { now, tail, fade: 1.5 / flow.tick, radius: flow.radius * Math.cbrt(state.part) };
        Object.assign(numbers, { pixel: 2 / f / canvas.height, least: state.least, soft: state.soft, steps: flow.steps });
        for (const [name, value] of Object.entries(numbers)) gl.uniform1f(this.lines.at(name), value);
        gl.uniform4fv(this.lines.at("toColor"), state.toColor);
        gl.uniform4fv(this.lines.at("clip"), state.clip);
        gl.uniform1i(this.lines.at("picked"), (state.picked ?? -1) + 1);
        this.drawLines(from, to - from);
    }

    /// The time in ticks, and which of the chosen pieces may be seen then: the first, and the one after the last.
    span({ frame }) {
        const { begin, tick, tail } = this.flow,
            now = (frame - begin) / tick,
            start = (t) => this.starts[Math.max(0, Math.min(65537, Math.round(t)))];
        return [now, start(now - tail / tick), start(now + this.pieces.longest + 2)];
    }

    drawLines(first, count) {
        const gl = this.gl;
        gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
        for (const end = first + count; first < end; first += kAtOnce) {
            gl.uniform1i(this.lines.at("first"), first);
            gl.drawElements(gl.TRIANGLES, 6 * Math.min(kAtOnce, end - first), gl.UNSIGNED_SHORT, 0);
        }
        gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    }
}
