"""vdblic_coherence on the command line; numpy recomputes its figures from the grids that pyopenvdb reads."""

import json
import os
import pathlib
import shutil
import unittest
import xml.etree.ElementTree

import numpy
import pyopenvdb as vdb

from support import ToolTest

WAKE = pathlib.Path(os.environ["VDBLIC_SOURCE"]) / "samples" / "wake" / "wake.%04d.vdb"
FIGURES = ["temporal", "same_place", "gain", "along_length", "across_length", "length_ratio", "deviation", "saturated"]


def array_of(path, name="density"):
    grid = vdb.read(str(path), name)
    low, high = grid.evalActiveVoxelBoundingBox()
    array = numpy.zeros([high[i] - low[i] + 1 for i in range(3)], numpy.float32)
    grid.copyToArray(array, ijk=low)
    return array.astype(float)


def trilinear(array, points):
    """Trilinear values at points, one point a column."""
    base = numpy.floor(points).astype(int)
    fraction = points - base
    result = numpy.zeros(points.shape[1])
    for corner in numpy.ndindex(2, 2, 2):
        weight = numpy.prod([f if c else 1 - f for f, c in zip(fraction, corner)], axis=0)
        result += weight * array[tuple(b + c for b, c in zip(base, corner))]
    return result


class Coherence(ToolTest):
    def report(self, *arguments):
        self.outputs("vdblic_coherence", *arguments, "--json", "report.json")
        return json.loads(self.contents("report.json"))

    def uniform(self, frames, *options, size=(48, 40, 32)):
        """A velocity along (6, 3, 2) and textures of it."""
        self.outputs("vdblic_synth", "uniform", "-o", "vel.%04d.vdb", "--size", *size, "--frames", f"1-{frames}")
        self.outputs("vdblic_advect", "vel.%04d.vdb", "-o", "lic.%04d.vdb", *options)
        return "vel.%04d.vdb", "lic.%04d.vdb"

    def test_wake(self):
        self.outputs("vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "5-8")
        arguments = [WAKE, "lic.%04d.vdb", "--frames", "5-8"]
        done = self.run_tool("vdblic_coherence", *arguments, "--json", "figures.json", "-o", "plot.svg")
        self.assertEqual((done.returncode, done.stdout), (0, "figures.json\nplot.svg\n"), done.stderr)
        for word in "temporal", "same place", "along", "across", "95 %":
            self.assertIn(word, done.stderr)
        report = json.loads(self.contents("figures.json"))
        self.assertEqual([frame["frame"] for frame in report["frames"]], [5, 6, 7, 8])
        self.assertEqual(report["lags"], [0.5 * lag for lag in range(1, 33)])
        for frame in report["frames"]:
            for figures in frame["raw"], frame["smoothed"]:
                self.assertEqual(list(figures), FIGURES + ["along", "across"])
                self.assertEqual([len(figures["along"]), len(figures["across"])], [32, 32])
                self.assertGreater(figures["along_length"], 2 * figures["across_length"])
                if frame["frame"] < 8:
                    self.assertGreater(figures["temporal"], figures["same_place"] + 0.03)
                    self.assertGreater(figures["temporal"], 0.6)
                else:
                    self.assertIsNone(figures["temporal"])
            self.assertGreater(frame["points"], 50000)
            self.assertNotIn("hits", frame)
        raw = [frame["raw"] for frame in report["frames"]]
        temporal = numpy.array([figures["temporal"] for figures in raw[:3]])
        mean = report["mean"]["raw"]["temporal"]
        self.assertEqual(mean["frames"], 3)
        self.assertAlmostEqual(mean["mean"], temporal.mean(), 12)
        self.assertAlmostEqual(mean["half_width"], 4.302653 * temporal.std(ddof=1) / 3**0.5, 6)
        for direction in "along", "across":
            means = numpy.mean([figures[direction] for figures in raw], axis=0)
            numpy.testing.assert_allclose(report["mean"]["raw"][direction], means, rtol=1e-12)
        contrast = array_of(self.folder / "lic.0006.vdb")
        contrast = contrast[contrast > 0]
        self.assertAlmostEqual(raw[1]["deviation"], contrast.std(), 4)
        # The plot is XML with four curves and the key to each.
        root = xml.etree.ElementTree.fromstring(self.contents("plot.svg"))
        curves = [path for path in root.iter() if "stroke-width:2;" in path.get("style", "")]
        self.assertEqual(len(curves), 8)

    def test_figures_equal_numpys(self):
        velocity, texture = self.uniform(2)
        grid = vdb.read(str(self.folder / "vel.0001.vdb"), "velocity")
        world = numpy.array(grid.getConstAccessor().getValue((20, 20, 20)))
        step = world * grid["dt"] / numpy.array(grid.transform.voxelSize())
        self.assertGreater(numpy.linalg.norm(step), 0.5)
        report = self.report(velocity, texture, "--samples", 200000)
        found = report["frames"][0]["raw"]

        before, after = (array_of(self.folder / f"lic.000{k}.vdb") for k in (1, 2))
        random = numpy.random.default_rng(1)
        size = numpy.array(before.shape)[:, None]
        points = random.uniform(size=(3, 200000)) * (size - 1)
        there = points + step[:, None]
        inside = numpy.all((there >= 0) & (there < size - 1), axis=0)
        points, there = points[:, inside], there[:, inside]
        here = trilinear(before, points)
        self.assertAlmostEqual(found["temporal"], numpy.corrcoef(here, trilinear(after, there))[0, 1], delta=0.012)
        self.assertAlmostEqual(found["same_place"], numpy.corrcoef(here, trilinear(after, points))[0, 1], delta=0.012)
        along = step / numpy.linalg.norm(step)
        for lag in 1, 3, 5:
            there = points + lag * along[:, None]
            inside = numpy.all(there < size - 1, axis=0)
            expected = numpy.corrcoef(here[inside], trilinear(before, there[:, inside]))[0, 1]
            self.assertAlmostEqual(found["along"][2 * lag - 1], expected, delta=0.015)
        self.assertAlmostEqual(found["deviation"], before.std(), 6)

    def test_report_does_not_depend_on_threads(self):
        velocity, texture = self.uniform(3)
        reports = [self.report(velocity, texture, "--samples", 5000, "--threads", n) for n in (1, 2, 7)]
        self.assertEqual(reports[0], reports[1])
        self.assertEqual(reports[0], reports[2])

    def test_hits_are_reported_if_the_file_has_them(self):
        velocity, texture = self.uniform(1)
        path = str(self.folder / "lic.0001.vdb")
        density = vdb.read(path, "density")
        hits = vdb.FloatGrid()
        array = numpy.full((48, 40, 32), 3, numpy.float32)
        array[:12] = 0
        hits.copyFromArray(array, tolerance=0)
        for x in range(12):  # active zeros
            for y in range(40):
                for z in range(32):
                    hits.getAccessor().setValueOn((x, y, z), 0.0)
        hits.name = "hits"
        vdb.write(path, [density, hits])
        frame = self.report(velocity, texture)["frames"][0]
        self.assertEqual(frame["hits"], {"mean": 2.25, "zero_share": 0.25})
        self.assertIsNone(frame["raw"]["temporal"])

    def test_one_file(self):
        self.uniform(1)
        report = self.report("vel.0001.vdb", "lic.0001.vdb")
        self.assertEqual(len(report["frames"]), 1)
        self.assertIsNotNone(report["frames"][0]["raw"]["along_length"])
        self.assertEqual(report["mean"]["raw"]["along_length"]["half_width"], None)

    def test_bad_options(self):
        pair = self.uniform(2)
        self.fails(2, "vdblic_coherence", pair[0])
        self.fails(2, "vdblic_coherence", "-", pair[1])
        self.fails(2, "vdblic_coherence", pair[0], "lic.0001.vdb")
        for option in (["--samples", 0], ["--samples", "nan"], ["--dt", "nan"], ["--dt", 0], ["--fps", 0], ["--fps", -1],
                       ["--velocity-unit", "furlongs"], ["--texture", ""], ["--velocity-scale", "inf"],
                       ["--frames", "3-1"], ["--nonsense"], ["--json", "vel.0001.vdb"], ["-o", "lic.0002.vdb"],
                       ["--json", "x", "-o", "x"]):
            self.fails(2, "vdblic_coherence", *pair, *option)

    def test_bad_input(self):
        pair = self.uniform(3)
        self.assertIn("holds density", self.fails(3, "vdblic_coherence", *pair, "--texture", "smoke"))
        self.assertIn("frame 4", self.fails(3, "vdblic_coherence", *pair, "--frames", "1-9"))
        moved = vdb.read(str(self.folder / "lic.0002.vdb"), "density")
        moved.transform = vdb.createLinearTransform(voxelSize=0.77)
        vdb.write(str(self.folder / "moved.0002.vdb"), moved)
        self.assertIn("transform", self.fails(3, "vdblic_coherence", pair[0], "moved.%04d.vdb", "--frames", "2"))
        bad = vdb.read(str(self.folder / "lic.0002.vdb"), "density")
        bad.getAccessor().setValueOn((3, 4, 5), float("nan"))
        vdb.write(str(self.folder / "bad.0002.vdb"), bad)
        self.assertIn("not finite", self.fails(3, "vdblic_coherence", pair[0], "bad.%04d.vdb", "--frames", "2"))
        os.remove(self.folder / "lic.0002.vdb")
        message = self.fails(3, "vdblic_coherence", *pair)
        self.assertIn("lic.0002.vdb", message)
        self.assertIn("missing", message)
        shutil.copy(self.folder / "lic.0001.vdb", self.folder / "lic.0002.vdb")
        shutil.copy(self.folder / "lic.0001.vdb", self.folder / "lic.0004.vdb")
        self.assertIn("vel.0004.vdb", self.fails(3, "vdblic_coherence", *pair))
        self.assertEqual(len(self.report(*pair, "--frames", "1-9", "--clamp-frames")["frames"]), 3)
        (self.folder / "lic.0003.vdb").write_text("no volume")
        self.fails(3, "vdblic_coherence", *pair, "--frames", "1-3")

    def test_bad_output(self):
        pair = self.uniform(1)
        self.fails(4, "vdblic_coherence", *pair, "--json", "none/report.json")
        self.fails(4, "vdblic_coherence", *pair, "-o", "none/plot.svg")
        self.assertEqual(self.files(), ["lic.0001.vdb", "vel.0001.vdb"])


if __name__ == "__main__":
    unittest.main()
