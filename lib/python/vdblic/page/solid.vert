#version 300 es
uniform mat4 view, projection;
uniform vec2 depths; // where the fog begins and ends
layout(location = 0) in vec3 point;
layout(location = 1) in vec3 normal;
out vec3 place, away;
out float fog;
void main()
{
    vec4 seen = view * vec4(point, 1);
    place = seen.xyz;
    away = mat3(view) * normal;
    fog = clamp((-seen.z - depths.x) / (depths.y - depths.x), 0.0, 1.0);
    gl_Position = projection * seen;
}
