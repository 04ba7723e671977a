"""Streaks as lines in the scene: hair of a layer of USD that vdblic_export wrote, frame by frame.

From Blender 5.0 on its importer of USD makes them, and the cache of the file plays them. Older ones draw the edges of
a mesh, which is read anew at each change of frame while the add-on is on.
"""

import pathlib

import bpy
import numpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty
from bpy_extras.io_utils import ImportHelper
from mathutils import Euler, Matrix, Vector

from .framing import select_only, stage
from .line_nodes import CHOICES, add_modifier, key_of, lines_modifier, set_inputs
from .looks import LOOK_ITEMS
from .materials import forget_materials, new_line_material
from .usd_lines import LayerError, layer_of

BY_USD = (5, 0, 0)  # the first version whose importer was tried
LAYER, SAMPLE = "vdblic_layer", "vdblic_sample"  # properties of a mesh: its file, and the frame that it has
NO_SCALARS = {"radius", "displayOpacity"}


def import_lines(context, path, look="FLOW", matrix=None, again=None, domain=None):
    """Add a layer's lines to the scene. Returns the object, what was added, and warnings.

    Raises LayerError, OSError.  @param matrix  of the object, in place of the layer's
    @param again  an object of lines that goes; its name and choice of lines stay
    """
    path = str(pathlib.Path(path).absolute())
    if not pathlib.Path(path).is_file():
        raise LayerError(f"{path}: no such file; choose a layer that vdblic_export wrote")
    place = _take_away(context, again) if again else None
    thing, span = (_by_usd if bpy.app.version >= BY_USD else _by_mesh)(context, path)
    if not lines_modifier(thing):
        add_modifier(thing, None, None)
    thing["vdblic_span"] = span
    if matrix is not None:
        thing.matrix_world = matrix
    told, warnings = "", []
    if place:
        _put_back(thing, *place)
    else:
        context.view_layer.update()
        points = _points(thing)
        corners = [Vector(pick(axis=0)) for pick in (points.min, points.max)] if len(points) else [Vector()]
        corners = [Vector((x.x, y.y, z.z)) for x in corners for y in corners for z in corners]
        told, warnings = stage(context, thing, [thing.matrix_world @ corner for corner in corners], *span, domain)
        told += f", {_count(thing)} lines"
    show_lines(thing, look)
    return thing, told, warnings


def _by_usd(context, path):
    """The curves that Blender's importer makes, and the frames of the layer."""
    scene, before = context.scene, set(bpy.data.objects)
    kept = scene.frame_start, scene.frame_end
    window = context.window or context.window_manager.windows[0]  # a timer has none
    try:
        with context.temp_override(window=window):
            bpy.ops.wm.usd_import(
                filepath=path, import_cameras=False, import_lights=False, import_materials=False, import_meshes=False,
                import_volumes=False, set_frame_range=True, apply_unit_conversion_scale=False)  # fmt: skip
    except RuntimeError as error:
        raise LayerError(f"{path}: {str(error).removeprefix('Error: ').strip()}; write it again") from None
    span = scene.frame_start, scene.frame_end
    scene.frame_start, scene.frame_end = kept
    made = [thing for thing in bpy.data.objects if thing not in before]
    lines = next((thing for thing in made if thing.type == "CURVES"), None)
    if lines is None:
        for thing in made:
            bpy.data.objects.remove(thing)
        raise LayerError(f"{path}: no lines; write a layer of streaks as lines with vdblic_export -o flow.usda")
    return lines, span


def _by_mesh(context, path):
    """A mesh outside the scene, an object whose hair are its edges, and the frames of the layer."""
    layer = layer_of(path)
    name = pathlib.Path(path).stem
    mesh = bpy.data.meshes.new(f"{name} lines")
    mesh[LAYER] = path
    fill(mesh, layer, context.scene.frame_current)
    thing = bpy.data.objects.new(name, bpy.data.hair_curves.new(name))
    context.collection.objects.link(thing)
    add_modifier(thing, bpy.data.objects.new(mesh.name, mesh), None)
    turn = Euler((numpy.pi / 2 * layer.is_y_up, 0, 0)).to_matrix().to_4x4()
    thing.matrix_world = turn @ Matrix.Diagonal((*layer.scale, 1))
    return thing, layer.span


def fill(mesh, layer, frame):
    """Give a mesh the lines of a frame as edges."""
    sample = layer.sample_at(frame)
    moment = layer.moment(sample)
    mesh.clear_geometry()
    count = len(moment.points)
    starts = numpy.delete(numpy.arange(count), numpy.cumsum(moment.counts) - 1)
    mesh.vertices.add(count)
    mesh.vertices.foreach_set("co", moment.points.ravel())
    mesh.edges.add(len(starts))
    mesh.edges.foreach_set("vertices", numpy.stack([starts, starts + 1], axis=1).ravel().astype(numpy.int32))
    for name, values in {"radius": moment.radius, **moment.scalars}.items():
        (mesh.attributes.get(name) or mesh.attributes.new(name, "FLOAT", "POINT")).data.foreach_set("value", values)
    mesh[SAMPLE] = -(1 << 31) if sample is None else sample
    mesh.update()


@persistent
def follow(scene, *_):
    """Load a frame's lines into the meshes before it is drawn. Unreadable lines are reported and not drawn."""
    for mesh in bpy.data.meshes:
        if LAYER not in mesh:
            continue
        try:
            layer = layer_of(mesh[LAYER])
            if layer.sample_at(scene.frame_current) not in (None, mesh.get(SAMPLE)):
                fill(mesh, layer, scene.frame_current)
        except (LayerError, OSError) as error:
            mesh.clear_geometry()
            mesh[SAMPLE] = -(1 << 31)
            print(f"Error: {error}")


