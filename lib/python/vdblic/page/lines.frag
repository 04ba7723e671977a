#version 300 es
// A ribbon lit as a tube, with a dark rim that parts it from others. Opacity becomes coverage of the samples.
precision highp float;
uniform sampler2D map;
uniform vec3 ground;
in vec2 across;
in float color, opacity, fog, clipped;
in vec3 place, rightward;
out vec4 shown;

void main()
{
    if (clipped > 0.0) discard;
    vec3 toEye = -normalize(place), aside = normalize(rightward);
    float s = across.x;
    vec3 normal = normalize(aside * s + normalize(toEye - aside * dot(toEye, aside)) * sqrt(max(1.0 - s * s, 0.0)));
    vec3 light = normalize(vec3(-0.45, 0.7, 0.6));
    vec3 own = color < 0.0 ? vec3(0.5) : pow(texture(map, vec2(clamp(color, 0.0, 1.0) * 31.0 / 32.0 + 1.0 / 64.0, 0.5)).rgb, vec3(2.2));
    float diffuse = 0.4 + 0.7 * max(dot(normal, light), 0.0);
    float shine = 0.3 * pow(max(dot(normal, normalize(light + toEye)), 0.0), 30.0);
    float rim = 1.0 - 0.75 * smoothstep(0.72, 0.95, abs(s));
    vec3 lit = (own * diffuse + shine) * rim * mix(0.65, 1.0, across.y);
    vec3 back = pow(ground, vec3(2.2));
    shown = vec4(pow(mix(lit, back, fog * mix(0.6, 0.2, ground.g)), vec3(1.0 / 2.2)), opacity);
    if (shown.a < 0.1) discard;
}
