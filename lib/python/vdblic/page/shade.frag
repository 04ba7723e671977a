#version 300 es
// Begins every fragment shader of the scene: light as a screen shows it, as in the program's own pictures.
precision highp float;
uniform vec3 background; // as displayed
out vec4 shown;

vec3 linearOf(vec3 displayed) { return mix(displayed / 12.92, pow((displayed + 0.055) / 1.055, vec3(2.4)), step(0.04045, displayed)); }
float mostOf(vec3 color) { return max(color.r, max(color.g, color.b)); }

/// Fog, the film's shoulder (Khronos PBR Neutral Tone Mapper) and the screen's curve. @param light linear
vec3 displayed(vec3 light, float fog)
{
    vec3 back = linearOf(background);
    light = mix(light, back, 0.25 * fog);
    float knee = max(0.8, mostOf(back)), room = 1.0 - knee, most = mostOf(light);
    if (most > knee) {
        float least = room > 0.0 ? 1.0 - room * room / (most - knee + room) : 1.0;
        light = mix(light * (least / most), vec3(least), 1.0 - 1.0 / (0.15 * (most - least) + 1.0));
    }
    return mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, light));
}
