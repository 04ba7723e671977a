"""vdblic_noise: topology, transform, metadata and values by OpenVDB's tools, and its failures."""

import pathlib
import re
import unittest

import numpy
import pyopenvdb as vdb

from support import ToolTest


def mix_bits(bits):
    bits = (bits ^ (bits >> numpy.uint64(30))) * numpy.uint64(0xBF58476D1CE4E5B9)
    bits = (bits ^ (bits >> numpy.uint64(27))) * numpy.uint64(0x94D049BB133111EB)
    return bits ^ (bits >> numpy.uint64(31))


def expected_noise(first, size, seed):
    """The documented function of index and seed, on a box of voxels from index `first` on."""
    x, y, z = numpy.meshgrid(*(numpy.arange(f, f + s) for f, s in zip(first, size)), indexing="ij")
    low = [(axis & 0xFFFFFFFF).astype(numpy.uint64) for axis in (x, y, z)]
    column = mix_bits((low[0] << numpy.uint64(32) | low[1]) + numpy.uint64(0x9E3779B97F4A7C15))
    column = column + (numpy.uint64(seed) << numpy.uint64(32))
    return ((mix_bits(column + low[2]) >> numpy.uint64(48)) / 65535).astype(numpy.float32)


class Noise(ToolTest):
    def write(self, name, *grids):
        vdb.write(str(self.folder / name), grids=grids)

    def scalar(self, name, first=None, last=None):
        grid = vdb.FloatGrid()
        grid.name = name
        if first:
            grid.fill(first, last, 1.0, active=True)
        return grid

    def field(self, printed, name):
        found = re.findall(rf"^ *{re.escape(name)}: *(.*?) *$", printed, re.MULTILINE)
        self.assertEqual(len(found), 1, printed)
        return found[0]

    def assert_values(self, path, first, expected):
        values = numpy.zeros(expected.shape, numpy.float32)
        vdb.read(str(self.folder / path), "noise").copyToArray(values, ijk=first)
        numpy.testing.assert_allclose(values, expected, rtol=0, atol=1e-7)

    def voxels(self, path):
        return int(self.field(self.printed(path), "Number of active voxels").replace(",", ""))

    def test_box(self):
        (path,) = self.outputs("vdblic_noise", "-o", "noise.vdb", "--size", 20, 9, 33, "--seed", 4000000000)
        self.assertEqual(self.files(), ["noise.vdb"])
        expected = expected_noise((0, 0, 0), (20, 9, 33), 4000000000)
        printed = self.printed(path)
        for name, value in (
                ("Name", "noise"), ("Type", "Tree_float_5_4_3"), ("Number of active voxels", f"{20 * 9 * 33:,}"),
                ("Number of active tiles", "0"), ("Bounding box of active voxels", "[0, 0, 0] -> [19, 8, 32]"),
                ("seed", "4000000000"), ("voxel size", "0.1")):
            self.assertEqual(self.field(printed, name), value)
        self.assert_values(path, (0, 0, 0), expected)
        self.assertTrue(self.field(printed, "creator").startswith("VDBLIC "))

    def test_like_takes_topology_and_transform_of_the_first_grid_with_voxels(self):
        velocity = vdb.Vec3SGrid()
        velocity.name = "velocity"
        velocity.transform = vdb.createLinearTransform([[0, 2, 0, 0], [-3, 0, 0, 0], [0, 0, 0.5, 0], [7, 8, 9, 1]])
        velocity.fill((-12, -5, 3), (6, 2, 20), (1, 2, 3), active=True)
        velocity.fill((-4, -2, 8), (-1, 1, 9), (0, 0, 0), active=False)
        self.write("v.vdb", self.scalar("flame"), velocity, self.scalar("another", (0, 0, 0), (1, 1, 1)))
        done = self.run_tool("vdblic_noise", "-o", "noise.vdb", "--like", "v.vdb", "--seed", 9)
        self.assertEqual((done.returncode, done.stdout), (0, "noise.vdb\n"))
        self.assertIn("'velocity'", done.stderr)

        printed = self.printed("noise.vdb")
        self.assertEqual(self.voxels("noise.vdb"), velocity.activeVoxelCount())
        self.assertEqual(self.field(printed, "Bounding box of active voxels"), "[-12, -5, 3] -> [6, 2, 20]")
        expected = expected_noise((-12, -5, 3), (19, 8, 18), 9)
        active = numpy.ones(expected.shape, bool)
        active[8:12, 3:7, 5:7] = False
        self.assert_values("noise.vdb", (-12, -5, 3), numpy.where(active, expected, 0))
        transform = printed[printed.index("index to world:"):]
        source = self.printed("v.vdb")
        source = source[source.index("Name: velocity"):]
        source = source[source.index("index to world:"):]
        self.assertEqual(transform.split()[:19], source.split()[:19])

    def test_like_takes_the_grid_that_is_named(self):
        self.write("v.vdb", *(self.scalar(f"v.{axis}", (0, 0, 0), (i, 0, 0)) for i, axis in enumerate("xyz")))
        for like, voxels in (("v.vdb", 1), ("v.vdb:v.y", 2), ("v.vdb:v.z", 3)):
            (path,) = self.outputs("vdblic_noise", "-o", "noise.vdb", "--like", like)
            self.assertEqual(self.voxels(path), voxels)

    def test_refined_noise_is_what_a_refined_texture_starts_from(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 12, 10, 9, "--frames", "1-3")
        for refine in [2], [3, 1, 2]:
            self.outputs("vdblic_noise", "-o", "noise.vdb", "--like", "v.0001.vdb", "--refine", *refine)
            self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "own.%04d.vdb", "--refine", *refine)
            self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "given.%04d.vdb", "--refine", *refine, "--noise",
                         "noise.vdb")
            for frame in 1, 2, 3:
                done = self.run_tool("vdblic_diff", f"own.{frame:04}.vdb", f"given.{frame:04}.vdb", "--ignore-metadata",
                                     "seed,noise")
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            first, *last = ([0, 0, 0], *(n * f for n, f in zip((12, 10, 9), refine * (4 - len(refine)))))
            self.assert_values("noise.vdb", first, expected_noise(first, last, 1))
            texture = self.printed("own.0001.vdb")
            texture = texture[texture.index("Name: density"):]
            noise = self.printed("noise.vdb")
            place = [printed[printed.index("index to world:"):].split()[:19] for printed in (noise, texture)]
            self.assertEqual(place[0], place[1])
        # Other noise gives another texture.
        self.outputs("vdblic_noise", "-o", "noise.vdb", "--like", "v.0001.vdb", "--refine", "3,1,2", "--seed", 2)
        self.outputs("vdblic_advect", "v.0001.vdb", "-o", "other.vdb", "--refine", "3,1,2", "--noise", "noise.vdb")
        self.assertEqual(self.run_tool("vdblic_diff", "own.0001.vdb", "other.vdb", "--ignore-metadata",
                                       "seed,noise").returncode, 1)

    def test_a_colon_may_be_part_of_a_file_name(self):
        self.write("10:30.vdb", self.scalar("a", (0, 0, 0), (1, 1, 1)))
        self.outputs("vdblic_noise", "-o", "noise.vdb", "--like", "10:30.vdb")
        self.outputs("vdblic_noise", "-o", "noise.vdb", "--like", "10:30.vdb:a")

    def test_threads_do_not_change_the_file_and_seeds_do(self):
        for threads, seed in ((1, 1), (7, 1), (7, 2)):
            self.outputs("vdblic_noise", "-o", f"{threads}-{seed}.vdb", "--size", 40, 50, 60, "--threads", threads,
                         "--seed", seed)
        self.assertEqual(self.contents("1-1.vdb"), self.contents("7-1.vdb"))
        self.assertNotEqual(self.contents("1-1.vdb"), self.contents("7-2.vdb"))

    def test_usage_errors(self):
        for arguments in (
                [], ["--size", 4, 4], ["--size", 0, 4, 4], ["--size", -4, 4, 4], ["--size", "nan", 4, 4],
                ["--size", 4, 4, 1.5], ["--size", 4, 4, 200000], ["--size", 90000, 90000, 90000],
                ["--size", 4, 4, 4, "--like", "v.vdb"], ["--size", 4, 4, 4, "--seed", -1],
                ["--size", 4, 4, 4, "--seed", 4294967296], ["--size", 4, 4, 4, "--threads", 0],
                ["--like", "v.vdb:"], ["--like", ""], ["--size", 4, 4, 4, "--refine", 2],
                ["--like", "v.vdb", "--refine", 0], ["--like", "v.vdb", "--refine", 17],
                ["--like", "v.vdb", "--refine", 2, 2], ["--like", "v.vdb", "--refine", 2, 2, 2, 2]):
            self.fails(2, "vdblic_noise", "-o", "noise.vdb", *arguments)
        self.fails(2, "vdblic_noise", "--size", 4, 4, 4)
        self.assertEqual(self.files(), [])

    def test_bad_input(self):
        self.write("empty.vdb", self.scalar("flame"))
        self.write("far.vdb", self.scalar("far", (500000, 0, 0), (500001, 0, 0)))
        self.write("huge.vdb", self.scalar("huge", (0, 0, 0), (40959, 40959, 40959)))
        (self.folder / "text.vdb").write_text("this is no volume")
        before = self.files()
        for like, told in (("none.vdb", "none.vdb"), ("text.vdb", "text.vdb"), ("empty.vdb", "flame (float)"),
                           ("empty.vdb:flame", "flame"), ("empty.vdb:v", "flame (float)"), (".", "."),
                           ("far.vdb", "far.vdb: grid 'far'"), ("huge.vdb", "huge.vdb: grid 'huge'")):
            self.assertIn(told, self.fails(3, "vdblic_noise", "-o", "noise.vdb", "--like", like))
        self.write("wide.vdb", self.scalar("wide", (-70000, 0, 0), (-69999, 0, 0)))
        self.outputs("vdblic_noise", "-o", "noise.vdb", "--like", "wide.vdb")
        self.assertIn("wide.vdb: grid 'wide'",
                      self.fails(3, "vdblic_noise", "-o", "n.vdb", "--like", "wide.vdb", "--refine", 2))
        self.assertEqual(self.files(), sorted([*before, "noise.vdb", "wide.vdb"]))

    def test_output_that_cannot_be_written(self):
        (self.folder / "taken.vdb").mkdir()
        for output, status in ((pathlib.Path("missing") / "noise.vdb", 4), ("taken.vdb", 2), ("/proc/noise.vdb", 4)):
            self.assertIn(str(output), self.fails(status, "vdblic_noise", "-o", output, "--size", 4, 4, 4))
        self.assertEqual(self.files(), ["taken.vdb"])

    def test_help_and_version(self):
        for option in ("--help", "--version"):
            done = self.run_tool("vdblic_noise", option)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertTrue(done.stdout)


if __name__ == "__main__":
    unittest.main()
