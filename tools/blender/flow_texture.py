"""Shows a flow texture of vdblic_advect in Blender: imports the sequence, shades it, and lights and frames it.

    blender --python flow_texture.py -- lic.0001.vdb                            a new scene, in the window
    blender shot.blend --python flow_texture.py -- lic.0001.vdb                 into a scene of yours
    blender -b --python flow_texture.py -o image.#### -f 12 -- lic.0001.vdb --preview    a small, grainy picture
    blender -b --python flow_texture.py -o image.#### -f 12 -- lic.0001.vdb     frame 12 without a window; -a: all

Any file of the sequence names it; scene frame 12 shows the file of number 12. After `--` also: --help.
From the Text editor, without a file: shades the selected volume (Add > Volume > Import OpenVDB beforehand).

Grid `density`, the texture, becomes streaks; grid `magnitude`, the speed, chooses their colour and opacity. All of it
is nodes of one material, "Flow texture", that can be changed afterwards. A camera and a light are added where the
scene has none. Frame range, world and render settings are set in a new scene only: Blender's startup scene, whose
cube, lamp and camera make way.
"""

import argparse
import pathlib
import re
import sys

import bmesh
import bpy
from mathutils import Matrix, Vector

# Of dense textures and of sparse ones, whose streaks have nothing between them: texture values at which streaks begin
# and reach full density; the fraction of a texture that is streaks; mean optical depth across the volume.
DENSE = (0.62, 0.76), 0.12, 4
SPARSE = (0.1, 0.6), 0.06, 1.2
GLOW = 0.3  # emission of streaks, so that shaded ones keep their colour

# From no speed to the highest, in linear light.
COLORS = (
    (0.01, 0.03, 0.35),
    (0.02, 0.25, 0.90),
    (0.03, 0.70, 0.60),
    (0.45, 0.80, 0.05),
    (1.00, 0.45, 0.03),
    (0.85, 0.04, 0.02),
)


def arguments():
    parser = argparse.ArgumentParser(prog="flow_texture.py", description="Show a flow texture of vdblic_advect.")
    parser.add_argument("file", nargs="?", help="any file of the sequence; without one: the selected volume")
    parser.add_argument("--texture", default="density", metavar="GRID", help="the texture's grid (default: density)")
    parser.add_argument("--speed", type=float, help="speed of the last colour (default: nearly the fastest there is)")
    parser.add_argument("--domain", metavar="OBJECT", help="put a texture of a Mantaflow cache on its domain object")
    parser.add_argument("--y-up", action="store_true", help="stand a texture of Houdini's velocities upright")
    parser.add_argument("--preview", action="store_true", help="a quarter of the width and height, few samples")
    own = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    return parser.parse_args(own)


def sequence(path):
    """All files of a file's sequence, in order of number, and the first number."""
    path = pathlib.Path(path).absolute()
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such file")
    number = re.search(r"\d+$", path.stem)
    if not number:
        return [path], None
    prefix = path.stem[:number.start()]
    digits = re.compile(re.escape(prefix) + r"(\d+)\.vdb")
    found = {int(match[1]): file for file in path.parent.iterdir() if (match := digits.fullmatch(file.name))}
    first, last = min(found), max(found)
    missing = next((frame for frame in range(first, last) if frame not in found), None)
    if missing is not None:
        raise FileNotFoundError(f"{path.parent / prefix}*.vdb: frame {missing} is missing, and Blender plays "
                                f"only sequences without gaps; give the frames numbers that follow each other")
    return [found[frame] for frame in sorted(found)], first


def is_sparse(path):
    """Whether a file tells that its inactive voxels are empty (docs/formats.md); Blender does not read such metadata."""
    text = lambda value: len(value).to_bytes(4, "little") + value
    with open(path, "rb") as file:
        return b"".join(map(text, (b"inactive", b"string", b"empty"))) in file.read(1 << 16)


