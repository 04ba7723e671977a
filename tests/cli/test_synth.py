"""vdblic_synth: its grids, read by pyopenvdb, against the formulas, and its failures."""

import pathlib
import resource
import unittest

import numpy
import pyopenvdb as vdb

from support import ToolTest

SPEED = 72  # voxels a second


def values(grid, size):
    array = numpy.zeros((*size, 3), numpy.float32)
    grid.copyToArray(array)
    return array


def rotation(size, voxel_size):
    """Rigid rotation about the box's centre line, with a root-mean-square speed of SPEED over the box."""
    middle = sorted(size)[1]
    x, y, _ = numpy.meshgrid(*(numpy.arange(s) - (s - 1) / 2 for s in size), indexing="ij")
    rate = SPEED / middle * numpy.sqrt(12 / ((size[0] / middle) ** 2 + (size[1] / middle) ** 2))
    return numpy.stack([-rate * y, rate * x, 0 * x], axis=-1) * voxel_size


def about_z(vectors, angle):
    """Vectors (n, 3) turned about the z axis."""
    x, y, z = vectors.T
    return numpy.stack([numpy.cos(angle) * x - numpy.sin(angle) * y, numpy.sin(angle) * x + numpy.cos(angle) * y, z], axis=1)


class Globe:
    """The grids of a file of the globe; `voxels` (n, 3) are its active ones, by the rim's values."""

    def __init__(self, path, half=40):
        self.half = half
        self.velocity, self.rim, self.solid = (vdb.read(str(path), name) for name in ("velocity", "rim", "solid"))
        self.field = numpy.zeros((2 * half + 1,) * 3 + (3,), numpy.float32)
        self.velocity.copyToArray(self.field, ijk=(-half,) * 3)
        depth = numpy.full(self.field.shape[:3], -numpy.inf, numpy.float32)
        for value in self.rim.citerOnValues():
            depth[tuple(numpy.add(value.min, half))] = value.value
        self.voxels = numpy.argwhere(depth > -numpy.inf) - half
        self.depth = depth[tuple((self.voxels + half).T)]
        self.values = self.field[tuple((self.voxels + half).T)].astype(float)

    def at(self, places):
        """The velocity, linear between voxels, at places (n, 3) in voxels."""
        low = numpy.floor(places).astype(int)
        sums = numpy.zeros(places.shape)
        for corner in numpy.ndindex(2, 2, 2):
            weights = numpy.prod(numpy.where(corner, places - low, 1 - (places - low)), axis=1)
            sums += weights[:, None] * self.field[tuple((low + corner + self.half).T)]
        return sums


