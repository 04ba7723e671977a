#version 300 es
// The plane below the box and the solid, out to where it has faded. gl_VertexID counts its four corners.
uniform mat4 view, projection;
uniform vec3 low, side;
uniform float height, fade;
uniform vec2 depths; // where the fog begins and ends
out vec2 place;      // from the middle
out float fog;
void main()
{
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    place = corner * (side.xy / 2.0 + fade);
    vec4 seen = view * vec4(low.xy + side.xy / 2.0 + place, height, 1);
    fog = clamp((-seen.z - depths.x) / (depths.y - depths.x), 0.0, 1.0);
    gl_Position = projection * seen;
}
