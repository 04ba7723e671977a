"""vdblic_diff on the command line, checked with numpy on grids written and read by pyopenvdb."""

import json
import math
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy
import pyopenvdb

TOOL = Path(os.environ["VDBLIC_BIN"]) / "vdblic_diff"
SHAPE = (21, 18, 13)  # not a multiple of a leaf


def array(seed, components=None):
    shape = SHAPE if components is None else (*SHAPE, components)
    return numpy.random.default_rng(seed).normal(size=shape).astype(numpy.float32)


def grid(values, name="density", kind=pyopenvdb.FloatGrid, voxel=0.5):
    """A grid whose active voxels are those of `values`, from index (-3, 5, 100) on."""
    result = kind()
    result.copyFromArray(values, ijk=(-3, 5, 100), tolerance=0 if values.ndim == 3 else (0, 0, 0))
    result.name = name
    result.transform = pyopenvdb.createLinearTransform(voxelSize=voxel)
    return result


class Diff(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="vdblic_diff_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return str(self.folder / name)

    def write(self, name, *grids, metadata=None):
        pyopenvdb.write(self.path(name), grids=list(grids), metadata=metadata or {})
        return self.path(name)

    def diff(self, *arguments, status):
        done = subprocess.run([str(TOOL), *map(str, arguments)], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, status, f"{arguments}: {done.stderr}")
        return done

    def report(self, *arguments, status):
        target = self.path("report.json")
        done = self.diff(*arguments, "--json", target, status=status)
        self.assertEqual(done.stdout.splitlines()[-1], target)
        return json.loads(Path(target).read_text())

    def test_figures_equal_numpys(self):
        x, y = array(1), array(2)
        x[x < 0.5] = 0  # inactive in A only
        a, b = self.write("a.vdb", grid(x)), self.write("b.vdb", grid(y))
        tolerance, relative = 0.75, 0.9
        found = self.report(a, b, "--fail", tolerance, "--relative", relative, status=1)
        values = found["frames"][0]["grids"][0]["values"]

        error = numpy.abs(x.astype(float) - y.astype(float))
        magnitude = numpy.maximum(numpy.abs(x), numpy.abs(y)).astype(float)
        over = error > numpy.maximum(tolerance, relative * magnitude)
        one_sided = (x != 0) != (y != 0)
        compared = (x != 0) | (y != 0)
        self.assertEqual(values["compared"], numpy.count_nonzero(compared))
        self.assertEqual(values["over_fail"], numpy.count_nonzero(over))
        self.assertEqual(values["failing"], numpy.count_nonzero(over | one_sided))
        self.assertEqual(values["only_in_b"], numpy.count_nonzero((y != 0) & (x == 0)))
        self.assertEqual(values["only_in_a"], 0)
        self.assertAlmostEqual(values["failing_percent"], 100 * (over | one_sided).sum() / compared.sum(), 10)
        rms = math.sqrt((error[compared] ** 2).mean())
        self.assertEqual(values["error"]["max"], error.max())
        self.assertAlmostEqual(values["error"]["mean"], error[compared].mean(), 12)
        self.assertAlmostEqual(values["error"]["rms"], rms, 12)
        self.assertAlmostEqual(values["psnr"], 20 * math.log10(magnitude.max() / rms), 9)
        self.assertEqual(values["max_relative"], (error[compared] / magnitude[compared]).max())

        first = numpy.argwhere(over | one_sided)[0]
        worst = numpy.unravel_index(error.argmax(), SHAPE)
        offset = numpy.array((-3, 5, 100))
        self.assertEqual(values["first"]["index"], (first + offset).tolist())
        self.assertEqual(values["worst"]["index"], (worst + offset).tolist())
        self.assertEqual(values["worst"]["world"], ((worst + offset) * 0.5).tolist())
        self.assertEqual(numpy.float32(values["worst"]["a"]), x[worst])
        self.assertEqual(numpy.float32(values["worst"]["b"]), y[worst])

    def test_vectors_by_length_and_component(self):
        x, y = array(3, 3), array(4, 3)
        a = self.write("a.vdb", grid(x, "velocity", pyopenvdb.Vec3SGrid))
        b = self.write("b.vdb", grid(y, "velocity", pyopenvdb.Vec3SGrid))
        values = self.report(a, b, status=1)["frames"][0]["grids"][0]["values"]
        difference = x.astype(float) - y.astype(float)
        length = numpy.linalg.norm(difference, axis=3)
        self.assertAlmostEqual(values["error"]["max"], length.max(), 12)
        self.assertAlmostEqual(values["error"]["rms"], math.sqrt((length**2).mean()), 12)
        for axis in range(3):
            part = values["components"][axis]
            self.assertEqual(part["max"], numpy.abs(difference[..., axis]).max())
            self.assertAlmostEqual(part["mean"], numpy.abs(difference[..., axis]).mean(), 12)

    def test_difference_grids(self):
        x, y = array(5), array(6)
        u, v = array(7, 3), array(8, 3)
        a = self.write("a.vdb", grid(x), grid(u, "velocity", pyopenvdb.Vec3SGrid), grid(x, "only_a"))
        b = self.write("b.vdb", grid(v, "velocity", pyopenvdb.Vec3SGrid), grid(y))
        target = self.path("difference.vdb")
        done = self.diff(a, b, "-o", target, status=1)
        self.assertEqual(done.stdout, target + "\n")
        self.assertIn("only_a", done.stderr)
        for name, expected in (("density", numpy.abs(x - y)), ("velocity", numpy.abs(u - v))):
            written = pyopenvdb.read(target, name)
            self.assertEqual(written.transform, pyopenvdb.createLinearTransform(voxelSize=0.5))
            back = numpy.zeros_like(expected)
            written.copyToArray(back, ijk=(-3, 5, 100))
            numpy.testing.assert_array_equal(back, expected)

    def test_what_idiff_lets_pass(self):
        x = array(9)
        a = self.write("a.vdb", grid(x), grid(x, "second"))
        self.diff(a, self.write("scaled.vdb", grid(x, voxel=0.25), grid(x, "second")), status=1)
        self.diff(a, self.write("second.vdb", grid(x), grid(x + 1, "second")), status=1)
        self.diff(a, self.write("missing.vdb", grid(x)), status=1)
        y = grid(x)
        y.getAccessor().setValueOn((1, 10, 106), math.nan)
        nan = self.write("nan.vdb", y, grid(x, "second"))
        values = self.report(a, nan, "--fail", 1e30, status=1)["frames"][0]["grids"][0]["values"]
        self.assertEqual(values["not_finite"], 1)
        self.assertEqual(values["error"]["max"], "inf")
        self.assertEqual(values["worst"]["index"], [1, 10, 106])
        self.assertEqual(values["worst"]["b"], "nan")
        self.diff(nan, nan, status=0)
        self.diff(a, self.write("b.vdb", grid(x, "second"), grid(x)), status=0)

    def test_half_precision_and_metadata(self):
        x = array(10).astype(numpy.float16).astype(numpy.float32)
        half = grid(x)
        half.saveFloatAsHalf = True
        a = self.write("a.vdb", grid(x), metadata={"life": 4, "creator": "one"})
        b = self.write("b.vdb", half, metadata={"life": 5, "creator": "two"})
        found = self.report(a, b, status=1)["frames"][0]
        self.assertEqual(found["grids"][0]["verdict"], "same")
        self.assertEqual(found["metadata"], [{"key": "life", "a": "4", "b": "5"}])
        self.diff(a, b, "--ignore-metadata", "life", status=0)
        self.diff(a, b, "--ignore-metadata", "other,li*", status=0)

    def test_thresholds_and_statuses(self):
        x = numpy.ones((10, 10, 10), numpy.float32)
        y = x.copy()
        y[:5, 0, 0] = 1.5
        a, b = self.write("a.vdb", grid(x)), self.write("b.vdb", grid(y))
        self.diff(a, b, status=1)
        self.diff(a, b, "--fail", 0.5, status=0)
        self.diff(a, b, "--relative", 0.34, status=0)
        self.diff(a, b, "--fail-percent", 0.5, status=0)
        self.diff(a, b, "--fail-percent", 0.4, status=1)
        quiet = self.diff(a, b, "-q", status=1)
        self.assertEqual(quiet.stdout + quiet.stderr, "")
        for arguments in (
            [a],
            [a, b, a],
            [a, b, "--fail", "nan"],
            [a, b, "--fail", "-1"],
            [a, b, "--fail-percent", "101"],
            [a, b, "--fail", "x"],
            [a, b, "--nonsense"],
            [a, b, "--frames", "1"],
            [a, self.path("b.%04d.vdb")],
            ["-", b],
            [a, b, "-o", b],
        ):
            self.diff(*arguments, status=2)
        Path(self.path("text.vdb")).write_text("no volume")
        self.diff(a, self.path("text.vdb"), status=3)
        self.diff(a, self.path("none.vdb"), status=3)
        self.diff(a, b, "-o", self.path("no/folder.vdb"), status=4)
        self.diff(a, b, "--json", self.path("no/folder.json"), status=4)
        self.assertIn("1 different", self.diff("--help", status=0).stdout)

    def test_sequences(self):
        for frame in range(1, 5):
            self.write(f"a.{frame:04}.vdb", grid(array(frame)))
            self.write(f"b_{frame}.vdb", grid(array(frame)))
        a, b = self.path("a.%04d.vdb"), self.path("b_$F.vdb").replace("$F", "#")
        self.diff(a, b, status=0)
        self.write("b_3.vdb", grid(array(30)))
        found = self.report(a, b, "-o", self.path("d.%04d.vdb"), status=1)
        self.assertEqual([frame["verdict"] for frame in found["frames"]], ["same", "same", "different", "same"])
        expected = numpy.abs(array(3) - array(30))
        back = numpy.zeros(SHAPE, numpy.float32)
        pyopenvdb.read(self.path("d.0003.vdb"), "density").copyToArray(back, ijk=(-3, 5, 100))
        numpy.testing.assert_array_equal(back, expected)
        self.diff(a, b, "--frames", "1-2,4", status=0)
        self.diff(a, b, "--frames", "1-9", status=3)

        os.remove(self.path("b_2.vdb"))
        found = self.report(a, b, status=1)
        self.assertIsNone(found["frames"][1]["b"])
        self.assertEqual(found["frames"][1]["verdict"], "different")
        self.diff(a, b, "--frames", "1,4", status=0)
        self.diff(a, b, "-o", self.path("one.vdb"), status=2)

    def test_the_report_does_not_depend_on_threads(self):
        a, b = self.write("a.vdb", grid(array(11))), self.write("b.vdb", grid(array(12)))
        one = self.report(a, b, "--threads", 1, status=1)
        self.assertEqual(one, self.report(a, b, "--threads", 4, status=1))


if __name__ == "__main__":
    unittest.main()
