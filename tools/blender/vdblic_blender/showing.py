"""Volumes as flow textures: material, range of colours, render settings."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty
from mathutils import Vector

from .framing import eye, views
from .looks import KINDS, LOOK_ITEMS, LOOKS, kind_of, opacities
from .materials import GATE, GROUPS, flow_node, forget_materials, new_material, set_colors, set_gate, set_inputs
from .sequences import SequenceError, sequence_of
from .surveying import COUNT, EmptyVolume, measure, survey
from .vdb_header import DamagedFile, headers_of, read_header

KIND_ITEMS = (
    ("AUTO", "By the File", "Streaks where inactive voxels are empty, else dense"),
    ("DENSE", "Dense", "A line in every voxel"),
    ("STREAKS", "Streaks", "Lines with heads and tails, and nothing between"),
    ("DYE", "Dye", "Seen in proportion to its value"),
)


def path_of(volume):
    return bpy.path.abspath(volume.data.filepath)


LEAST_SHARE = 0.01  # least visible share of the volume: below it the density is not raised further


def show(context, volume, header, kind="AUTO", look="FLOW", colors=("", 0, 0), gate=("", 0, 0)):
    """Give a volume a new material. Returns warnings; a volume without voxels keeps what it has.

    @param colors, gate  grid and range of values that choose colour and opacity, as set_range() and the operator have them
    """
    kind = kind_of(header) if kind == "AUTO" else kind
    texture = header.texture
    scalar, low, highest = colors
    scalar = scalar or ("magnitude" if header.grid("magnitude") else texture)
    try:
        filled, corners = survey(context, volume)
    except EmptyVolume as error:
        return [str(error)]
    material = new_material(GROUPS[kind], kind, look, texture, scalar)
    forget_materials(volume)
    volume.data.materials.append(material)
    sides = [max(axis) - min(axis) for axis in zip(*corners)]
    volume.data["vdblic_width"] = (sides[0] * sides[1] * sides[2]) ** (1 / 3)
    frame = filled[len(filled) // 2]
    grid, clear, solid = gate
    if grid:
        solid, shares = measure(context, volume, grid, frame, solid)
        solid = max(solid, clear + 1e-3 * abs(clear))
        set_gate(material, grid, clear, solid)
        values = (solid * i / (COUNT - 1) for i in range(COUNT))
        opacity = [min(max((value - clear) / (solid - clear or 1), 0), 1) for value in values]
        set_density(volume, kind, look, opacity, shares)
    set_range(context, volume, frame, look, scalar, low, highest)
    return []


def set_range(context, volume, frame, look, scalar, low=0, highest=0):
    """Colour by a scalar, over a range that is measured unless it is given; rare values are more opaque."""
    material = volume.data.materials[0]
    kind = next(name for name, group in GROUPS.items() if flow_node(material).node_tree.name.startswith(group))
    highest, shares = measure(context, volume, scalar, frame, highest)
    material.node_tree.nodes["Scalar"].attribute_name = scalar
    if GATE in material.node_tree.nodes:
        set_colors(material, look, [1] * COUNT)
    else:
        opacity = opacities(shares)
        set_colors(material, look, opacity)
        set_density(volume, kind, look, opacity, shares)
    set_inputs(material, From=low, To=highest, Glow=LOOKS[look].glow)
    material["vdblic_look"] = look


def set_density(volume, kind, look, opacity, shares):
    """The extinction with which a ray through the volume meets the look's depth."""
    mean = KINDS[kind].share * max(sum(a * b for a, b in zip(opacity, shares)), LEAST_SHARE)
    depth = KINDS[kind].depth * LOOKS[look].depth
    set_inputs(volume.data.materials[0], Density=depth / (mean * volume.data.get("vdblic_width", 1.0)))


def prepare_render(context, volumes):
    """Render settings with which streaks stay crisp."""
    scene = context.scene
    cycles, eevee = getattr(scene, "cycles", None), scene.eevee
    if cycles:
        cycles.volume_step_rate = 1
        cycles.use_denoising = False  # it smears streaks
        if hasattr(cycles, "volume_biased"):  # from 5.0 on: no steps that could miss a streak
            cycles.volume_biased = False
    scene.render.hair_type = "STRIP"  # Eevee draws lines as thick as they are
    for volume in volumes:
        volume.data.render.step_size = 0  # a voxel
    if hasattr(eevee, "use_volume_custom_range"):  # from 4.2 on: else it is that of the volumes in each view
        eevee.use_volume_custom_range = False
    elif volumes:
        worlds = [eye(view).inverted() for view in views()]
        worlds += [scene.camera.matrix_world.inverted()] if scene.camera else []
        corners = [volume.matrix_world @ Vector(corner) for volume in volumes for corner in volume.bound_box]
        distances = [-(world @ corner).z for world in worlds for corner in corners]
        far = max(*distances, 1e-3)
        eevee.volumetric_start, eevee.volumetric_end = max(min(distances), far / 1000), far
    eevee.volumetric_tile_size = "2"
    eevee.volumetric_samples = 128


