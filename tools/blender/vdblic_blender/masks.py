"""Objects as masks of a run, in the world of the velocity's files."""

import pathlib

import bpy
from mathutils import Matrix, Vector

from .importing import placement
from .sequences import pattern_of
from .vdb_header import read_header


class MaskError(ValueError):
    """An object that cannot be a mask; the message tells the mend."""


def to_files(domain):
    """From the scene to the world of the velocity's files: a Mantaflow cache begins at the origin."""
    if domain is None:
        return Matrix.Identity(4)
    turn = domain.matrix_world.to_quaternion().to_matrix().to_4x4()
    return (Matrix.Translation(domain.matrix_world @ Vector(domain.bound_box[0])) @ turn).inverted()


def mask_of(context, thing, velocity, domain, folder):
    """Options of a recipe that keep to an object, and a warning or nothing.

    A volume is a mask where it stands as imported. A mesh is a level set on the velocity's voxels if Blender's Python
    has OpenVDB, else its bounding box. Raises MaskError, OSError.
    """
    if thing.type == "VOLUME":
        path = str(pathlib.Path(bpy.path.abspath(thing.data.filepath)))
        header = read_header(path)
        here = placement(header, half=True, domain=domain)
        near = 1e-4 * max(1, thing.matrix_world.translation.length)
        if max((a - b).length for a, b in zip(thing.matrix_world, here)) > near:
            raise MaskError(
                f"{thing.name}: a volume is a mask only where its file has it; do not move it, or take a mesh"
            )
        return {"mask": pattern_of(path) if thing.data.is_sequence else path}, None
    if thing.type != "MESH":
        raise MaskError(f"{thing.name}: a mask is a mesh or a volume; choose another object")
    shown = thing.evaluated_get(context.evaluated_depsgraph_get())
    mesh = shown.to_mesh()
    there = to_files(domain) @ thing.matrix_world
    points = [there @ vertex.co for vertex in mesh.vertices]
    mesh.calc_loop_triangles()
    triangles = [tuple(triangle.vertices) for triangle in mesh.loop_triangles]
    shown.to_mesh_clear()
    if not triangles:
        raise MaskError(f"{thing.name}: the mesh has no faces; choose one with a volume")
    openvdb = _openvdb()
    if openvdb is None:
        low, high = ([pick(point[axis] for point in points) for axis in range(3)] for pick in (min, max))
        return {"box": (*low, *high)}, (
            f"{thing.name}: this Blender's Python has no OpenVDB; its bounding box is the " "mask"
        )
    return {"mask": _level_set(openvdb, points, triangles, velocity, folder)}, None


def _level_set(openvdb, points, triangles, velocity, folder):
    import numpy

    header = read_header(velocity)
    grid = next(grid for grid in header.grids if grid.matrix is not None)
    size = min(Vector(axis).length for axis in grid.matrix[:3])
    surface = openvdb.FloatGrid.createLevelSetFromPolygons(
        numpy.array(points, numpy.float32),
        triangles=numpy.array(triangles, numpy.uint32),
        transform=openvdb.createLinearTransform(voxelSize=size),
    )
    surface.name = "mask"
    path = pathlib.Path(folder) / "vdblic.mask.vdb"
    path.parent.mkdir(parents=True, exist_ok=True)
    openvdb.write(str(path), grids=[surface])
    return f"{path}:mask"


def _openvdb():
    """OpenVDB for Python, where Blender has it: `openvdb` in official ones, `pyopenvdb` in Debian's."""
    for name in "openvdb", "pyopenvdb":
        try:
            return __import__(name)
        except ImportError:
            pass
    return None
