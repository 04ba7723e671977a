"""The node group of lines: selection, thickness and material."""

import bpy

from .materials import add_socket

GROUP = "VDBLIC Lines"
MODIFIER = "Flow Lines"
CHOICES = ("Select", "Select By", "Least", "Box", "Thickness")  # inputs that are the user's
_INPUTS = (
    ("Geometry", "NodeSocketGeometry", None),
    ("Lines", "NodeSocketObject", None),  # a mesh whose edges are the lines, where the geometry has none itself
    ("Select", "NodeSocketBool", False),
    ("Select By", "NodeSocketString", "magnitude"),
    ("Least", "NodeSocketFloat", 0.0),
    ("Box", "NodeSocketObject", None),
    ("Thickness", "NodeSocketFloat", 1.0),
    ("Material", "NodeSocketMaterial", None),
)


def add_modifier(thing, lines, material):
    """Give an object the group's modifier. @param lines  object of a mesh, or None"""
    modifier = thing.modifiers.new(MODIFIER, "NODES")
    modifier.node_group = bpy.data.node_groups.get(GROUP) or _new_group()
    set_inputs(thing, Lines=lines, Material=material)
    return modifier


def lines_modifier(thing):
    """The modifier of an object of lines, or None."""
    return thing.modifiers.get(MODIFIER) if thing is not None and thing.type == "CURVES" else None


def key_of(modifier, name):
    """The property of the modifier that holds an input."""
    group = modifier.node_group
    inputs = group.inputs if hasattr(group, "inputs") else group.interface.items_tree
    return next(item.identifier for item in inputs if item.name == name and getattr(item, "in_out", "INPUT") == "INPUT")


def set_inputs(thing, **values):
    """Set inputs by name; None leaves them empty."""
    modifier = lines_modifier(thing)
    for name, value in values.items():
        modifier[key_of(modifier, name)] = value
    thing.update_tag()


def _new_group():
    tree = bpy.data.node_groups.new(GROUP, "GeometryNodeTree")
    for name, kind, value in _INPUTS:
        add_socket(tree, name, "INPUT", kind, value)
    add_socket(tree, "Geometry", "OUTPUT", "NodeSocketGeometry")
    links = tree.links

    def node(idname, x, y, inputs=(), **settings):
        """A node; `inputs` are linked by name or number."""
        made = tree.nodes.new(idname)
        made.location = x, y
        for key, value in settings.items():
            setattr(made, key, value)
        for key, source in dict(inputs).items():
            links.new(source, made.inputs[key])
        return made

    given = node("NodeGroupInput", -1500, 0).outputs
    mesh = node("GeometryNodeObjectInfo", -1300, 200, {"Object": given["Lines"]})
    drawn = node("GeometryNodeMeshToCurve", -1100, 200, {"Mesh": mesh.outputs["Geometry"]})
    lines = node("GeometryNodeJoinGeometry", -900, 100, {"Geometry": given["Geometry"]})
    links.new(drawn.outputs["Curve"], lines.inputs["Geometry"])

    # On the domain of curves a field is its mean over the points of a line.
    value = node("GeometryNodeInputNamedAttribute", -1300, -100, {"Name": given["Select By"]}, data_type="FLOAT")
    named = next(output for output in value.outputs if output.enabled)
    enough = _compare(node, "FLOAT", -1100, -100, named, given["Least"])
    small = node("FunctionNodeBooleanMath", -900, -100, {0: given["Select"], 1: enough}, operation="NIMPLY")

    box = node("GeometryNodeObjectInfo", -1300, -400, {"Object": given["Box"]}, transform_space="RELATIVE")
    bounds = node("GeometryNodeBoundBox", -1100, -400, {"Geometry": box.outputs["Geometry"]}).outputs
    place = node("GeometryNodeInputPosition", -1100, -600).outputs["Position"]
    above = _compare(node, "VECTOR", -900, -400, place, bounds["Min"])
    below = _compare(node, "VECTOR", -900, -600, bounds["Max"], place)
    inside = node("FunctionNodeBooleanMath", -700, -500, {0: above, 1: below}, operation="AND").outputs[0]
    size = node("ShaderNodeVectorMath", -900, -800, {0: bounds["Min"], 1: bounds["Max"]}, operation="DISTANCE")
    is_box = _compare(node, "FLOAT", -700, -800, size.outputs["Value"], None, operation="GREATER_THAN")
    outside = node("FunctionNodeBooleanMath", -500, -600, {0: is_box, 1: inside}, operation="NIMPLY")
    hidden = node("FunctionNodeBooleanMath", -300, -200, {0: small.outputs[0], 1: outside.outputs[0]}, operation="OR")

    left = node("GeometryNodeDeleteGeometry", -100, 0, {"Geometry": lines.outputs[0], "Selection": hidden.outputs[0]})
    left.domain = "CURVE"
    radius = node("GeometryNodeInputRadius", -100, -200).outputs["Radius"]
    thick = node("ShaderNodeMath", 50, -200, {0: radius, 1: given["Thickness"]}, operation="MULTIPLY")
    wide = node("GeometryNodeSetCurveRadius", 200, 0, {"Curve": left.outputs[0], "Radius": thick.outputs[0]})
    seen = node("GeometryNodeSetMaterial", 400, 0, {"Geometry": wide.outputs[0], "Material": given["Material"]})
    node("NodeGroupOutput", 600, 0, {"Geometry": seen.outputs[0]})
    return tree


def _compare(node, kind, x, y, first, second, operation="GREATER_EQUAL"):
    """Whether one value, or each part of a vector, is as large as another; nothing: as 0."""
    made = node("FunctionNodeCompare", x, y, data_type=kind, operation=operation)
    if kind == "VECTOR":
        made.mode = "ELEMENT"
    a, b = [socket for socket in made.inputs if socket.enabled][:2]
    made.id_data.links.new(first, a)
    b.default_value = 0 if kind == "FLOAT" else (0, 0, 0)
    if second is not None:
        made.id_data.links.new(second, b)
    return made.outputs["Result"]