def import_volume(path):
    """Import a file's sequence like the file browser, each file at the scene frame of its number."""
    files, first = sequence(path)
    bpy.ops.object.volume_import(
        filepath=str(files[0]), directory=str(files[0].parent), files=[{"name": file.name} for file in files],
        use_sequence_detection=first is not None and len(files) > 1, align="WORLD", location=(0, 0, 0))
    volume = bpy.context.object
    if volume.data.is_sequence:
        volume.data.frame_start = first  # Blender puts the first file on scene frame 1
    return volume


def selected_volume():
    volume = bpy.context.object
    if not volume or volume.type != "VOLUME":
        raise ValueError("select a volume, or name a file: blender --python flow_texture.py -- lic.0001.vdb")
    return volume


def place(volume, domain, y_up):
    """Place a volume: Mantaflow's files start at the origin, not at their domain; Houdini's have y upwards."""
    if domain:
        if domain not in bpy.data.objects:
            raise ValueError(f"there is no object {domain!r}; --domain names the smoke domain")
        box = bpy.data.objects[domain]
        turn = box.matrix_world.to_quaternion().to_matrix().to_4x4()
        volume.matrix_world = Matrix.Translation(box.matrix_world @ Vector(box.bound_box[0])) @ turn
    if y_up:
        volume.matrix_world = volume.matrix_world @ Matrix.Rotation(1.5707963, 4, "X")


