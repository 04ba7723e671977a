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
        done = self.run_tool("vdblic_synth", "--list")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        lines = [line.split(maxsplit=1) for line in done.stdout.splitlines()]
        self.assertTrue(all(len(line) == 2 for line in lines), done.stdout)
        return [line[0] for line in lines]

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