class Rossby(ToolTest):
    """The wave on the Earth with voxels of 2 degrees."""

    VOXEL = 6.371 * numpy.radians(2)

    def globes(self, frames, *options):
        paths = self.outputs("vdblic_synth", "rossby", "-o", "v.%d.vdb", "--frames", frames, "--voxel-size", self.VOXEL,
                             *options)
        return [Globe(path) for path in paths]

    def test_grids(self):
        (globe,) = self.globes("1")
        path = str(self.folder / "v.1.vdb")
        self.assertEqual([grid.name for grid in vdb.readAllGridMetadata(path)], ["rim", "solid", "speed", "velocity"])
        self.assertEqual(globe.velocity.metadata["length_unit"], "Mm")
        self.assertAlmostEqual(globe.velocity.metadata["dt"], 72000 * self.VOXEL)
        self.assertEqual(globe.velocity.transform.indexToWorld((0, 0, 0)), (0, 0, 0))
        self.assertEqual(globe.velocity.activeVoxelCount(), len(globe.voxels))
        radius = numpy.linalg.norm(globe.voxels, axis=1) * self.VOXEL
        top = 6.371 + 5 * self.VOXEL
        numpy.testing.assert_allclose(globe.depth, numpy.minimum(radius - 6.371, top - radius), atol=1e-6)
        self.assertTrue((globe.depth > -2.001 * self.VOXEL).all())
        self.assertEqual(globe.solid.gridClass, vdb.GridClass.LEVEL_SET)
        self.assertLess(globe.solid.getConstAccessor().getValue((0, 0, 0)), 0)

    def test_wind(self):
        """Horizontal; at rest at the poles, and on the equator up to twice a solid body's 50 m/s."""
        (globe,) = self.globes("1")
        told = vdb.read(str(self.folder / "v.1.vdb"), "speed")
        self.assertEqual(told.metadata["unit"], "m/s")
        x, y, z = globe.voxels.T
        radius = numpy.linalg.norm(globe.voxels, axis=1)
        outward = (globe.values * globe.voxels).sum(axis=1) / radius
        self.assertLess(abs(outward).max(), 1e-6 * abs(globe.values).max())
        self.assertEqual(abs(globe.values[(x == 0) & (y == 0)]).max(), 0)
        for chosen, longitude in ((y == 0) & (x > 0), 0), ((x == y) & (x > 0), 45), ((x == 0) & (y < 0), -90):
            equator = chosen & (z == 0)
            self.assertGreater(equator.sum(), 5)
            expected = 7.848e-6 * radius[equator] * self.VOXEL * (1 - numpy.cos(4 * numpy.radians(longitude)))
            x_axis = numpy.radians(longitude)
            eastward = globe.values[equator] @ (-numpy.sin(x_axis), numpy.cos(x_axis), 0)
            numpy.testing.assert_allclose(eastward, expected, rtol=1e-5, atol=1e-11)
            most = 7.848e-6 * 6.371e6 * (1 - numpy.cos(4 * x_axis))  # the same at all radii
            speed = [told.getConstAccessor().getValue(tuple(map(int, voxel))) for voxel in globe.voxels[equator]]
            numpy.testing.assert_allclose(speed, most, rtol=1e-5, atol=1e-5)

    def test_the_pattern_turns_at_its_speed(self):
        """The angle about z by which the first frame matches a later one best."""
        first, later = self.globes("1,3", "--dt", 86400)
        inside = later.depth > 0
        places, values = later.voxels[inside], later.values[inside]
        expected = (28 * 7.848e-6 - 2 * 7.292e-5) / 30 * 2 * 86400
        angles = expected + numpy.radians([-0.5, 0, 0.5])
        misses = [((about_z(first.at(about_z(places, -angle)), angle) - values) ** 2).sum() for angle in angles]
        a, b, _ = numpy.polyfit(angles - expected, misses, 2)
        self.assertLess(abs(b / (2 * a)), 1e-3 * expected)
        self.assertLess(misses[1], 1e-4 * (values**2).sum())

    def test_threads_do_not_change_the_files(self):
        made = []
        for threads in 1, 2, 5:
            self.globes("2-3", "--threads", threads)
            made.append([self.contents(f"v.{frame}.vdb") for frame in (2, 3)])
        self.assertEqual(made[0], made[1])
        self.assertEqual(made[0], made[2])

    def test_mean_speed_is_about_three_voxels_a_frame(self):
        (globe,) = self.globes("1")
        mean = numpy.linalg.norm(globe.values, axis=1).mean() * 72000
        self.assertTrue(2 <= mean <= 4, mean)

    def test_usage_errors(self):
        good = "vdblic_synth", "rossby", "-o", "x.vdb", "--frames", 1
        self.assertIn("--size", self.fails(2, *good, "--size", 8, 8, 8))
        for wrong in ("--voxel-size", 1), ("--voxel-size", 0.001), ("--dt", 2e9):
            self.assertIn(str(wrong[1])[:1], self.fails(2, *good, *wrong))
        self.assertIn("--size", self.fails(2, "vdblic_synth", "abc", "-o", "x.vdb", "--frames", 1))
        self.assertEqual(self.files(), [])


