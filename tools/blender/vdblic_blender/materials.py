"""Materials of flow textures: a node group with named inputs for each kind, for Cycles and Eevee."""

import bpy

from .looks import KINDS, LOOKS, linear
from .surveying import COUNT

LINES = "VDBLIC Lines"
OPACITY = "displayOpacity"  # attribute of lines: 1 at their heads
GATE = "Opacity"  # the node of the grid that decides the opacity, where one was chosen
GROUPS = {"DENSE": "VDBLIC Dense", "STREAKS": "VDBLIC Streaks", "DYE": "VDBLIC Dye"}


def new_material(name, kind, look, texture, scalar):
    """A material of two grids; its group's inputs are set by set_inputs()."""
    return _material(name, new_group(kind, look), "Volume", Texture=texture, Scalar=scalar)


def new_line_material(look, scalar, low, high):
    """A material of lines: colours by a scalar, from `low` to `high`; tails are darker than heads."""
    material = _material(LINES, _line_group(look), "Surface", Scalar=scalar, Opacity=OPACITY)
    set_inputs(material, From=low, To=high)
    return material


def _material(name, tree, output, **attributes):
    """A material of a group, and of attributes for its inputs."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None or not material.use_nodes:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    group = nodes.new("ShaderNodeGroup")
    group.node_tree = tree
    group.name, group.label, group.width = "Flow", name, 240
    for i, (label, attribute) in enumerate(attributes.items()):
        node = nodes.new("ShaderNodeAttribute")
        node.name = node.label = label
        node.attribute_name, node.location = attribute, (-300, 100 - 200 * i)
        links.new(node.outputs["Fac"], group.inputs[label])
    end = nodes.new("ShaderNodeOutputMaterial")
    end.location = (320, 0)
    links.new(group.outputs[output], end.inputs[output])
    return material


def forget_materials(thing):
    """Take an object's materials away; ours go with their group where nothing else has them."""
    materials = list(thing.data.materials)
    thing.data.materials.clear()
    for material in materials:
        node = flow_node(material)
        if node is not None and not material.users:
            group = node.node_tree
            bpy.data.materials.remove(material)
            if not group.users:
                bpy.data.node_groups.remove(group)


def set_gate(material, grid, clear, solid):
    """Let a grid decide the opacity: none up to `clear`, whole from `solid` on."""
    nodes = material.node_tree.nodes
    node = nodes.new("ShaderNodeAttribute")
    node.name = node.label = GATE
    node.attribute_name, node.location = grid, (-300, -300)
    material.node_tree.links.new(node.outputs["Fac"], flow_node(material).inputs["Opacity"])
    set_inputs(material, Clear=clear, Solid=solid)


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


def set_colors(material, look, opacity):
    """Colours of a look over the range, and opacities of as many values."""
    node = next(node for node in flow_node(material).node_tree.nodes if node.name == "Colours")
    for i, element in enumerate(node.color_ramp.elements):
        element.color = (*_color(LOOKS[look].colors, i / (COUNT - 1)), opacity[i])


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
        ("Opacity", 1.0),
        ("Clear", 0.0),
        ("Solid", 1.0),
        ("Density", 1.0),
        ("Glow", LOOKS[look].glow),
        ("Anisotropy", 0.0),
    ):
        add_socket(tree, name, "INPUT", "NodeSocketFloat", value)
    add_socket(tree, "Volume", "OUTPUT", "NodeSocketShader")
    links = tree.links

    def node(*words, **settings):
        return _node(tree, *words, **settings)

    given = node("NodeGroupInput", "Given", -900, 0)
    # A dye is seen in proportion to its value; lines have edges.
    edges = "LINEAR" if kind == "DYE" else "SMOOTHSTEP"
    seen = node("ShaderNodeMapRange", "Contrast", -650, 150, interpolation_type=edges)
    place = node("ShaderNodeMapRange", "Range", -650, -150)
    gate = node("ShaderNodeMapRange", "Gate", -650, 400)
    for target, value, low, high in (
        (seen, "Texture", "Begin", "Full"),
        (place, "Scalar", "From", "To"),
        (gate, "Opacity", "Clear", "Solid"),
    ):
        links.new(given.outputs[value], target.inputs["Value"])
        links.new(given.outputs[low], target.inputs["From Min"])
        links.new(given.outputs[high], target.inputs["From Max"])
    colors = _ramp(tree, look, -420, -150)
    links.new(place.outputs["Result"], colors.inputs["Fac"])

    def multiply(name, x, y, first, second):
        made = node("ShaderNodeMath", name, x, y, operation="MULTIPLY")
        links.new(first, made.inputs[0])
        links.new(second, made.inputs[1])
        return made.outputs["Value"]

    lines = multiply("Lines", -300, 150, seen.outputs["Result"], gate.outputs["Result"])
    visible = multiply("Seen", -130, 150, lines, colors.outputs["Alpha"])
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


