// A solid, lit from the eye and from above on the left.
in vec3 place, away;
in float fog;

void main()
{
    vec3 normal = normalize(away), toEye = -normalize(place);
    if (dot(normal, toEye) < 0.0) normal = -normal;
    float sided = dot(normal, normalize(vec3(-0.5, 0.8, 0.35)));
    float light = 0.5 * dot(normal, toEye) + 0.125 * (3.0 + sided);
    shown = vec4(displayed(linearOf(vec3(0.42, 0.44, 0.47)) * light, fog), 1);
}
