"""Blender as a client: a Mantaflow bake, its flow texture, and Blender's picture of that texture.

Pictures are correlated with projections of the texture's voxels computed here, so that one number checks position,
size, frame and content. Blender draws the value of voxel i at (i + 1/2) voxels.
"""

import itertools
import json
import math
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy
import pyopenvdb as vdb

from support import ToolTest, nightly, skip

HERE = pathlib.Path(__file__).parent
UNIFORM = [[0.1, 0, 0, 0], [0, 0.1, 0, 0], [0, 0, 0.1, 0], [0, 0, 0, 1]]


def blender(script, *arguments):
    """Run a script in Blender's background mode."""
    command = ["blender", "-b", "--factory-startup", "-t", "1", "--python-exit-code", "9", "--python", str(script), "--"]
    done = subprocess.run([*command, *map(str, arguments)], text=True, capture_output=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def to_world(grid, points):
    """World positions of points in index space, one a row."""
    origin, *axes = (numpy.array(grid.transform.indexToWorld(p)) for p in numpy.eye(4, 3, -1))
    return numpy.asarray(points) @ [axis - origin for axis in axes] + origin


def box(grid, low, high):
    """World-space bounding box of a box in index space."""
    corners = to_world(grid, list(itertools.product(*zip(low, high))))
    return corners.min(axis=0), corners.max(axis=0)


def leaf_box(grid):
    """Blender's bounding box: of the centres, by OpenVDB's convention, of all voxels of the active leaves."""
    low, high = (numpy.array(corner) // 8 * 8 for corner in grid.evalActiveVoxelBoundingBox())
    return box(grid, low, high + 7)


def projection(grid, window, pixels, offset=0.5):
    """The opacity of a texture of extinction 1, seen along +y: an image by row from z0 up, like show_sequence.py's.

    Voxel i has its value at i + `offset` in index space; between these it is linear, outside all of them 0.
    """
    low, high = grid.evalActiveVoxelBoundingBox()
    first = numpy.array(low) - 1
    values = numpy.zeros(numpy.array(high) - first + 2, numpy.float32)
    grid.copyToArray(values, ijk=first.tolist())
    origin, *axes = to_world(grid, numpy.eye(4, 3, -1))
    to_index = numpy.linalg.inv([axis - origin for axis in axes])
    step = min(numpy.linalg.norm(axis - origin) for axis in axes) / 4
    nearest, farthest = box(grid, first, numpy.array(high) + 2)

    x0, x1, z0, z1 = window
    xs, zs = (a + (numpy.arange(round((b - a) * pixels)) + 0.5) / pixels for a, b in ((x0, x1), (z0, z1)))
    x, z = numpy.meshgrid(xs, zs)
    depth = numpy.zeros_like(x)
    flat, strides = values.ravel(), numpy.array(values.strides) // values.itemsize
    for y in numpy.arange(nearest[1], farthest[1], step):
        index = (numpy.stack([x, numpy.full_like(x, y), z], axis=-1) - origin) @ to_index - offset - first
        cell = numpy.floor(index).astype(int)
        inside = numpy.all((cell >= 0) & (cell < numpy.array(values.shape) - 1), axis=-1)
        cell, part = cell[inside], (index - cell)[inside]
        voxel, weights = cell @ strides, (1 - part.T, part.T)
        for i, j, k in itertools.product((0, 1), repeat=3):
            weight = weights[i][0] * weights[j][1] * weights[k][2]
            depth[inside] += step * weight * flat[voxel + (i, j, k) @ strides]
    return 1 - numpy.exp(-depth)


def likeness(a, b):
    """Correlation of two images."""
    return numpy.corrcoef(a.ravel(), b.ravel())[0, 1]


class Blender(ToolTest):
    def bake(self, resolution, frames):
        blender(HERE / "blender/bake_smoke.py", self.folder / "cache", resolution, frames)
        return self.folder / "cache/data/fluid_data_%04d.vdb"

    def show(self, files, frames, window, pixels, samples=16, grid=None):
        """Blender's description of a sequence, and the opacity of each pixel of each frame.

        Without a material Blender shows `density`; a `grid` is shown with a material.
        """
        with tempfile.TemporaryDirectory(dir=self.folder) as folder:
            request = pathlib.Path(folder) / "request.json"
            request.write_text(json.dumps({"files": list(map(str, files)), "frames": list(frames), "window": window,
                                           "pixels": pixels, "samples": samples, "grid": grid}))
            blender(HERE / "blender/show_sequence.py", request)
            answer = json.loads((request.parent / "answer.json").read_text())
            return answer, {frame: numpy.load(request.parent / f"alpha.{frame}.npy") for frame in frames}

    def assert_shows(self, image, grid, window, pixels):
        """An image is the projection of a grid, and no other offset of the grid's values fits the image better."""
        expected = {offset: projection(grid, window, pixels, offset) for offset in (0, 0.25, 0.5, 0.75, 1)}
        like = {offset: likeness(image, view) for offset, view in expected.items()}
        self.assertEqual(max(like, key=like.get), 0.5, like)
        self.assertGreater(like[0.5], 0.99)
        self.assertAlmostEqual(image.mean(), expected[0.5].mean(), delta=0.02 * image.mean())

    @nightly
    def test_a_mantaflow_bake_through_advect_is_where_and_when_its_voxels_are(self):
        files = self.outputs("vdblic_advect", self.bake(20, 6), "-o", "lic.%04d.vdb", "--frames", "3-6")
        grids = [vdb.read(str(file), "density") for file in files]
        window, pixels = (-1, 5, -1, 7), 16  # a metre more than the simulation's box; five pixels a voxel
        answer, images = self.show(files, (1, 2, 3, 4), window, pixels)

        views = [projection(grid, window, pixels) for grid in grids]
        self.assertTrue(answer["is_sequence"])
        self.assertEqual((answer["volumes"], answer["frame_start"], answer["frame_duration"]), (1, 1, 4))
        for frame, file, grid in zip(images, files, grids):
            shown = answer["frames"][str(frame)]
            self.assertEqual((shown["file"], shown["error"]), (file.name, ""))
            self.assertEqual(set(shown["grids"]), {"density", "magnitude"})
            numpy.testing.assert_allclose((shown["low"], shown["high"]), leaf_box(grid), atol=1e-4)
            self.assert_shows(images[frame], grid, window, pixels)
            # The image shows its own frame, not a neighbour.
            like = [likeness(images[frame], view) for view in views]
            self.assertEqual(numpy.argmax(like), frame - 1, like)

    def velocities(self, prefix, rows, frames=(1,), empty=()):
        """A swirl of 20 by 16 by 12 voxels, with a transform given by the rows of a matrix; some frames empty."""
        x, y, z = numpy.meshgrid(*(numpy.arange(n, dtype=numpy.float32) for n in (20, 16, 12)), indexing="ij")
        for frame in frames:
            grid = vdb.Vec3SGrid()
            grid.name = "velocity"
            grid.transform = vdb.createLinearTransform(rows)
            if frame not in empty:
                grid.copyFromArray(numpy.stack([8 - y, x - 10, 2 + 0 * z], axis=-1), ijk=(-3, 4, 1))
            vdb.write(str(self.folder / f"{prefix}.{frame:04}.vdb"), grids=[grid])
        return self.outputs("vdblic_advect", f"{prefix}.%04d.vdb", "-o", f"{prefix}-lic.%04d.vdb",
                            "--velocity-unit", "voxel/frame", "--velocity-scale", "0.2")

    def test_scaled_and_turned_volumes(self):
        c, s = 0.1 * math.cos(0.5), 0.1 * math.sin(0.5)
        placements = {
            "scaled": [[0.1, 0, 0, 0], [0, 0.15, 0, 0], [0, 0, 0.2, 0], [1, -2, 0.5, 1]],
            "turned": [[c, 0, -s, 0], [0, 0.1, 0, 0], [s, 0, c, 0], [-0.3, 5, 0.2, 1]],
        }
        for name, rows in placements.items():
            with self.subTest(name):
                file, = self.velocities(name, rows)
                grid = vdb.read(str(file), "density")
                (x0, _, z0), (x1, _, z1) = box(grid, (-4, 3, 0), (18, 21, 14))
                window = x0, x1, z0, z1
                self.assert_shows(self.show([file], [1], window, 48)[1][1], grid, window, 48)

    @nightly
    def test_scalars_on_the_textures_voxels_are_where_the_texture_is(self):
        """Blender shifts a grid by half its own voxel, so a texture of finer voxels lies beside coarse scalars."""
        size, factor, first, centre = 0.2, 4, numpy.array((-8, 3, 2)), numpy.array((0.3, 2.0, 1.9))
        velocity = vdb.Vec3SGrid()
        velocity.name = "velocity"
        velocity.transform = vdb.createLinearTransform(voxelSize=size)
        index = numpy.stack(numpy.meshgrid(*(numpy.arange(n) for n in (19, 13, 15)), indexing="ij"), axis=-1) + first
        speed = numpy.exp(-(((index * size - centre) / 0.5) ** 2).sum(axis=-1))  # symmetric about `centre`
        velocity.copyFromArray((speed[..., None] * (1, 0, 0)).astype(numpy.float32), ijk=first.tolist())
        vdb.write(str(self.folder / "v.vdb"), grids=[velocity])
        files = {scalars: self.outputs("vdblic_advect", "v.vdb", "-o", f"{scalars}.vdb", "--refine", factor, "--scalars",
                                       scalars, "--dt", 1)[0] for scalars in ("velocity", "texture")}

        window, pixels = (-2, 2.6, 0, 3.8), 30
        density = vdb.read(str(files["texture"]), "density")
        self.assertAlmostEqual(density.transform.voxelSize()[0], size / factor)
        self.assert_shows(self.show([files["texture"]], [1], window, pixels)[1][1], density, window, pixels)
        x, z = (a + (numpy.arange(round((b - a) * pixels)) + 0.5) / pixels for a, b in (window[:2], window[2:]))
        shift = {}
        for scalars, file in files.items():
            image = self.show([file], [1], window, pixels, samples=64, grid="magnitude")[1][1]
            depth = -numpy.log(1 - image.clip(0, 0.999))
            shift[scalars] = numpy.array(((depth @ x).sum(), (z @ depth).sum())) / depth.sum() - centre[[0, 2]]
        numpy.testing.assert_allclose(shift["texture"], size / factor / 2, atol=0.002)
        numpy.testing.assert_allclose(shift["velocity"], size / 2, atol=0.002)

    @nightly
    def test_only_empty_frames_are_blank(self):
        files = self.velocities("gap", UNIFORM, range(7, 11), empty=(7, 9))
        images = self.show(files, (1, 2, 3, 4), (-1, 2, -1, 2), 32, samples=4)[1]
        self.assertEqual([image.max() > 0.1 for image in images.values()], [False, True, False, True])


if __name__ == "__main__":
    if not shutil.which("blender"):
        skip("Blender is missing")
    unittest.main()
