"""A sequence of volumes into the scene: right frames, place and orientation."""

import itertools
import math
import pathlib

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, StringProperty
from bpy_extras.io_utils import ImportHelper
from mathutils import Matrix, Vector

from .framing import select_only, stage
from .materials import forget_materials
from .sequences import SequenceError, sequence_of
from .showing import show
from .vdb_header import DamagedFile, headers_of

APART = 0.01  # of the volume's size: anything drawn farther beside the texture is reported

AXES = (
    ("AUTO", "As the Files", "y where the files or their velocities are Houdini's, else z"),
    ("Z", "Z", "The files have z up, as Blender"),
    ("Y", "Y", "The files have y up, as Houdini"),
)


class UnshowableError(ValueError):
    """A sequence that cannot be shown; the message names the file and the mend."""


def check(headers):
    """Check for files that Blender would draw blank or misplaced. Returns warnings. Raises UnshowableError."""
    warnings = []
    for header in headers:
        texture = header.texture
        if texture is None:
            there = ", ".join(grid.name or "without a name" for grid in header.grids) or "none"
            raise UnshowableError(f"{header.path}: no grid of numbers with a name to show; grids: {there}")
        grid = header.grid(texture)
        if not grid.kind.startswith("Tree_float"):
            raise UnshowableError(
                f"{header.path}: '{texture}' has no voxels of numbers; if it has lines, import the layer that "
                "vdblic_export -o flow.usda makes of them"
            )
        if grid.matrix is None:
            raise UnshowableError(
                f"{header.path}: grid '{texture}' has a frustum, which Blender draws blank; resample it "
                "(VDB Resample in Houdini)"
            )
        if grid.is_mirrored:
            raise UnshowableError(
                f"{header.path}: grid '{texture}' is mirrored, which Blender draws blank; resample the "
                "velocities onto voxels that are not, and compute the textures anew"
            )
    first = headers[0]
    grid = first.grid(first.texture)
    if any(header.grid(first.texture) is None for header in headers):
        missing = next(header for header in headers if header.grid(first.texture) is None)
        raise UnshowableError(
            f"{missing.path}: no grid '{first.texture}', which {pathlib.Path(first.path).name} has; "
            "use files of one run"
        )
    moved = next((h for h in headers if h.grid(first.texture).matrix[:3] != grid.matrix[:3]), None)
    if moved:
        warnings.append(
            f"{moved.path}: other voxels than in {pathlib.Path(first.path).name}; each frame is shown where its "
            "own are, and half a voxel is that of the first"
        )
    for name in first.scalars:
        apart = drawn_apart(grid, first.grid(name))
        if apart > APART:
            warnings.append(
                f"{first.path}: '{name}' has other voxels than '{first.texture}', and Blender draws it "
                f"{apart:.0%} of the volume beside it; compute with --scalars texture"
            )
    return warnings


def drawn_beside(grid):
    """The offset from OpenVDB's places of a grid's values to Blender's.

    Half a voxel along each axis up to Blender 4.5; nothing from 5.0 on (measured with Cycles, test_blender_addon.py).
    """
    if bpy.app.version >= (5, 0, 0):
        return Vector()
    return sum((Vector(axis) for axis in grid.matrix[:3]), Vector()) / 2


def drawn_apart(texture, other):
    """How far from the texture another grid is drawn, as a share of the volume's size."""
    if other.matrix is None or texture.box is None:
        return 0
    size = (Vector(texture.to_world(texture.box[1])) - Vector(texture.to_world(texture.box[0]))).length
    return (drawn_beside(other) - drawn_beside(texture)).length / size if size else 0


def placement(header, up="AUTO", half=True, domain=None, lines=False):
    """The matrix of the object of a volume, or of lines, whose speed is on the velocity's voxels.

    Its values lie where OpenVDB has them. On a Mantaflow domain they lie in the domain, whose cells begin at its
    corner.
    """
    grid = header.grid("magnitude" if lines else header.texture)
    shift = -drawn_beside(grid) if (half or domain) and not lines else Vector()
    base = Matrix.Identity(4)
    if domain:
        turn = domain.matrix_world.to_quaternion().to_matrix().to_4x4()
        base = Matrix.Translation(domain.matrix_world @ Vector(domain.bound_box[0])) @ turn
        counts = (1, 1, 1) if lines else header.refinement
        coarse = [Vector(axis) * count for axis, count in zip(grid.matrix[:3], counts)]
        shift += sum(coarse, Vector()) / 2
    elif up == "Y" or up == "AUTO" and header.is_y_up:
        base = Matrix.Rotation(math.pi / 2, 4, "X")
    return base @ Matrix.Translation(shift)