def show_lines(thing, look="FLOW", scalar="", low=0, high=0):
    """Colour lines by a scalar: the shown frame's from `low` to `high`; by default all but its hundredths at the ends."""
    scalar = scalar or next((name for name in ("magnitude", *scalars_of(thing)) if name in scalars_of(thing)), "")
    if low >= high:
        values = _values(thing, scalar) if scalar else numpy.zeros(0)
        values = values[numpy.isfinite(values)]
        low, high = map(float, numpy.quantile(values, (0.01, 0.99))) if len(values) else (0.0, 1.0)
    set_inputs(thing, Material=None)
    forget_materials(thing)
    material = new_line_material(look, scalar, low, high)
    thing.data.materials.append(material)
    set_inputs(thing, Material=material)


def scalars_of(thing):
    attributes = _source(thing).attributes
    floats = [item.name for item in attributes if item.domain == "POINT" and item.data_type == "FLOAT"]
    return [name for name in floats if name not in NO_SCALARS and not name.startswith(".")]


def _source(thing):
    """The mesh or the curves that have the points."""
    modifier = lines_modifier(thing)
    mesh = modifier[key_of(modifier, "Lines")]
    return mesh.data if mesh else thing.data


def _points(thing):
    data = _source(thing)
    items, name = (data.vertices, "co") if hasattr(data, "vertices") else (data.points, "position")
    points = numpy.zeros(3 * len(items), numpy.float32)
    items.foreach_get(name, points)
    return points.reshape(-1, 3)


def _count(thing):
    data = _source(thing)
    return len(data.vertices) - len(data.edges) if hasattr(data, "vertices") else len(data.curves)


def _values(thing, scalar):
    data = _source(thing).attributes[scalar].data
    values = numpy.zeros(len(data), numpy.float32)
    data.foreach_get("value", values)
    return values


def _take_away(context, old):
    """Remove an object of lines with its data; returns the settings for its replacement.

    It goes before its layer is read again: Blender reads no layer anew that something still has open.
    """
    modifier = lines_modifier(old)
    mesh = modifier[key_of(modifier, "Lines")]
    place = old.name, list(old.users_collection), {name: modifier[key_of(modifier, name)] for name in CHOICES}
    set_inputs(old, Material=None)
    forget_materials(old)
    rest = [old.data, mesh and mesh.data, *(getattr(item, "cache_file", None) for item in old.modifiers)]
    bpy.data.batch_remove([item for item in (old, mesh) if item])
    bpy.data.batch_remove([item for item in rest if item and not item.users])
    context.view_layer.update()
    return place


def _put_back(thing, name, collections, choices):
    for collection in collections:
        if thing.name not in collection.objects:
            collection.objects.link(thing)
    set_inputs(thing, **choices)
    thing.name = name


class _LinesOperator:
    @classmethod
    def poll(cls, context):
        return lines_modifier(context.object) is not None

    def refuse(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}


class VDBLIC_OT_import_lines(_LinesOperator, bpy.types.Operator, ImportHelper):
    """Import streaks as lines from a layer of USD that vdblic_export wrote"""

    bl_idname = "vdblic.import_lines"
    bl_label = "Import Flow Lines"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".usda"

    filter_glob: StringProperty(default="*.usd;*.usda;*.usdc" if bpy.app.version >= BY_USD else "*.usda", options={"HIDDEN"})
    look: EnumProperty(name="Look", items=LOOK_ITEMS)
    set_range: BoolProperty(name="Scene Frame Range", default=False, description="Let the scene play these frames")

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        try:
            thing, told, warnings = import_lines(context, self.filepath, self.look)
        except (LayerError, OSError) as error:
            return self.refuse(error)
        select_only(context, thing)
        if self.set_range:
            context.scene.frame_start, context.scene.frame_end = thing["vdblic_span"]
        self.report({"INFO"}, told)
        for warning in warnings:
            self.report({"WARNING"}, warning)
        return {"FINISHED"}


class VDBLIC_OT_show_lines(_LinesOperator, bpy.types.Operator):
    """Colour the active lines by a scalar, and choose those that are shown"""

    bl_idname = "vdblic.show_lines"
    bl_label = "Show Lines"
    bl_options = {"REGISTER", "UNDO"}

    look: EnumProperty(name="Look", items=LOOK_ITEMS)
    scalar: StringProperty(name="Colour By", description="Scalar that chooses colours; magnitude, the speed, by default")
    low: FloatProperty(name="From", description="Value of the first colour")
    high: FloatProperty(name="To", description="Value of the last colour; not above From: all but a hundredth at each end")
    select_by: StringProperty(name="Select By", description="Scalar that chooses lines; empty: all")
    least: FloatProperty(name="Least", description="Mean over a line from which on it is shown")
    box: StringProperty(name="Box", description="Object around the lines that are shown, by their middle; empty: all")

    def execute(self, context):
        thing = context.object
        there = scalars_of(thing)
        for name in self.scalar, self.select_by:
            if name and name not in there:
                return self.refuse(f"{thing.name}: no scalar '{name}'; it has {', '.join(there)}")
        box = context.scene.objects.get(self.box) if self.box else None
        if self.box and not box:
            return self.refuse(f"there is no object {self.box!r}; name one around the lines")
        if box:
            box.display_type, box.hide_render = "WIRE", True
        show_lines(thing, self.look, self.scalar, self.low, self.high)
        choices = {"Select": bool(self.select_by), "Select By": self.select_by, "Least": self.least, "Box": box}
        set_inputs(thing, **choices)
        return {"FINISHED"}


def menu(self, context):
    self.layout.operator(VDBLIC_OT_import_lines.bl_idname, text="Flow Lines (.usda)")


CLASSES = [VDBLIC_OT_import_lines, VDBLIC_OT_show_lines]
