#version 300 es
// An edge of the box: gl_VertexID counts the ends of twelve.
uniform mat4 view, projection;
uniform vec3 low, side;
void main()
{
    int edge = gl_VertexID / 2, axis = edge / 4, corner = edge % 4;
    vec3 share = vec3(0);
    share[axis] = float(gl_VertexID % 2);
    share[(axis + 1) % 3] = float(corner % 2);
    share[(axis + 2) % 3] = float(corner / 2);
    gl_Position = projection * view * vec4(low + share * side, 1);
}
