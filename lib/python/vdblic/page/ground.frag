// The ground: the background, lightened if it is dark, which fades around the box.
uniform vec3 side;
uniform float fade;
in vec2 place;
in float fog;

void main()
{
    vec2 beyond = max(abs(place) - side.xy / 2.0, 0.0);
    float left = max(1.0 - dot(beyond, beyond) / (fade * fade), 0.0);
    if (left == 0.0) discard;
    vec3 back = linearOf(background);
    float luminance = dot(back, vec3(0.2126, 0.7152, 0.0722));
    vec3 hue = (back + 1e-4) / (luminance + 1e-4);
    vec3 own = back + max(0.075 - luminance, 0.0) * mix(vec3(1), hue, 0.35);
    shown = vec4(displayed(mix(back, own, left * left * left), fog), 1);
}