def survey(volume, texture):
    """Load a few frames; returns those with voxels, and the corners of their boxes in the volume's own space."""
    scene, data = bpy.context.scene, volume.data
    back, filled, corners = scene.frame_current, [], []
    last = data.frame_duration - 1
    frames = sorted({data.frame_start + last * i // 4 for i in range(5)}) if data.is_sequence else [back]
    for frame in frames:
        scene.frame_set(frame)
        if not data.grids.load():
            raise ValueError(f"{volume.name}, frame {frame}: {data.grids.error_message}")
        for grid in texture, "magnitude":
            if grid not in data.grids:
                raise ValueError(f"{data.grids.frame_filepath or data.filepath}: no grid {grid!r} but "
                                 f"{', '.join(data.grids.keys())}; --texture names the texture")
        shown = volume.evaluated_get(bpy.context.evaluated_depsgraph_get())
        box = [Vector(corner) for corner in shown.bound_box]
        if box[0] != box[6]:  # the box of a frame without voxels has no size
            filled.append(frame)
            corners += box
    scene.frame_set(back)
    if not corners:
        raise ValueError(f"{data.filepath}: no voxels in frames {', '.join(map(str, frames))}")
    return filled, corners


def warn_if_apart(volume, texture, corners):
    """Tell where streaks and colours are apart by more than a hundredth of the volume.

    Blender draws a grid's values half a voxel of that grid off their positions, so grids of different voxels lie apart.
    """
    data = volume.data
    data.grids.load()
    half = Vector((0.5, 0.5, 0.5, 0))
    shifts = [data.grids[grid].matrix_object @ half for grid in (texture, "magnitude")]
    apart = (shifts[1] - shifts[0]).length
    if apart > 0.01 * max((a - b).length for a in corners for b in corners):
        print(f"{data.filepath}: warning: magnitude has other voxels than {texture}, and Blender draws it {apart:.3g} "
              "beside it; compute the textures with vdblic_advect --scalars texture")


def measure_speeds(volume, frame, highest, count=len(COLORS)):
    """The speed of the last colour, and the histogram of the volume's speeds from 0 to that speed.

    `highest`, where it is not given, is the speed that a hundredth of the volume exceeds. Blender's Python cannot
    read voxels, but the mesh of an isosurface shows how much lies above a speed.
    """
    scene = bpy.context.scene
    back = scene.frame_current
    scene.frame_set(frame)
    probe = bpy.data.objects.new("Speed probe", bpy.data.meshes.new("Speed probe"))
    scene.collection.objects.link(probe)
    surface = probe.modifiers.new("Surface", "VOLUME_TO_MESH")
    surface.object, surface.grid_name = volume, "magnitude"
    surface.resolution_mode, surface.voxel_amount = "VOXEL_AMOUNT", 64

    def amount_above(speed):
        surface.threshold = speed
        probe.update_tag()
        mesh = bmesh.new()
        mesh.from_object(probe, bpy.context.evaluated_depsgraph_get())
        amount = mesh.calc_volume()
        mesh.free()
        return amount

    slowest = 1e-9
    everything = amount_above(slowest)
    if not highest:
        low = highest = slowest
        while highest < 1e12 and amount_above(highest) > 0.01 * everything:
            low, highest = highest, highest * 32
        while highest > 1.05 * low:
            middle = (low * highest) ** 0.5
            low, highest = (middle, highest) if amount_above(middle) > 0.01 * everything else (low, middle)

    edges = [everything, *(amount_above(highest * (i + 0.5) / (count - 1)) for i in range(count - 1)), 0]
    bpy.data.meshes.remove(probe.data)
    scene.frame_set(back)
    return highest, [(above - below) / (everything or 1) for above, below in zip(edges, edges[1:])]


def opacities(shares):
    """Opacity by speed: fast and rare speeds are more opaque, so that common ones do not hide the rest."""
    last = len(shares) - 1
    return [min((0.1 + i / last) / max(share * last, 0.25), 1) for i, share in enumerate(shares)]


def flow_material(texture, streaks_between, speed, opacity, scale):
    """A material of `texture` and `magnitude`. Streaks begin at one texture value and are full at another.

    Colours and opacity, 0 to 1, are spaced evenly from no speed up to `speed`; a full streak of opacity 1 has the
    extinction `scale`, per unit of length of the volume's own space.
    """
    material = bpy.data.materials.new("Flow texture")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()

    def node(kind, label, x, y, **settings):
        made = nodes.new("ShaderNode" + kind)
        made.label, made.location, made.width = label, (x, y), 220
        for name, value in settings.items():
            setattr(made, name, value)
        return made

    def stretch(label, x, y, low, high, source, interpolation="LINEAR"):
        made = node("MapRange", label, x, y, interpolation_type=interpolation)
        made.inputs["From Min"].default_value, made.inputs["From Max"].default_value = low, high
        links.new(source, made.inputs["Value"])
        return made.outputs["Result"]

    def multiply(label, x, y, first, second):
        made = node("Math", label, x, y, operation="MULTIPLY")
        for value, socket in zip((first, second), made.inputs):
            if isinstance(value, float):
                socket.default_value = value
            else:
                links.new(value, socket)
        return made.outputs["Value"]

    lic = node("Attribute", "Texture", -1100, 0, attribute_name=texture)
    magnitude = node("Attribute", "Speed", -1100, -300, attribute_name="magnitude")
    streaks = stretch("Streaks: contrast", -850, 0, *streaks_between, lic.outputs["Fac"], "SMOOTHSTEP")
    place_of_speed = stretch("Speed: range", -850, -300, 0, speed, magnitude.outputs["Fac"])

    colors = node("ValToRGB", "Colour and opacity by speed", -600, -300)
    ramp = colors.color_ramp
    while len(ramp.elements) < len(COLORS):
        ramp.elements.new(0.5)
    for i, (element, color) in enumerate(zip(ramp.elements, COLORS)):
        element.position, element.color = i / (len(COLORS) - 1), (*color, opacity[i])
    links.new(place_of_speed, colors.inputs["Fac"])

    seen = multiply("Streaks of this speed", -300, 0, streaks, colors.outputs["Alpha"])
    density = multiply("Opacity", -50, 0, seen, scale)
    glow = multiply("Glow", -50, -200, density, GLOW)
    shader = node("VolumePrincipled", "", 220, 0)
    shader.inputs["Density Attribute"].default_value = ""
    links.new(colors.outputs["Color"], shader.inputs["Color"])
    links.new(density, shader.inputs["Density"])
    links.new(colors.outputs["Color"], shader.inputs["Emission Color"])
    links.new(glow, shader.inputs["Emission Strength"])
    output = node("OutputMaterial", "", 500, 0)
    links.new(shader.outputs["Volume"], output.inputs["Volume"])
    return material


def clear_startup_scene():
    """Remove the cube, lamp and camera of Blender's startup scene; returns whether the scene was that one."""
    things = bpy.data.objects
    untouched = not bpy.data.filepath and {thing.name for thing in things} <= {"Cube", "Light", "Camera"}
    if untouched:
        for thing in list(things):
            bpy.data.objects.remove(thing)
    return untouched


def add_light():
    lamp = bpy.data.lights.new("Flow light", "SUN")
    lamp.energy, lamp.angle = 8, 0.1
    light = bpy.data.objects.new("Flow light", lamp)
    light.rotation_euler = Vector((-0.5, -0.45, 0.75)).to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(light)


def add_camera(corners):
    """Add a camera that sees all corners from the front, slightly to the side and above."""
    scene = bpy.context.scene
    lens = bpy.data.cameras.new("Flow camera")
    camera = bpy.data.objects.new("Flow camera", lens)
    scene.collection.objects.link(camera)
    scene.camera = camera
    size = max((a - b).length for a in corners for b in corners)
    lens.clip_start, lens.clip_end = size / 1000, size * 100
    camera.rotation_euler = Vector((0.35, -1, 0.45)).to_track_quat("Z", "Y").to_euler()
    bpy.context.view_layer.update()
    coordinates = [coordinate for corner in corners for coordinate in corner]
    camera.location, _ = camera.camera_fit_coords(bpy.context.evaluated_depsgraph_get(), coordinates)
    bpy.context.view_layer.update()

    # Eevee draws volumes only in a range of distances, by default 0.1 to 100.
    distances = [-(camera.matrix_world.inverted() @ corner).z for corner in corners]
    eevee = scene.eevee
    eevee.volumetric_start, eevee.volumetric_end = max(min(distances), size / 100), max(distances)
    eevee.volumetric_tile_size, eevee.volumetric_samples = "2", 128


def set_up_new_scene(volume):
    """Set up a new scene: frame range, dark world, render settings for volumes."""
    scene, data = bpy.context.scene, volume.data
    if data.is_sequence:
        scene.frame_start, scene.frame_end = data.frame_start, data.frame_start + data.frame_duration - 1
        scene.frame_set(scene.frame_start)
    if not scene.world:
        scene.world = bpy.data.worlds.new("Flow world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.004, 0.006, 0.01, 1)
    scene.view_settings.view_transform = "Standard"
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 64
    scene.cycles.use_denoising = False  # denoising smears streaks, and Debian's Blender does not have it


def make_small():
    """Render pictures that take seconds."""
    scene = bpy.context.scene
    scene.render.resolution_percentage = 25
    scene.cycles.samples = 8


def main():
    options = arguments()
    new_scene = bool(options.file) and clear_startup_scene()
    volume = import_volume(options.file) if options.file else selected_volume()
    place(volume, options.domain, options.y_up)
    if new_scene:
        set_up_new_scene(volume)
    if options.preview:
        make_small()
    filled, corners = survey(volume, options.texture)
    warn_if_apart(volume, options.texture, corners)
    speed, shares = measure_speeds(volume, filled[len(filled) // 2], options.speed)

    path = bpy.path.abspath(volume.data.grids.frame_filepath or volume.data.filepath)
    between, streaks_share, depth = SPARSE if is_sparse(path) else DENSE
    opacity = opacities(shares)
    mean_opacity = streaks_share * sum(a * b for a, b in zip(opacity, shares)) or 1
    sides = [max(axis) - min(axis) for axis in zip(*corners)]
    width = (sides[0] * sides[1] * sides[2]) ** (1 / 3)
    volume.data.materials.clear()
    volume.data.materials.append(
        flow_material(options.texture, between, speed, opacity, depth / (mean_opacity * width)))

    if not any(thing.type == "LIGHT" for thing in bpy.context.scene.objects):
        add_light()
    if not bpy.context.scene.camera:
        add_camera([volume.matrix_world @ corner for corner in corners])


main()
