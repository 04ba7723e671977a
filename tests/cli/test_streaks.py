"""vdblic_advect --method streaks, as a user runs it."""

import json
import os
import pathlib
import subprocess
import unittest

import numpy
import pyopenvdb as vdb

from support import WAKE, RenderTest

DATA = os.environ.get("VDBLIC_DATA")


def values_at(values, positions):
    """Trilinear interpolation of an array at positions in its index space."""
    last = numpy.array(values.shape[:3]) - 2
    base = numpy.clip(numpy.floor(positions).astype(int), 0, last)
    share = numpy.clip(positions - base, 0, 1)
    sums = 0
    for corner in numpy.ndindex(2, 2, 2):
        weight = numpy.prod(numpy.where(numpy.array(corner) == 1, share, 1 - share), axis=1)
        sums = sums + weight[:, None] * values[tuple((base + corner).T)]
    return sums


class Streaks(RenderTest):
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
        metadata = vdb.readAll(str(path))[1]
        self.assertEqual([metadata.get(f"source_{i}") for i in range(1, 5)], ["upper", "none", "x", None])

    def test_a_picture_names_its_sources(self):
        """Sources have colours of their own, a legend in place of the colour bar, and do not change the solid."""
        grid = vdb.BoolGrid()
        grid.fill((0, 8, 0), (5, 15, 15), True)
        vdb.write(str(self.folder / "inlet.vdb"), grid)
        flow = self.uniform(frames=12)
        options = "--spacing", 3, "--tail", 2, "--refine", 4, "--frames", "12"

        def picture(name, *sources, by="source"):
            self.streaks(*flow, *options, *(f"--source={source}=inlet.vdb" for source in sources))
            self.outputs("vdblic_render", "s.0012.vdb", "-o", name, "--size", 200, 120, "--color-by", by, "--annotate",
                         "colorbar")
            return (self.pixels(name, *(f"annotation.{c}" for c in "RGB")), self.pixels(name, *"RGB"))

        legend, colors = picture("a.exr", "a")
        other, _ = picture("b.exr", "other")
        bar, _ = picture("c.exr", "a", by="magnitude")
        self.assertGreater((legend[0] > 3 * legend[2] + 0.1).sum(), 5)  # orange
        self.assertGreater((colors[0] > 3 * colors[2] + 0.1).sum(), 50)
        for differs in other, bar:
            self.assertGreater(numpy.abs(numpy.subtract(legend, differs)).max(), 0.1)
        # Of a domain without a hole there is no solid.
        self.outputs("vdblic_render", "s.0012.vdb", "-o", "d.exr", "--size", 200, 120, "--color-by", "source")
        self.outputs("vdblic_render", "s.0012.vdb", "-o", "e.exr", "--size", 200, 120, "--color-by", "source", "--solid",
                     "domain")
        numpy.testing.assert_array_equal(self.pixels("d.exr", "A"), self.pixels("e.exr", "A"))

    def test_coherence_of_streaks(self):
        flow, *interval = self.uniform(frames=6)
        self.streaks(flow, *interval, "--spacing", 3, "--tail", 3, "--refine", 4)
        command = "vdblic_coherence", flow, "s.%04d.vdb", *interval
        self.outputs(*command, "--json", "c.json")
        report = json.loads(self.contents("c.json"))
        mean = {name: figure["mean"] for name, figure in report["mean"].items()}
        self.assertGreater(mean["rising"], 0.8)
        self.assertGreater(mean["temporal"], 0.95)
        self.assertLess(mean["same_place"], 0.85)
        self.assertLess(mean["vanishing"] + mean["appearing"], 0.02)
        self.assertGreater(mean["median_apart"], 0.45)
        self.assertEqual([frame["frame"] for frame in report["frames"]], list(range(1, 7)))
        self.outputs(*command, "--threads", 1, "--json", "one.json")
        self.assertEqual(self.contents("one.json"), self.contents("c.json"))
        self.outputs("vdblic_advect", flow, *interval, "-o", "d.%04d.vdb", "--frames", "2-3")
        (self.folder / "d.0003.vdb").rename(self.folder / "s.0003.vdb")
        self.assertIn("s.0003.vdb: its texture is dense", self.fails(3, *command))

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

    def test_what_enters_slowly_fades_in(self):
        """A streak that needs more than a frame to come over a rim does not stand there all at once in the frame's first picture."""
        paths = self.streaks(*self.uniform((0.2, 1e-4, 1e-4), size=(12, 64, 64), frames=10), "--spacing", 4, "--tail", 3,
                             "--refine", 4, "--substeps", 4, "--lead-in", 0)
        rims = numpy.array([self.texture(path)[0] for path in paths])
        self.assertGreater(rims[-1].max(), 0.5)
        around = numpy.pad(rims[:-1], ((0, 0), (1, 1), (1, 1)))
        before = numpy.max([around[:, y : y + 256, z : z + 256] for y, z in numpy.ndindex(3, 3)], axis=0)
        self.assertLess((rims[1:] - before).max(), 0.3)  # a sixth by fading, a tenth by motion

    @unittest.skipUnless(DATA, "VDBLIC_DATA does not name the folder of the large data sets")
    def test_nothing_pops_in_real_flows(self):
        """Motion and fading explain what changes in a quarter of a frame.

        Where the flow carries a visible voxel to in a quarter of a frame, and where it comes from, a voxel's value is in the
        range of the 27 voxels there, but for what fades: a streak in 1.5 frames, a stopped tail in its length. Voxels are so
        fine that a head between them is hardly dimmer than on one.
        """
        for velocity, seconds, factor, tail, *options in (
                (pathlib.Path(DATA) / "wake/wake.%04d.vdb", 0.05, (4, 4, 4), 2, "--spacing", 3, "--refine", 4),
                (pathlib.Path(DATA) / "era5_west_europe/era5.%04d.vdb", 3600, (9, 9, 3), 2, "--spacing", 2.4, 2.4, 7,
                 "--refine", 9, 9, 3),
                (pathlib.Path(DATA) / "era5_west_europe/era5.%04d.vdb", 3600, (6, 6, 2), 2, "--spacing", 4.8, 4.8, 14,
                 "--refine", 6, 6, 2)):
            name = f"{velocity.parent.name}.{factor[0]}"
            paths = self.streaks(velocity, *options, "--tail", tail, "--frames", "5-7", "--substeps", 4,
                                 output=f"{name}.%04d.vdb")
            pictures = [self.texture(path) for path in paths]
            flows = [self.displacements(str(velocity) % frame, seconds / 4) * factor for frame in (5, 6, 7)]
            bound = 0.25 / 1.5 + 0.25 / tail
            for i, (before, after) in enumerate(zip(pictures, pictures[1:])):
                share = (i % 4 + 0.5) / 4
                first, second = flows[i // 4 : i // 4 + 2]
                flow = (1 - share) * first + share * second
                flow[(first == 0).all(axis=3) | (second == 0).all(axis=3)] = 0  # of voxels that come or go
                for here, there, sign in (before, after, 1), (after, before, -1):
                    excess = self.unexplained(here, there, sign * flow, factor)
                    self.assertGreater(excess.size, 1000)
                    self.assertLess(excess.max(), bound, f"{name}, picture {i}, sign {sign}")
                    self.assertLess(numpy.quantile(excess, 0.99), bound / 2)
            # What lies a frame apart is not explained by the motion of a quarter.
            self.assertGreater(self.unexplained(pictures[0], pictures[4], flows[0], factor).max(), 2 * bound)

    def displacements(self, path, seconds):
        """How far the voxels of a velocity move [voxels], as an array over its box."""
        header, = (grid for grid in vdb.readAllGridMetadata(path) if grid.valueTypeName.startswith("vec3"))
        grid = vdb.read(path, header.name)
        low, high = grid.evalActiveVoxelBoundingBox()
        values = numpy.zeros((*(b - a + 1 for a, b in zip(low, high)), 3), numpy.float32)
        grid.copyToArray(values, ijk=low)
        return values * seconds / numpy.array(grid.transform.voxelSize())

    def unexplained(self, here, there, flow, factor):
        """How far values above 0.2 are beyond those around the place that the flow carries them to, where there is flow."""
        voxels = numpy.argwhere(here > 0.2)
        voxels = voxels[numpy.random.default_rng(1).permutation(len(voxels))[:20000]]
        at = (voxels + 0.5) / factor - 0.5
        middle = at + values_at(flow, at) / factor / 2  # midpoint rule
        end = voxels + values_at(flow, middle)
        last = numpy.array(here.shape) - 1
        rim = numpy.maximum(numpy.divide(factor, 6), 1)  # where streaks leave
        inside = ((end > rim) & (end < last - rim)).all(axis=1) & (numpy.abs(values_at(flow, at)).sum(axis=1) > 0)
        voxels, end = voxels[inside], end[inside]
        flows = flow[tuple(numpy.rint((end + 0.5) / factor - 0.5).astype(int).T)].any(axis=1)
        voxels, end = voxels[flows], numpy.rint(end[flows]).astype(int)
        around = numpy.array([there[tuple((end + numpy.subtract(step, 1)).T)] for step in numpy.ndindex(3, 3, 3)])
        values = here[tuple(voxels.T)]
        return numpy.maximum(values - around.max(axis=0), around.min(axis=0) - values)

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
