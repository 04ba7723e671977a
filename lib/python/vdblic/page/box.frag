void main() { shown = vec4(mix(background, vec3(0.5), 0.6), 1); }
