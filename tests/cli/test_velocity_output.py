"""vdblic_advect --with velocity: the grid `vel` for motion blur."""

import unittest

import numpy
import pyopenvdb as vdb

from support import ToolTest

LOW, SIZE = (-3, 4, 1), (14, 12, 10)


def flow(points):
    """A velocity in world units per second, linear in space."""
    x, y, z = numpy.moveaxis(numpy.asarray(points, float), -1, 0)
    return numpy.stack([2 - y, 0.5 * x + z, 1 + 0 * x], axis=-1)


class VelocityOutput(ToolTest):
    def velocity(self, name, rows, unit=1.0):
        grid = vdb.Vec3SGrid()
        grid.name, grid.transform = "velocity", vdb.createLinearTransform(rows)
        index = numpy.stack(numpy.meshgrid(*map(numpy.arange, SIZE), indexing="ij"), axis=-1) + LOW
        places = numpy.array([grid.transform.indexToWorld(tuple(map(float, i))) for i in index.reshape(-1, 3)])
        grid.copyFromArray((flow(places) / unit).astype(numpy.float32).reshape(*SIZE, 3), ijk=LOW)
        vdb.write(str(self.folder / name), grids=[grid])

    def assert_is_the_flow(self, name, factor=1.0, tolerance=1e-3):
        grid = vdb.read(str(self.folder / name), "vel")
        self.assertEqual(grid.vectorType, "contravariant relative")
        low, high = grid.evalActiveVoxelBoundingBox()
        voxels = [
            (i, j, k) for i in (low[0] + 3, high[0] - 3) for j in (low[1] + 3, high[1] - 3) for k in (low[2] + 3,)
        ]
        access = grid.getConstAccessor()
        for voxel in voxels:
            self.assertTrue(access.isValueOn(voxel))
            place = grid.transform.indexToWorld(tuple(map(float, voxel)))
            numpy.testing.assert_allclose(access.getValue(voxel), factor * flow(place), rtol=tolerance, atol=0.004)
        return grid

    def test_world_units_per_second_on_both_kinds_of_voxels(self):
        half = 0.5**0.5
        rows = [[0.2 * half, 0.2 * half, 0, 0], [-0.1 * half, 0.1 * half, 0, 0], [0, 0, 0.3, 0], [1, 2, -3, 1]]
        self.velocity("v.vdb", rows)
        run = ("vdblic_advect", "v.vdb", "--preroll", 0, "--dt", 0.04, "--with", "velocity,q", "--refine", 2)
        for scalars, factor in ("velocity", 1), ("texture", 2):
            self.outputs(*run, "-o", f"{scalars}.vdb", "--scalars", scalars)
            grid = self.assert_is_the_flow(f"{scalars}.vdb")
            like = vdb.read(str(self.folder / f"{scalars}.vdb"), "density" if factor == 2 else "magnitude")
            self.assertEqual(grid.activeVoxelCount(), like.activeVoxelCount())
            self.assertEqual(grid.transform.voxelSize(), like.transform.voxelSize())
        # Streaks are no different, and threads change nothing.
        streaks = ("vdblic_advect", "v.vdb", "--dt", 0.04, "--with", "velocity", "--method", "streaks", "--spacing", 3)
        self.outputs(*streaks, "-o", "s.vdb", "--threads", 1)
        self.outputs(*streaks, "-o", "t.vdb", "--threads", 3)
        self.assert_is_the_flow("s.vdb")
        self.assertEqual(self.contents("s.vdb"), self.contents("t.vdb"))

    def test_units_and_slow_motion(self):
        self.velocity("v.vdb", [[0.2, 0, 0, 0], [0, 0.2, 0, 0], [0, 0, 0.2, 0], [0, 0, 0, 1]], unit=0.2 / 0.5)
        options = "--velocity-unit", "voxel/frame", "--dt", 0.5, "--precision", "float"
        voxels = ("vdblic_advect", "v.vdb", *options, "--velocity-scale", 0.4, "--with", "velocity", "--preroll", 0)
        self.outputs(*voxels, "-o", "a.vdb")
        self.assert_is_the_flow("a.vdb", factor=0.4, tolerance=1e-5)
        self.outputs(*voxels, "-o", "b.vdb", "--motion", 0.25)
        self.assert_is_the_flow("b.vdb", factor=0.1, tolerance=1e-5)

    def test_other_tools_take_the_files(self):
        self.velocity("v.1.vdb", [[0.2, 0, 0, 0], [0, 0.2, 0, 0], [0, 0, 0.2, 0], [0, 0, 0, 1]])
        self.outputs("vdblic_advect", "v.%d.vdb", "-o", "t.%d.vdb", "--with", "velocity", "--preroll", 0)
        self.outputs("vdblic_advect", "t.%d.vdb", "-o", "again.%d.vdb", "--preroll", 0)
        info = self.run_tool("vdblic_info", "t.%d.vdb")
        self.assertIn("velocity: grid vel; unit world/s", info.stderr)

    def test_mistakes(self):
        self.velocity("v.vdb", [[0.2, 0, 0, 0], [0, 0.2, 0, 0], [0, 0, 0.2, 0], [0, 0, 0, 1]])
        for words, *options in (
            ("'velocity' is asked for twice", "--with", "velocity,velocity"),
            ("known are vorticity, q, velocity and hits", "--with", "vel"),
            ("'vel' cannot be the texture's name", "--with", "velocity", "--texture-name", "vel"),
            ("'vel' to carry along has the name of an output", "--with", "velocity", "--carry", "vel"),
        ):
            with self.subTest(words):
                self.assertIn(words, self.fails(2, "vdblic_advect", "v.vdb", "-o", "x.vdb", *options))


if __name__ == "__main__":
    unittest.main()