def import_volume(context, path, up="AUTO", half=True, domain=None, again=None):
    """Add a file's sequence to the scene, each file at the frame of its number.

    Nothing is added unless all is well. Returns the object, the first file's header, what was added, and warnings.
    Raises SequenceError, DamagedFile, UnshowableError, OSError.
    @param again  an object that shows it in place of what it shows
    """
    sequence = sequence_of(path)
    headers = headers_of(sequence.files)
    warnings = check(headers)
    name = sequence.files[0].stem.rstrip("0123456789").rstrip("._- ") or sequence.files[0].stem
    data = bpy.data.volumes.new(name)
    data.filepath = str(sequence.files[0])
    if sequence.first is not None and len(sequence.files) > 1:
        data.is_sequence = True
        data.frame_duration = len(sequence.files)
        data.frame_start, data.frame_offset = sequence.first, sequence.first - 1
    if again:
        forget_materials(again)
        old, volume = again.data, again
        again.data = data
        if not old.users:
            bpy.data.volumes.remove(old)
        if bpy.app.version >= (5, 0, 0):
            warnings.append(f"{path}: this Blender shows the voxels that it first read from a file until it is started anew")
    else:
        volume = bpy.data.objects.new(name, data)
        context.collection.objects.link(volume)
    volume.matrix_world = placement(headers[0], up, half, domain)
    data["vdblic"] = headers[0].texture
    if headers[0].velocity:
        # Blender's second is that of the scene, in which a frame may stand for an hour of the flow.
        rate = context.scene.render.fps / context.scene.render.fps_base
        data.velocity_unit = "SECOND"  # Blender finds the grid by its name when it loads the file
        data.velocity_scale = (headers[0].dt or 1 / rate) * rate
    told = ""
    if not again:
        grids = [header.grid(header.texture) for header in headers]
        corners = [volume.matrix_world @ Vector(grid.to_world(corner)) for grid in grids for corner in corners_of(grid)]
        frames = (sequence.first, sequence.last) if data.is_sequence else ()
        told, hidden = stage(context, volume, corners or [volume.matrix_world.translation], *frames, domain=domain)
        warnings += hidden
    return volume, headers[0], told, warnings


def corners_of(grid):
    """The corners of a grid's box in index space; none where it has no voxels."""
    return list(itertools.product(*zip(*grid.box))) if grid.box else []


class VDBLIC_OT_import_sequence(bpy.types.Operator, ImportHelper):
    """Import a sequence of .vdb files, each at the frame of its number, in its right place"""

    bl_idname = "vdblic.import_sequence"
    bl_label = "Import Flow Texture"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".vdb"

    filter_glob: StringProperty(default="*.vdb", options={"HIDDEN"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    up: EnumProperty(name="Up", items=AXES, description="Axis of the files that points up")
    half: BoolProperty(
        name="OpenVDB's Place",
        default=True,
        description="Move the volume by half a voxel where Blender draws it beside (before 5.0), so that values lie "
        "where OpenVDB and other programs have them",
    )
    domain: StringProperty(name="Domain", description="Mantaflow domain object that the volume stands on")
    material: BoolProperty(
        name="Material", default=True, description="Give the volume a material with colours by speed"
    )
    set_range: BoolProperty(name="Scene Frame Range", default=False, description="Let the scene play these frames")

    def execute(self, context):
        domain = context.scene.objects.get(self.domain) if self.domain else None
        if self.domain and not domain:
            self.report({"ERROR"}, f"there is no object {self.domain!r}; name the Mantaflow domain")
            return {"CANCELLED"}
        path = self.filepath
        if self.files and self.files[0].name:
            path = str(pathlib.Path(self.directory) / self.files[0].name)
        try:
            volume, header, told, warnings = import_volume(context, path, self.up, self.half, domain)
        except (SequenceError, DamagedFile, UnshowableError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        select_only(context, volume)
        data = volume.data
        if self.set_range and data.is_sequence:
            context.scene.frame_start, context.scene.frame_end = (
                data.frame_start,
                data.frame_start + data.frame_duration - 1,
            )
        if self.material:
            warnings += show(context, volume, header)
        self.report({"INFO"}, told)
        for warning in warnings:
            self.report({"WARNING"}, warning)
        return {"FINISHED"}

    def invoke(self, context, event):
        if self.files and self.files[0].name:  # dropped
            return self.execute(context)
        return super().invoke(context, event)


def menu(self, context):
    self.layout.operator(VDBLIC_OT_import_sequence.bl_idname, text="Flow Texture (.vdb)")


CLASSES = [VDBLIC_OT_import_sequence]
if hasattr(bpy.types, "FileHandler"):  # from 4.1 on

    class VDBLIC_FH_import_sequence(bpy.types.FileHandler):
        bl_idname = "VDBLIC_FH_import_sequence"
        bl_label = "Flow Texture"
        bl_import_operator = VDBLIC_OT_import_sequence.bl_idname
        bl_file_extensions = ".vdb"

        @classmethod
        def poll_drop(cls, context):
            return context.area and context.area.type in ("VIEW_3D", "OUTLINER")

    CLASSES.append(VDBLIC_FH_import_sequence)