class Synth(ToolTest):
    def test_uniform(self):
        paths = self.outputs("vdblic_synth", "uniform", "-o", "u.%03d.vdb", "--size", 9, 20, 5, "--frames", "1-3")
        self.assertEqual([path.name for path in paths], ["u.001.vdb", "u.002.vdb", "u.003.vdb"])
        self.assertEqual(self.files(), ["u.001.vdb", "u.002.vdb", "u.003.vdb"])
        for path in paths:
            grid = vdb.read(str(path), "velocity")
            self.assertEqual(grid.activeVoxelCount(), 9 * 20 * 5)
            self.assertEqual(grid.evalActiveVoxelBoundingBox(), ((0, 0, 0), (8, 19, 4)))
            expected = numpy.array([6, 3, 2]) / 7 * SPEED * 0.1
            numpy.testing.assert_allclose(
                values(grid, (9, 20, 5)), numpy.broadcast_to(expected, (9, 20, 5, 3)), rtol=1e-6)

    def test_rotation(self):
        size = (12, 30, 17)
        (path,) = self.outputs("vdblic_synth", "rotation", "-o", "r.vdb", "--size", *size, "--frames", 7,
                               "--voxel-size", 0.25)
        grid = vdb.read(str(path), "velocity")
        self.assertEqual(tuple(grid.transform.voxelSize()), (0.25, 0.25, 0.25))
        self.assertEqual(tuple(grid.transform.indexToWorld((4, 0, 2))), (1, 0, 0.5))
        numpy.testing.assert_allclose(values(grid, size), rotation(size, 0.25), rtol=1e-6, atol=1e-6)

    def test_metadata(self):
        self.outputs("vdblic_synth", "abc", "-o", "v_####.vdb", "--size", 8, 8, 8, "--frames", "-3,1,5-9x4",
                     "--dt", 0.5)
        self.assertEqual(self.files(), ["v_-003.vdb", "v_0001.vdb", "v_0005.vdb", "v_0009.vdb"])
        for frame, name in ((-3, "v_-003"), (1, "v_0001"), (5, "v_0005"), (9, "v_0009")):
            path = str(self.folder / (name + ".vdb"))
            (grid,) = vdb.readAllGridMetadata(path)
            self.assertEqual(grid.name, "velocity")
            self.assertEqual(grid.vectorType, "contravariant relative")
            self.assertEqual(grid.metadata["frame"], frame)
            self.assertEqual(grid.metadata["time"], (frame - 1) * 0.5)
            self.assertEqual(grid.metadata["dt"], 0.5)
            self.assertTrue(vdb.readMetadata(path)["creator"].startswith("VDBLIC "))

    def test_flows_move_by_two_to_four_voxels_a_frame_at_any_size(self):
        for flow in self.flows():
            for size in ((16, 16, 16), (48, 24, 27), (50, 50, 70)):
                (path,) = self.outputs("vdblic_synth", flow, "-o", "v.vdb", "--size", *size, "--frames", 4)
                mean = numpy.linalg.norm(values(vdb.read(str(path), "velocity"), size), axis=-1).mean() / 0.1 / 24
                self.assertTrue(2 <= mean <= 4, f"{flow} {size}: {mean}")

    def test_unsteady_flows_change_and_frames_do_not_depend_on_each_other(self):
        for flow in self.flows():
            arguments = [flow, "--size", 16, 16, 16]
            self.outputs("vdblic_synth", *arguments, "-o", "all.%d.vdb", "--frames", "3-5")
            self.outputs("vdblic_synth", *arguments, "-o", "one.%d.vdb", "--frames", "5")
            self.assertEqual(self.contents("all.5.vdb"), self.contents("one.5.vdb"))
            first, last = (values(vdb.read(str(self.folder / f"all.{frame}.vdb"), "velocity"), (16, 16, 16))
                           for frame in (3, 5))
            self.assertEqual((first == last).all(), flow in ("uniform", "rotation"), flow)

    def test_threads_do_not_change_the_file(self):
        for threads in (1, 7):
            self.outputs("vdblic_synth", "tornado", "-o", f"{threads}.vdb", "--size", 40, 41, 42, "--frames", 2,
                         "--threads", threads)
        self.assertEqual(self.contents("1.vdb"), self.contents("7.vdb"))

    def flows(self):
        """The names of the flows in a box."""
        done = self.run_tool("vdblic_synth", "--list")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        lines = [line.split(maxsplit=1) for line in done.stdout.splitlines()]
        self.assertTrue(all(len(line) == 2 for line in lines), done.stdout)
        names = [line[0] for line in lines]
        names.remove("rossby")
        return names

    def test_list_help_and_version(self):
        self.assertLessEqual({"abc", "tornado", "gyre", "ring", "uniform", "rotation"}, set(self.flows()))
        for option in ("--help", "--version"):
            done = self.run_tool("vdblic_synth", option)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertTrue(done.stdout)

    def test_usage_errors(self):
        good = {"flow": ["abc"], "-o": ["v.%d.vdb"], "--size": [4, 4, 4], "--frames": ["1-2"]}
        for bad in (
                {"flow": []}, {"flow": ["spiral"]}, {"flow": ["abc", "ring"]}, {"-o": None}, {"-o": ["v.vdb"]},
                {"-o": ["%d.%d.vdb"]}, {"-o": ["%d/v.vdb"]}, {"--size": None}, {"--size": [4, 4]},
                {"--size": [0, 4, 4]}, {"--size": [4, -4, 4]}, {"--size": ["nan", 4, 4]},
                {"--size": [100000, 100000, 100000]}, {"--frames": None}, {"--frames": [""]}, {"--frames": ["2-1"]},
                {"--frames": ["one"]}, {"--dt": [0]}, {"--dt": [-1]}, {"--dt": ["nan"]}, {"--dt": ["inf"]},
                {"--dt": [1000], "--frames": ["1,100000"]}, {"--voxel-size": [0]}, {"--voxel-size": [-1]},
                {"--voxel-size": ["nan"]}, {"--voxel-size": ["inf"]}, {"--threads": ["nan"]}):
            arguments = []
            for name, given in (good | bad).items():
                if given is not None:
                    arguments += given if name == "flow" else [name, *given]
            self.fails(2, "vdblic_synth", *arguments)
            self.assertEqual(self.files(), [])
        self.assertIn("tornado", self.fails(2, "vdblic_synth", "x", "-o", "v", "--size", 4, 4, 4, "--frames", 1))

    def test_output_that_cannot_be_written(self):
        (self.folder / "taken.1.vdb").mkdir()
        for output, status in ((pathlib.Path("missing") / "v.%d.vdb", 4), ("taken.%d.vdb", 2), ("/proc/v.%d.vdb", 4)):
            message = self.fails(status, "vdblic_synth", "abc", "-o", output, "--size", 4, 4, 4, "--frames", "1-2")
            self.assertIn(str(output).replace("%d", "1"), message)
        self.assertEqual(self.files(), ["taken.1.vdb"])

    def test_full_disk_leaves_no_partial_file(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

        message = self.fails(4, "vdblic_synth", "abc", "-o", "v.%d.vdb", "--size", 40, 40, 40, "--frames", "1-2",
                             preexec_fn=limit, restore_signals=False)  # SIGXFSZ stays ignored
        self.assertIn("v.1.vdb", message)
        self.assertEqual(self.files(), [])


if __name__ == "__main__":
    unittest.main()
