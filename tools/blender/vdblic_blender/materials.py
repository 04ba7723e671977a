"""Materials of flow textures: a node group with named inputs for each kind, for Cycles and Eevee."""

import bpy

from .looks import KINDS, LOOKS, linear, opacities
from .surveying import COUNT

GROUPS = {"DENSE": "VDBLIC Dense", "STREAKS": "VDBLIC Streaks", "DYE": "VDBLIC Dye"}


def new_material(name, kind, look, texture, scalar):
    """A material of two grids; its group's inputs are set by set_inputs()."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None or not material.use_nodes:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    group = nodes.new("ShaderNodeGroup")
    group.node_tree = new_group(kind, look)
    group.name, group.label, group.width = "Flow", GROUPS[kind], 240
    for label, grid, y in (("Texture", texture, 100), ("Scalar", scalar, -100)):
        node = nodes.new("ShaderNodeAttribute")
        node.name = node.label = label
        node.attribute_name, node.location = grid, (-300, y)
        links.new(node.outputs["Fac"], group.inputs[label])
    output = nodes.new("ShaderNodeOutputMaterial")
    output.location = (320, 0)
    links.new(group.outputs["Volume"], output.inputs["Volume"])
    return material


def flow_node(material):
    """The node of our group in a material, or None."""
    if material is None or material.node_tree is None:
        return None
    node = material.node_tree.nodes.get("Flow")
    return node if node is not None and node.type == "GROUP" and node.node_tree else None


def set_inputs(material, **values):
    """Set inputs of the group by name, blanks as underscores."""
    node = flow_node(material)
    for name, value in values.items():
        node.inputs[name.replace("_", " ")].default_value = value


def set_colors(material, look, shares):
    """Colours of a look over the range, and opacity by how rare values are."""
    node = next(node for node in flow_node(material).node_tree.nodes if node.name == "Colours")
    ramp, opacity = node.color_ramp, opacities(shares)
    for i, element in enumerate(ramp.elements):
        element.color = (*_color(LOOKS[look].colors, i / (COUNT - 1)), opacity[i])
    return sum(a * b for a, b in zip(opacity, shares)) or 1


def _color(colors, place):
    """The colour at a place, 0 to 1, between colours that are evenly spaced."""
    at = place * (len(colors) - 1)
    i = min(int(at), len(colors) - 2)
    return tuple(a + (b - a) * (at - i) for a, b in zip(linear(colors[i]), linear(colors[i + 1])))


def new_group(kind, look):
    """The node group of a kind: Texture and Scalar to a Volume."""
    tree = bpy.data.node_groups.new(GROUPS[kind], "ShaderNodeTree")
    defaults = KINDS[kind]
    for name, value in (
        ("Texture", 0.0),
        ("Scalar", 0.0),
        ("Begin", defaults.begin),
        ("Full", defaults.full),
        ("From", 0.0),
        ("To", 1.0),
        ("Density", 1.0),
        ("Glow", LOOKS[look].glow),
        ("Anisotropy", 0.0),
    ):
        _socket(tree, name, "INPUT", "NodeSocketFloat", value)
    _socket(tree, "Volume", "OUTPUT", "NodeSocketShader")
    nodes, links = tree.nodes, tree.links

    def node(idname, name, x, y, **settings):
        made = nodes.new(idname)
        made.name = made.label = name
        made.location = x, y
        for key, value in settings.items():
            setattr(made, key, value)
        return made

    given = node("NodeGroupInput", "Given", -900, 0)
    # A dye is seen in proportion to its value; lines have edges.
    edges = "LINEAR" if kind == "DYE" else "SMOOTHSTEP"
    seen = node("ShaderNodeMapRange", "Contrast", -650, 150, interpolation_type=edges)
    place = node("ShaderNodeMapRange", "Range", -650, -150)
    for target, value, low, high in ((seen, "Texture", "Begin", "Full"), (place, "Scalar", "From", "To")):
        links.new(given.outputs[value], target.inputs["Value"])
        links.new(given.outputs[low], target.inputs["From Min"])
        links.new(given.outputs[high], target.inputs["From Max"])
    colors = node("ShaderNodeValToRGB", "Colours", -420, -150)
    ramp = colors.color_ramp
    while len(ramp.elements) < COUNT:
        ramp.elements.new(0.5)
    for i, element in enumerate(ramp.elements):
        element.position = i / (COUNT - 1)
        element.color = (*_color(LOOKS[look].colors, element.position), 1)
    links.new(place.outputs["Result"], colors.inputs["Fac"])

    def multiply(name, x, y, first, second):
        made = node("ShaderNodeMath", name, x, y, operation="MULTIPLY")
        links.new(first, made.inputs[0])
        links.new(second, made.inputs[1])
        return made.outputs["Value"]

    visible = multiply("Seen", -130, 150, seen.outputs["Result"], colors.outputs["Alpha"])
    density = multiply("Extinction", 50, 150, visible, given.outputs["Density"])
    glow = multiply("Emission", 50, -50, density, given.outputs["Glow"])
    shader = node("ShaderNodeVolumePrincipled", "Volume", 250, 0)
    shader.inputs["Density Attribute"].default_value = ""
    links.new(colors.outputs["Color"], shader.inputs["Color"])
    links.new(density, shader.inputs["Density"])
    links.new(given.outputs["Anisotropy"], shader.inputs["Anisotropy"])
    links.new(colors.outputs["Color"], shader.inputs["Emission Color"])
    links.new(glow, shader.inputs["Emission Strength"])
    links.new(shader.outputs["Volume"], node("NodeGroupOutput", "Result", 550, 0).inputs["Volume"])
    return tree


def _socket(tree, name, side, kind, value=None):
    if hasattr(tree, "interface"):  # from 4.0 on
        socket = tree.interface.new_socket(name=name, in_out=side, socket_type=kind)
    else:
        socket = (tree.inputs if side == "INPUT" else tree.outputs).new(kind, name)
    if value is not None:
        socket.default_value = value
