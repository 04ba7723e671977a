"""Statistics of a volume, measured by Blender's nodes, because its Python cannot read voxels."""

import bmesh
import bpy
from mathutils import Vector

COUNT = 6  # values evenly spaced over a range, and colours of a ramp


class EmptyVolume(ValueError):
    """A volume without voxels; the message tells the frames."""


def frames_of(volume, scene, count=5):
    data = volume.data
    if not data.is_sequence:
        return [scene.frame_current]
    last = data.frame_duration - 1
    return sorted({data.frame_start + last * i // (count - 1) for i in range(count)})


def survey(context, volume):
    """Survey a few frames; returns the frames with voxels, and the corners of their boxes in the volume's own space.

    Raises EmptyVolume.
    """
    scene, data = context.scene, volume.data
    back, filled, corners = scene.frame_current, [], []
    frames = frames_of(volume, scene)
    try:
        for frame in frames:
            scene.frame_set(frame)
            if not data.grids.load():
                raise EmptyVolume(f"{volume.name}, frame {frame}: {data.grids.error_message}")
            shown = volume.evaluated_get(context.evaluated_depsgraph_get())
            box = [Vector(corner) for corner in shown.bound_box]
            if box[0] != box[6]:  # the box of a frame without voxels has no size
                filled.append(frame)
                corners += box
    finally:
        scene.frame_set(back)
    if not corners:
        raise EmptyVolume(f"{data.filepath}: no voxels in frames {', '.join(map(str, frames))}; compute them anew")
    return filled, corners


def measure(context, volume, grid, frame, highest=0):
    """The value that a hundredth of the volume exceeds, and shares of the volume by value from 0 to it.

    The mesh of an isosurface shows how much lies above a value.
    """
    scene = context.scene
    back = scene.frame_current
    probe = bpy.data.objects.new("VDBLIC probe", bpy.data.meshes.new("VDBLIC probe"))
    scene.collection.objects.link(probe)
    surface = probe.modifiers.new("Surface", "VOLUME_TO_MESH")
    surface.object, surface.grid_name = volume, grid
    surface.resolution_mode, surface.voxel_amount = "VOXEL_AMOUNT", 48

    def amount_above(value):
        surface.threshold = value
        probe.update_tag()
        mesh = bmesh.new()
        mesh.from_object(probe, context.evaluated_depsgraph_get())
        amount = mesh.calc_volume()
        mesh.free()
        return amount

    try:
        scene.frame_set(frame)
        least = 1e-9
        everything = amount_above(least)
        if not highest:
            low = highest = least
            while highest < 1e12 and amount_above(highest) > 0.01 * everything:
                low, highest = highest, highest * 32
            while highest > 1.05 * low:
                middle = (low * highest) ** 0.5
                low, highest = (middle, highest) if amount_above(middle) > 0.01 * everything else (low, middle)
        edges = [everything, *(amount_above(highest * (i + 0.5) / (COUNT - 1)) for i in range(COUNT - 1)), 0]
    finally:
        bpy.data.meshes.remove(probe.data)
        scene.frame_set(back)
    return highest, [max(above - below, 0) / (everything or 1) for above, below in zip(edges, edges[1:])]