def _line_group(look):
    """The node group of lines: Scalar and Opacity to a Surface."""
    tree = bpy.data.node_groups.new(LINES, "ShaderNodeTree")
    for name, value in (
        ("Scalar", 0.0),
        ("From", 0.0),
        ("To", 1.0),
        ("Opacity", 1.0),
        ("Fade", 0.7),
        ("Glow", LOOKS[look].glow),
        ("Roughness", 0.5),
    ):
        add_socket(tree, name, "INPUT", "NodeSocketFloat", value)
    add_socket(tree, "Surface", "OUTPUT", "NodeSocketShader")
    links = tree.links
    given = _node(tree, "NodeGroupInput", "Given", -900, 0)
    place = _node(tree, "ShaderNodeMapRange", "Range", -650, 0)
    for name, value in (("Value", "Scalar"), ("From Min", "From"), ("From Max", "To")):
        links.new(given.outputs[value], place.inputs[name])
    colors = _ramp(tree, look, -420, 0)
    links.new(place.outputs["Result"], colors.inputs["Fac"])
    light = _node(tree, "ShaderNodeMapRange", "Fading", -420, -250)  # from 1 - Fade at the end of a tail
    rest = _node(tree, "ShaderNodeMath", "Rest", -650, -300, operation="SUBTRACT")
    rest.inputs[0].default_value = 1
    links.new(given.outputs["Fade"], rest.inputs[1])
    links.new(given.outputs["Opacity"], light.inputs["Value"])
    links.new(rest.outputs["Value"], light.inputs["To Min"])
    shade = _node(tree, "ShaderNodeVectorMath", "Shade", -130, 0, operation="SCALE")
    links.new(colors.outputs["Color"], shade.inputs[0])
    links.new(light.outputs["Result"], shade.inputs["Scale"])
    shader = _node(tree, "ShaderNodeBsdfPrincipled", "Surface", 100, 0)
    emission = "Emission Color" if "Emission Color" in shader.inputs else "Emission"  # before 4.0
    for source, name in (
        (shade.outputs["Vector"], "Base Color"),
        (shade.outputs["Vector"], emission),
        (given.outputs["Glow"], "Emission Strength"),
        (given.outputs["Roughness"], "Roughness"),
    ):
        links.new(source, shader.inputs[name])
    links.new(shader.outputs["BSDF"], _node(tree, "NodeGroupOutput", "Result", 400, 0).inputs["Surface"])
    return tree


def _node(tree, idname, name, x, y, **settings):
    made = tree.nodes.new(idname)
    made.name = made.label = name
    made.location = x, y
    for key, value in settings.items():
        setattr(made, key, value)
    return made


def _ramp(tree, look, x, y):
    """The colours of a look."""
    colors = _node(tree, "ShaderNodeValToRGB", "Colours", x, y)
    ramp = colors.color_ramp
    while len(ramp.elements) < COUNT:
        ramp.elements.new(0.5)
    for i, element in enumerate(ramp.elements):
        element.position = i / (COUNT - 1)
        element.color = (*_color(LOOKS[look].colors, element.position), 1)
    return colors


def add_socket(tree, name, side, kind, value=None):
    """A socket of a group's interface."""
    if hasattr(tree, "interface"):  # from 4.0 on
        socket = tree.interface.new_socket(name=name, in_out=side, socket_type=kind)
    else:
        socket = (tree.inputs if side == "INPUT" else tree.outputs).new(kind, name)
    if value is not None:
        socket.default_value = value
