#version 300 es
precision mediump float;
uniform vec3 ground;
out vec4 shown;
void main() { shown = vec4(mix(ground, vec3(0.5), 0.6), 1); }