def is_volume(context):
    return context.object is not None and context.object.type == "VOLUME"


class VolumeOperator:
    @classmethod
    def poll(cls, context):
        return is_volume(context)

    def refuse(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}


class VDBLIC_OT_show(VolumeOperator, bpy.types.Operator):
    """Give the active volume a material for flow textures, with a range of colours taken from the data"""

    bl_idname = "vdblic.show"
    bl_label = "Show as Flow Texture"
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(name="Kind", items=KIND_ITEMS)
    look: EnumProperty(name="Look", items=LOOK_ITEMS)
    scalar: StringProperty(name="Colour By", description="Grid that chooses colours; magnitude, the speed, by default")
    low: FloatProperty(name="From", description="Value of the first colour")
    high: FloatProperty(
        name="To", min=0, description="Value of the last colour; 0: what a hundredth of the volume exceeds"
    )
    opacity_by: StringProperty(name="Opacity By", description="Grid that decides the opacity, in place of rare colours")
    clear: FloatProperty(name="Clear", description="Value of that grid up to which nothing is seen")
    solid: FloatProperty(name="Solid", min=0, description="Value from which all is seen; 0: as To")

    def execute(self, context):
        volume = context.object
        try:
            header = headers_of(sequence_of(path_of(volume)).files)[0]
        except (SequenceError, DamagedFile, OSError) as error:
            return self.refuse(error)
        for name in self.scalar, self.opacity_by:
            if name and name not in header.scalars:
                return self.refuse(f"{header.path}: no grid '{name}' of numbers; it has {', '.join(header.scalars)}")
        colors, gate = (self.scalar, self.low, self.high), (self.opacity_by, self.clear, self.solid)
        for warning in show(context, volume, header, self.kind, self.look, colors, gate):
            return self.refuse(warning)
        return {"FINISHED"}


class VDBLIC_OT_color_by(VolumeOperator, bpy.types.Operator):
    """Colour the active volume by a scalar, over the range of its values"""

    bl_idname = "vdblic.color_by"
    bl_label = "Colour By"
    bl_options = {"REGISTER", "UNDO"}

    scalar: StringProperty(name="Grid", default="magnitude")
    low: FloatProperty(name="From")
    high: FloatProperty(name="To", min=0, description="0: what a hundredth of the volume exceeds")

    def execute(self, context):
        volume = context.object
        material = volume.data.materials[0] if volume.data.materials else None
        if flow_node(material) is None:
            return self.refuse(f"{volume.name}: it has no material of a flow texture; use Show as Flow Texture first")
        try:
            header = read_header(path_of(volume))
            if self.scalar not in header.scalars:
                return self.refuse(
                    f"{header.path}: no grid '{self.scalar}' of numbers; it has {', '.join(header.scalars)}"
                )
            filled, _ = survey(context, volume)
        except (DamagedFile, EmptyVolume, OSError) as error:
            return self.refuse(error)
        look = material.get("vdblic_look", "FLOW")
        set_range(context, volume, filled[len(filled) // 2], look, self.scalar, self.low, self.high)
        return {"FINISHED"}


class VDBLIC_OT_prepare_render(bpy.types.Operator):
    """Set step rates, Eevee's range of distances and motion blur so that streaks stay crisp"""

    bl_idname = "vdblic.prepare_render"
    bl_label = "Prepare Render"
    bl_options = {"REGISTER", "UNDO"}

    motion_blur: BoolProperty(name="Motion Blur", description="By the grid of velocities, where the files have one")

    def execute(self, context):
        volumes = [thing for thing in context.scene.objects if thing.type == "VOLUME"]
        prepare_render(context, volumes)
        if self.motion_blur:
            without = [volume for volume in volumes if not _has_velocity(volume)]
            if volumes and len(without) == len(volumes):
                self.report(
                    {"ERROR"},
                    f"{volumes[0].data.filepath}: no grid of velocities; compute the textures with " "--with velocity",
                )
                return {"CANCELLED"}
            context.scene.render.use_motion_blur = True
        return {"FINISHED"}


def _has_velocity(volume):
    try:
        return read_header(path_of(volume)).velocity is not None
    except (DamagedFile, OSError):
        return False


CLASSES = [VDBLIC_OT_show, VDBLIC_OT_color_by, VDBLIC_OT_prepare_render]
