"""vdblic_advect --method streaks, as a user runs it."""

import os
import pathlib
import subprocess
import unittest

import numpy
import pyopenvdb as vdb

from support import ToolTest

WAKE = pathlib.Path(os.environ["VDBLIC_SOURCE"]) / "samples/wake/wake.%04d.vdb"
DATA = os.environ.get("VDBLIC_DATA")


class Streaks(ToolTest):
    def flow(self, name, velocity, frames=3):
        """A flow that stays as it is, in voxels a second; frames of a second."""
        grid = vdb.Vec3SGrid()
        grid.name = "velocity"
        grid.copyFromArray(numpy.ascontiguousarray(velocity, numpy.float32))
        for frame in range(1, frames + 1):
            vdb.write(str(self.folder / f"{name}.{frame:04}.vdb"), grid)
        return f"{name}.%04d.vdb", "--dt", 1

    def uniform(self, velocity=(2, 1e-4, 1e-4), size=(40, 16, 16), **options):
        return self.flow("uniform", numpy.broadcast_to(velocity, (*size, 3)), **options)

    def streaks(self, *arguments, output="s.%04d.vdb", **options):
        """The files of a run."""
        return self.outputs("vdblic_advect", *arguments, "--method", "streaks", "-o", output, **options)

    def texture(self, path, name="density"):
        """A grid as an array over the box of 'magnitude' and as many texture voxels as fill it, 0 where it is inactive."""
        magnitude, grid = vdb.read(str(path), "magnitude"), vdb.read(str(path), name)
        low, high = magnitude.evalActiveVoxelBoundingBox()
        factors = numpy.rint(numpy.divide(magnitude.transform.voxelSize(), grid.transform.voxelSize())).astype(int)
        values = numpy.zeros((numpy.subtract(high, low) + 1) * factors, numpy.float32)
        grid.copyToArray(values, ijk=tuple(int(x) for x in numpy.multiply(low, factors)))
        return values

    def test_the_file(self):
        first = self.streaks(WAKE, "--frames", "5-6", "--lead-in", 0, "--spacing", 3, "--tail", 2, "--refine", 4)[0]
        self.assertEqual(self.files(), ["s.0005.vdb", "s.0006.vdb"])
        grids, metadata = vdb.readAll(str(first))
        self.assertEqual([grid.name for grid in grids], ["density", "magnitude"])
        self.assertEqual((metadata["method"], metadata["spacing"], metadata["tail"], metadata["refine"]),
                         ("streaks", (3, 3, 3), 2, (4, 4, 4)))
        self.assertNotIn("life_span", metadata)
        density = grids[0]
        self.assertEqual((density.background, density.saveFloatAsHalf, density.gridClass), (0, True, "fog volume"))
        values = [item.value for item in density.citerOnValues()]
        self.assertGreater(min(values), 0)
        self.assertLessEqual(max(values), 1)
        self.assertEqual(density.activeVoxelCount(), density.leafCount() and len(values))
        self.assertLess(density.activeVoxelCount(), 0.3 * grids[1].activeVoxelCount() * 64)
        for leaf in ("s.0005.vdb", "s.0006.vdb"):
            self.assertIn("density", self.printed(leaf))

    def test_it_says_what_it_chose(self):
        done = self.run_tool("vdblic_advect", WAKE, "--frames", "1", "--method", "streaks", "-o", "s.%04d.vdb")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"streaks: spacing 1.5, tail [\d.]+, refine 11\n")
        given = self.run_tool("vdblic_advect", WAKE, "--frames", "1", "--method", "streaks", "-o", "s.%04d.vdb",
                              "--refine", 1, "--spacing", 8, 8, 12)
        self.assertIn("streaks: spacing 8 8 12, tail", given.stderr)
        self.assertIn("refine 1\n", given.stderr)

    def test_values_rise_downstream(self):
        """In three of four voxels and more; of a dense texture in half of them."""
        path = self.streaks(*self.uniform(), "--spacing", 3, "--tail", 3, "--refine", 4)[-1]
        values = self.texture(path)
        inside = values[1:-1] > 0.15
        rises = (values[2:] > values[:-2])[inside]
        self.assertGreater(inside.sum(), 1000)
        self.assertGreater(rises.mean(), 0.8)

    def test_substeps_draw_the_same_streaks_more_often(self):
        options = WAKE, "--frames", "1-3", "--bbox", 20, 0, 0, 60, 40, 25, "--refine", 4
        whole = self.streaks(*options)
        parts = self.streaks(*options, "--substeps", 4, output="p.%04d.vdb")
        self.assertEqual(len(parts), 9)
        for one, other in zip(whole, parts[::4]):
            self.outputs_equal(one, other)
        still, moved = self.texture(parts[0]), self.texture(parts[1])
        self.assertFalse((still == moved).all())

    def outputs_equal(self, one, other):
        numpy.testing.assert_array_equal(self.texture(one), self.texture(other))

    def test_a_quarter_of_a_frame_explains_every_change(self):
        """In uniform flow each picture is the one before, moved: nothing pops up, at the inflow neither."""
        paths = self.streaks(*self.uniform(frames=6), "--spacing", 3, "--tail", 3, "--refine", 4, "--substeps", 4)
        pictures = [self.texture(path) for path in paths]
        moved = 2  # texture voxels: two voxels a frame, four texture voxels in each, in four steps
        for before, after in zip(pictures[8:], pictures[9:]):
            # What fades in changes by 1 of 6 of its brightness.
            self.assertLess(numpy.abs(after[moved:] - before[:-moved]).max(), 1 / 6 + 0.03)

    def test_a_wand_of_smoke(self):
        """Streaks that a box emits in uniform flow lie in the box and downstream of it alone."""
        path = self.streaks(*self.uniform(frames=8), "--emit-box", 3, 5, 5, 6, 9, 9, "--spacing", 2, "--tail", 3,
                            "--refine", 4)[-1]
        values = self.texture(path)
        x, y, z = numpy.nonzero(values)
        radius = 3
        self.assertGreater(x.min() / 4 - 0.5, 3 - 0.5 - 1)  # as far as its round head reaches
        self.assertGreater(x.max(), 60)
        for across in y, z:
            self.assertGreaterEqual(across.min(), 5 * 4 - radius)
            self.assertLessEqual(across.max(), 10 * 4 + radius)

    def test_the_air_of_a_source(self):
        """In uniform flow the air that was in a source lies downstream of it."""
        grid = vdb.BoolGrid()
        grid.fill((0, 8, 0), (5, 15, 15), True)
        grid.name = "inlet"
        vdb.write(str(self.folder / "inlet.vdb"), grid)
        path = self.streaks(*self.uniform(frames=12), "--source", "upper=inlet.vdb:inlet", "--source", "none=inlet.vdb",
                            "--spacing", 2, "--tail", 2, "--refine", 4, "--source", "x=inlet.vdb")[-1]
        values, source = self.texture(path), self.texture(path, "source")
        self.assertEqual(set(numpy.unique(source)), {0, 3})  # of equal regions the last one counts
        numpy.testing.assert_array_equal(source > 0, (source > 0) & (values > 0))
        upper = source[40:, 35:][values[40:, 35:] > 0]
        lower = source[40:, :29][values[40:, :29] > 0]
        self.assertGreater(upper.size, 500)
        self.assertGreater((upper == 3).mean(), 0.5)  # the others were released downstream of the source
        self.assertTrue((lower == 0).all())

    def test_flows_that_are_not_usual(self):
        layer = numpy.broadcast_to((1, 0.5, 0), (60, 40, 1, 3))
        fast = numpy.broadcast_to((40, 1e-3, 0), (60, 20, 20, 3))
        for name, velocity in ("layer", layer), ("fast", fast):
            for path in self.streaks(*self.flow(name, velocity), "--refine", 4):
                self.assertGreater((self.texture(path) > 0).mean(), 0.02)
        still = vdb.Vec3SGrid()
        still.name = "velocity"
        still.fill((0, 0, 0), (15, 15, 15), (0, 0, 0), True)
        vdb.write(str(self.folder / "still.vdb"), still)
        self.streaks("still.vdb", output="still.%04d.vdb")
        nothing = vdb.Vec3SGrid()
        nothing.name = "velocity"
        vdb.write(str(self.folder / "layer.0002.vdb"), nothing)
        paths = self.streaks("layer.%04d.vdb", "--dt", 1)
        self.assertEqual(vdb.read(str(paths[1]), "density").activeVoxelCount(), 0)
        self.assertGreater(vdb.read(str(paths[2]), "density").activeVoxelCount(), 0)

    def test_solids_stop_streaks(self):
        """No voxel of a solid holds a part of a streak."""
        velocity = numpy.broadcast_to((2.0, 0, 0), (40, 16, 16, 3)).copy()
        velocity[18:24, 5:11, 5:11] = 0  # becomes inactive
        path = self.streaks(*self.flow("solid", velocity), "--refine", 4, "--spacing", 2)[-1]
        values = self.texture(path)
        self.assertEqual(values[18 * 4:24 * 4, 5 * 4:11 * 4, 5 * 4:11 * 4].max(), 0)
        self.assertGreater(values[14 * 4:18 * 4, 5 * 4:11 * 4, 5 * 4:11 * 4].max(), 0.3)

    def test_pictures_have_the_look_of_streaks(self):
        """By default the look is the file's; another one can be given."""
        self.streaks(*self.uniform(), "--frames", 1, "--refine", 4, "--spacing", 3)
        dense = self.outputs("vdblic_advect", *self.uniform(), "--frames", 1, "-o", "lic.%04d.vdb")[0]
        for file, look, *options in (("s.0001.vdb", "streaks"), ("s.%04d.vdb", "streaks"), (dense, "flow"),
                                     ("s.0001.vdb", "flow", "--look", "flow"), (dense, "streaks", "--look", "streaks")):
            image = self.outputs("vdblic_render", file, "-o", "image.exr", "--size", 160, 100, *options)[0]
            header = subprocess.run(["oiiotool", "--info", "-v", str(image)], text=True, capture_output=True, check=True).stdout
            self.assertRegex(header, rf'look: "{look}"')

    def test_what_cannot_be(self):
        flow = self.uniform()
        for words, *arguments in (
                ("--spacing 100 is larger than the velocity's 40 x 16 x 16 voxels", "--spacing", 100),
                ("--emit-box: no voxel of the velocity is in it", "--emit-box", 90, 0, 0, 99, 9, 9),
                ("--interpolation cubic: streaks interpolate linearly", "--interpolation", "cubic"),
                ("--noise: streaks begin without noise", "--noise", "x.vdb"),
                ("--spacing takes one number, or one for each of the three axes", "--spacing", "1,2"),
                ("--source a: give NAME=FILE", "--source", "a"),
                ("--source: the name a stands twice", "--source", "a=x.vdb", "--source", "a=y.vdb")):
            before = self.files()
            status = 3 if "--emit-box" in words else 2
            message = self.fails(status, "vdblic_advect", *flow, "--method", "streaks", "-o", "s.%04d.vdb", *arguments)
            self.assertIn(words, message)
            self.assertEqual(self.files(), before)
        for option in ("--spacing", 2), ("--tail", 2), ("--emit", "x.vdb"), ("--source", "a=x.vdb"):
            message = self.fails(2, "vdblic_advect", *flow, "-o", "s.%04d.vdb", *option)
            self.assertIn("are of --method streaks", message)

    def test_a_chunk_of_a_farm_looks_the_same(self):
        """After a lead-in the streaks are others, their number and their share of the space are the same."""
        options = "--spacing", 2, "--tail", 2.5, "--refine", 4
        whole = self.streaks(WAKE, "--frames", "1-12", *options)[-1]
        chunk = self.streaks(WAKE, "--frames", "11-12", *options, output="c.%04d.vdb")[-1]
        counts = [vdb.read(str(path), "density").activeVoxelCount() for path in (whole, chunk)]
        self.assertAlmostEqual(counts[1] / counts[0], 1, delta=0.03)

    @unittest.skipUnless(DATA, "VDBLIC_DATA does not name the folder of the large data sets")
    def test_real_sequences(self):
        for pattern, *options in (("era5_west_europe/era5.%04d.vdb", "--frames", "1-3"),
                                  ("katrina_wrf/katrina.%04d.vdb",),
                                  ("mantaflow_drift/fluid_data_%04d.vdb", "--frames", "20-22")):
            with self.subTest(pattern):
                for path in self.streaks(pathlib.Path(DATA) / pattern, *options):
                    self.assertGreater(vdb.read(str(path), "density").activeVoxelCount(), 1000)


if __name__ == "__main__":
    unittest.main()
