#version 300 es
// A piece of a line between two points as a ribbon that faces the eye. gl_VertexID counts the four corners of each piece.
precision highp float;
precision highp int;
precision highp usampler2D;
precision highp sampler2D;

uniform usampler2D points; // place in the box and time
uniform usampler2D lines;  // opacity of the head, born, gone
uniform usampler2D owners; // line of each point
uniform usampler2D order;  // points that begin the pieces
uniform int first; // piece
uniform int picked; // line that is thick and bright, counted from 1
uniform sampler2D colorBy, shownBy;
uniform mat4 view, projection;
uniform vec3 low, side; // box of the points, stretched
uniform float now, tail, fade; // ticks
uniform float radius, pixel; // of a head; share of the depth that a pixel covers
uniform vec4 toColor; // from a stored value to its place in the colours: low, side, factor, shift
uniform float least, soft; // of shownBy, stored, and how far from it opacity rises; below 0 all are shown
uniform float steps; // across each side of the box
uniform vec4 clip; // a plane
uniform vec2 depths; // where the fog begins and ends

out vec2 across; // aside, -1 to 1, and beyond the middle of the head; in radii
out float color, opacity, fog, clipped, lean; // lean: cosine between the line and the way to the eye
flat out float isShort;

ivec2 at(int i, int width) { return ivec2(i % width, i / width); }
uvec4 pointAt(int i) { return texelFetch(points, at(i, 4096), 0); }
float valueAt(sampler2D values, int i) { return texelFetch(values, at(i, 4096), 0).r * (255.0 / 254.0); }
uint ownerOf(int i) { return texelFetch(owners, at(i, 4096), 0).r; }
vec3 placeOf(uvec4 p) { return low + vec3(p.xyz) / steps * side; }

void main()
{
    int a = int(texelFetch(order, at(first + (gl_VertexID >> 2), 4096), 0).r), b = a + 1, end = gl_VertexID >> 1 & 1;
    uvec4 p = pointAt(a), q = pointAt(b);
    uint owner = ownerOf(a);
    uvec4 line = texelFetch(lines, at(int(owner), 4096), 0);
    float born = float(line.y), gone = line.z == 65535u ? 1e9 : float(line.z);
    float oldest = born > 0.0 ? max(now - tail, born) : now - tail;
    // The piece is cut where the tail ends and where the head is.
    float from = float(p.w), span = max(float(q.w) - from, 1.0);
    vec2 cut = clamp((vec2(oldest, now) - from) / span, 0.0, 1.0);
    float share = end == 0 ? cut.x : cut.y;
    float value = mix(valueAt(shownBy, a), valueAt(shownBy, b), share);
    float bright = float(line.x) / 65535.0;
    if (born > 0.0) bright *= clamp((now - born) / fade, 0.0, 1.0);
    bright *= clamp((gone - now) / fade, 0.0, 1.0);
    bool isHidden = cut.y <= cut.x || bright <= 0.0 || value > 1.002 && least >= 0.0;
    float young = clamp((from + share * span - oldest) / max(now - oldest, 1.0), 0.0, 1.0);

    vec3 c = placeOf(p), d = placeOf(q), middle = mix(c, d, share);
    vec3 direction = d - c;
    bool isEnd = end == 0 ? cut.x > 0.0 : cut.y < 1.0;
    int neighbour = end == 0 ? a - 1 : b + 1;
    if (!isEnd && neighbour >= 0 && ownerOf(neighbour) == owner) {
        vec3 beyond = placeOf(pointAt(neighbour));
        vec3 other = end == 0 ? c - beyond : beyond - d;
        if (length(other) > 0.0 && length(direction) > 0.0) direction = normalize(direction) + normalize(other);
    }
    vec4 seen = view * vec4(middle, 1);
    vec3 step = normalize(mat3(view) * direction + vec3(1e-30)), toEye = -normalize(seen.xyz);
    vec3 aside = cross(toEye, step);
    aside = length(aside) > 0.0 ? normalize(aside) : vec3(1, 0, 0);
    vec3 ahead = cross(aside, toEye);
    lean = clamp(dot(step, toEye), -1.0, 1.0);
    bool isPicked = int(owner) + 1 == picked;
    float sideways = (gl_VertexID & 1) == 0 ? -1.0 : 1.0;
    float width = max(radius * mix(0.45, 1.0, young), 0.8 * pixel * -seen.z) * (isPicked ? 2.0 : 1.0);
    across = vec2(sideways, -2);
    isShort = 0.0;
    // A head is half a ball at least: the ribbon ends a radius farther, and begins a radius before.
    if (float(q.w) >= now || ownerOf(b + 1) != owner) {
        float span = dot(mat3(view) * (d - c), ahead) * (cut.y - cut.x) / width;
        isShort = span < 1.0 ? 1.0 : 0.0;
        across.y = end == 1 ? 1.0 : -max(span, 1.0);
        seen.xyz += ahead * width * (end == 1 ? 1.0 : min(span - 1.0, 0.0));
    }
    float solid = clamp(bright * young, 0.0, 1.0);
    opacity = 1.0 - exp(-3.0 * solid * solid * (3.0 - 2.0 * solid));
    if (least >= 0.0) opacity *= smoothstep(least - soft, least + soft, value);
    vec2 stored = vec2(valueAt(colorBy, a), valueAt(colorBy, b)), values = sinh(toColor.x + toColor.y * stored);
    color = isPicked ? -4.0 : max(stored.x, stored.y) > 1.002 ? -2.0 : max(mix(values.x, values.y, share) * toColor.z + toColor.w, 0.0);
    fog = clamp((-seen.z - depths.x) / (depths.y - depths.x), 0.0, 1.0);
    clipped = dot(clip.xyz, middle) - clip.w;
    seen.xyz += aside * sideways * width;
    gl_Position = isHidden ? vec4(2, 2, 2, 1) : projection * seen;
}
