// A ribbon lit as a tube with a round head, by a light at the eye, with a dark rim that parts it from others. Opacity
// becomes coverage of four samples, with noise in place of steps (Jimenez, Interleaved Gradient Noise, 2014).
uniform sampler2D map;
in vec2 across; // aside, -1 to 1, and beyond the middle of the head; in radii
in float color, opacity, fog, clipped, lean;
flat in float isShort;

void main()
{
    float s = across.x, b = across.y, square = 1.0 - s * s;
    float left = square - b * b; // of the head's ball
    if (clipped > 0.0 || left < 0.0 && (b > 0.0 || isShort > 0.0)) discard;
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    float covered = min(floor(5.0 * opacity + mix(0.3, 0.7, noise)) / 4.0, 1.0);
    if (covered == 0.0) discard;
    float height = sqrt(max(square, 0.0));
    float facing = b > -height * lean ? sqrt(max(left, 0.0)) : height * sqrt(1.0 - lean * lean);
    vec2 place = vec2(clamp(color, 0.0, 1.0) * 31.0 / 32.0 + 1.0 / 64.0, 0.5);
    vec3 own = linearOf(color < -3.0 ? 1.0 - background : color < -1.0 ? vec3(0.5) : texture(map, place).rgb);
    float mirrored = max(2.0 * facing * facing - 1.0, 0.0), shine = mirrored / (12.0 - 11.0 * mirrored);
    float edge = sqrt(b > 0.0 ? 1.0 - left : s * s), rim = 1.0 - 0.5 * smoothstep(0.75, 1.0, edge);
    shown = vec4(displayed(1.32 * (own * (0.55 + 0.9 * facing) + 0.2 * shine) * rim, fog), covered);
}
