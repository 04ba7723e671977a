"""vdblic_export --levels: coarser copies in the same place."""

import unittest

import numpy
import pyopenvdb as vdb

import python_module  # pylint: disable=unused-import
from support import ToolTest



def dense(grid, low, shape):
    values = numpy.zeros((*shape, 3) if grid.valueTypeName.startswith("vec3") else shape, numpy.float32)
    grid.copyToArray(values, ijk=low)
    return values


class Levels(ToolTest):
    def grid(self, values, low, name="density", kind=vdb.FloatGrid, staggered=False):
        grid = kind()
        grid.name, grid.transform = name, vdb.createLinearTransform(
            [[0.5, 0, 0, 0], [0, 0.25, 0, 0], [0, 0, -1, 0], [7, 8, 9, 1]]
        )
        grid.copyFromArray(numpy.asarray(values, numpy.float32), ijk=low)
        grid.gridClass = "staggered" if staggered else "fog volume"
        return grid

    def test_means_in_the_same_place(self):
        values = numpy.random.default_rng(1).random((7, 6, 5)) + 0.1
        low = (-3, 4, 1)  # cells begin at even indices
        vdb.write(str(self.folder / "a.0007.vdb"), grids=[self.grid(values, low)], metadata={"dt": 0.5})
        paths = self.outputs("vdblic_export", "a.%04d.vdb", "-o", "c.%04d.vdb", "--levels", 2)
        self.assertEqual([path.name for path in paths], ["c.level1.0007.vdb", "c.level2.0007.vdb"])
        for level, path in enumerate(paths, 1):
            size = 2**level
            grid, metadata = vdb.read(str(path), "density"), vdb.readMetadata(str(path))
            self.assertEqual((metadata["level"], metadata["dt"]), (level, 0.5))
            access = grid.getConstAccessor()
            fine = self.grid(values, low)
            cells = {tuple((i + l) // size for i, l in zip(index, low)) for index in numpy.ndindex(values.shape)}
            self.assertEqual(grid.activeVoxelCount(), len(cells))
            for cell in cells:
                self.assertTrue(access.isValueOn(cell))
                centre = tuple(size * c + (size - 1) / 2 for c in cell)
                numpy.testing.assert_allclose(
                    grid.transform.indexToWorld(tuple(map(float, cell))),
                    fine.transform.indexToWorld(centre),
                    atol=1e-12,
                )
                if level == 1:
                    inside = [
                        index
                        for index in numpy.ndindex(values.shape)
                        if tuple((i + l) // 2 for i, l in zip(index, low)) == cell
                    ]
                    mean = numpy.mean([values[index] for index in inside])
                    self.assertAlmostEqual(access.getValue(cell), mean, delta=1e-3)

    def test_a_linear_flow_stays_itself(self):
        index = numpy.stack(numpy.meshgrid(*map(numpy.arange, (8, 8, 8)), indexing="ij"), axis=-1)
        centred = index * (1, 2, 3) + 5
        faces = (index - 0.5) * (1, 2, 3) + 5
        grids = [
            self.grid(centred, (0, 0, 0), "velocity", vdb.Vec3SGrid),
            self.grid(faces, (0, 0, 0), "faces", vdb.Vec3SGrid, staggered=True),
        ]
        vdb.write(str(self.folder / "v.vdb"), grids=grids)
        (path,) = self.outputs("vdblic_export", "v.vdb", "-o", "c.vdb", "--levels", 1)
        self.assertEqual(path.name, "c.level1.vdb")
        coarse = numpy.stack(numpy.meshgrid(*map(numpy.arange, (4, 4, 4)), indexing="ij"), axis=-1)
        for name, shift in ("velocity", 0.5), ("faces", -0.5):  # in the finer index space: centre, lower face
            values = dense(vdb.read(str(path), name), (0, 0, 0), (4, 4, 4))
            numpy.testing.assert_allclose(values, (2 * coarse + shift) * (1, 2, 3) + 5, rtol=2e-3)

    def test_streaks_keep_their_optical_depth(self):
        self.outputs("vdblic_synth", "ring", "-o", "v.vdb", "--size", 24, 16, 16, "--frames", 1)
        (fine,) = self.outputs(
            "vdblic_advect", "v.vdb", "-o", "s.vdb", "--method", "streaks", "--spacing", 3, "--refine", 4
        )
        (path,) = self.outputs("vdblic_export", "s.vdb", "-o", "c.vdb", "--levels", 1, "--grids", "density")
        sums = [
            sum(item.value * item.count for item in vdb.read(str(file), "density").citerOnValues())
            for file in (fine, path)
        ]
        self.assertAlmostEqual(8 * sums[1] / sums[0], 1, delta=1e-3)
        self.assertEqual(vdb.readMetadata(str(path))["inactive"], "empty")
        self.assertEqual([grid.name for grid in vdb.readAllGridMetadata(str(path))], ["density"])

    def test_memory_follows_the_voxels_not_their_box(self):
        """The box of these would take 500 GB. A tile counts as its voxels."""
        grid = self.grid(numpy.ones((4, 4, 4)), (4000, 4000, 4000))
        grid.fill((-128, -128, -128), (-1, -1, -1), 2.0)
        vdb.write(str(self.folder / "wide.vdb"), grid)
        (path,) = self.outputs("vdblic_export", "wide.vdb", "-o", "c.vdb", "--levels", 1)
        coarse = vdb.read(str(path), "density")
        self.assertEqual(coarse.activeVoxelCount(), 2**3 + 64**3)
        access = coarse.getConstAccessor()
        self.assertEqual([access.getValue((n, n, n)) for n in (2000, 2001, -1, -64)], [1, 1, 2, 2])
        self.assertEqual([access.isValueOn((n, n, n)) for n in (1999, 2002, 0, -65)], [False] * 4)

    def test_what_is_there_stays_and_mistakes(self):
        self.outputs("vdblic_noise", "-o", "n.1.vdb", "--size", 8, 8, 8)
        self.outputs("vdblic_export", "n.%d.vdb", "-o", "c.%d.vdb", "--levels", 2)
        mine = self.contents("n.1.vdb")
        (self.folder / "c.level1.1.vdb").write_bytes(mine)
        self.outputs("vdblic_export", "-", "-o", "c.%d.vdb", "--levels", 2, "--skip-existing", stdin="n.1.vdb\n")
        self.assertEqual(self.contents("c.level1.1.vdb"), mine)
        for status, words, *arguments in (
            (2, "a .vdb would be a copy; --levels writes coarser ones", "n.1.vdb", "-o", "c.vdb"),
            (2, "--levels writes .vdb files", "n.1.vdb", "-o", "c.vti", "--levels", 1),
            (2, "is not a whole number from 1 to 8", "n.1.vdb", "-o", "c.vdb", "--levels", 9),
            (3, "no grid 'p' of numbers or vectors; present: noise (float)", "n.1.vdb", "-o", "x.vdb", "--levels", 1, "--grids", "p"),
        ):
            with self.subTest(words):
                self.assertIn(words, self.fails(status, "vdblic_export", *arguments))


if __name__ == "__main__":
    unittest.main()
