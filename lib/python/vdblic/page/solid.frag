#version 300 es
precision highp float;
uniform vec3 ground;
in vec3 place, away;
in float fog;
out vec4 shown;
void main()
{
    vec3 normal = normalize(away);
    if (dot(normal, place) > 0.0) normal = -normal;
    float light = 0.4 + 0.6 * max(dot(normal, normalize(vec3(-0.45, 0.7, 0.6))), 0.0);
    vec3 lit = pow(vec3(0.42, 0.44, 0.47), vec3(2.2)) * light;
    shown = vec4(pow(mix(lit, pow(ground, vec3(2.2)), fog * mix(0.6, 0.2, ground.g)), vec3(1.0 / 2.2)), 1);
}
