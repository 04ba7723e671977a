"""vdblic_coherence on the command line; numpy recomputes its figures from the grids that pyopenvdb reads."""

import json
import os
import shutil
import unittest

import numpy
import pyopenvdb as vdb

from support import WAKE, ToolTest

FIGURES = ["temporal", "same_place", "gain", "along_length", "across_length", "length_ratio", "deviation", "saturated"]
CLASSES = [(0.5, 2), (2, 4), (4, 8), (8, 30)]
CLASS_FIGURES = ["isolated", "line", "angle", "deviation", "temporal", "same_place"]


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


def lines_of(texture):
    """Strength and direction of the lines at the voxels that are three voxels or more from the rim."""
    gradients = [gradient[1:-1, 1:-1, 1:-1] for gradient in numpy.gradient(texture)]
    tensor = numpy.empty([n - 6 for n in texture.shape] + [3, 3])
    for i in range(3):
        for j in range(3):
            cubes = numpy.lib.stride_tricks.sliding_window_view(gradients[i] * gradients[j], (5, 5, 5))
            tensor[..., i, j] = cubes.mean(axis=(3, 4, 5))
    widths, directions = numpy.linalg.eigh(tensor)
    return (widths[..., 1] - widths[..., 0]) / (widths[..., 1] + widths[..., 0]), directions[..., 0]


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
        self.outputs("vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "5-8", "--finish", 0)
        arguments = [WAKE, "lic.%04d.vdb", "--frames", "5-8"]
        done = self.run_tool("vdblic_coherence", *arguments, "--json", "figures.json")
        self.assertEqual((done.returncode, done.stdout), (0, "figures.json\n"), done.stderr)
        for word in "temporal", "same place", "along", "across", "95 %", "by displacement a step", "0.5 to 2", "isolated":
            self.assertIn(word, done.stderr)
        report = json.loads(self.contents("figures.json"))
        self.assertEqual([frame["frame"] for frame in report["frames"]], [5, 6, 7, 8])
        self.assertEqual(report["lags"], [0.5 * lag for lag in range(1, 33)])
        for classes in *(frame["by_displacement"] for frame in report["frames"]), report["mean"]["by_displacement"]:
            self.assertEqual([(one["from"], one["to"]) for one in classes], CLASSES)
            self.assertEqual(list(classes[0]), ["from", "to", "points", *CLASS_FIGURES])
        # At 8 voxels a step and more, there are no points: the class says so instead of printing figures.
        self.assertIn("8 to 30           0   too few points", done.stderr)
        self.assertEqual(report["mean"]["by_displacement"][3]["line"], {"mean": None, "half_width": None, "frames": 0})
        of_class = [frame["by_displacement"][1] for frame in report["frames"]]
        mean = report["mean"]["by_displacement"][1]
        self.assertEqual(mean["points"], sum(one["points"] for one in of_class))
        self.assertAlmostEqual(mean["line"]["mean"], numpy.mean([one["line"] for one in of_class]), 12)
        self.assertEqual((mean["line"]["frames"], mean["temporal"]["frames"]), (4, 3))
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

    def test_figures_equal_numpys(self):
        self.assert_figures_equal_numpys((1, 1, 1), self.uniform(2))

    def test_figures_of_refined_textures_equal_numpys(self):
        for refine in (2, 2, 2), (3, 1, 2):
            with self.subTest(refine):
                self.assert_figures_equal_numpys(refine, self.uniform(2, "--refine", *refine, size=(40, 32, 24)))

    def assert_figures_equal_numpys(self, refine, sequences):
        grid = vdb.read(str(self.folder / "vel.0001.vdb"), "velocity")
        world = numpy.array(grid.getConstAccessor().getValue((20, 20, 20)))
        coarse_step = world * grid["dt"] / numpy.array(grid.transform.voxelSize())
        self.assertGreater(numpy.linalg.norm(coarse_step), 0.5)
        step = coarse_step * refine
        report = self.report(*sequences, "--samples", 200000)
        self.assertEqual(report.get("refine", [1, 1, 1]), list(refine))
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
        along = step / numpy.linalg.norm(coarse_step)  # a voxel of the velocity, in voxels of the texture
        for lag in 0.5 / max(refine), 1, 3, 5:
            there = points + lag * along[:, None]
            inside = numpy.all(there < size - 1, axis=0)
            expected = numpy.corrcoef(here[inside], trilinear(before, there[:, inside]))[0, 1]
            self.assertAlmostEqual(found["along"][report["lags"].index(lag)], expected, delta=0.015)
        self.assertAlmostEqual(found["deviation"], before.std(), 6)
        self.assert_classes_equal_numpys(report["frames"][0]["by_displacement"], before, after, step)

    def assert_classes_equal_numpys(self, classes, before, after, step):
        displacement = numpy.linalg.norm(step)
        for one in classes:
            self.assertEqual(one["points"] > 0, one["from"] < displacement <= one["to"])
        found = next(one for one in classes if one["points"])
        strength, direction = lines_of(before)
        self.assertAlmostEqual(found["line"], strength.mean(), delta=0.005)
        cosine = numpy.median(numpy.abs(direction @ step)) / displacement
        self.assertAlmostEqual(found["angle"], numpy.degrees(numpy.arccos(cosine)), delta=0.3)
        self.assertAlmostEqual(found["deviation"], before[3:-3, 3:-3, 3:-3].std(), delta=0.004)
        points = numpy.indices(before.shape)[:, 3:-3, 3:-3, 3:-3].reshape(3, -1)
        there = points + step[:, None]
        points = points[:, numpy.all(there < numpy.array(before.shape)[:, None] - 1, axis=0)]
        here, same = before[tuple(points)], after[tuple(points)]
        carried = trilinear(after, points + step[:, None])
        self.assertAlmostEqual(found["temporal"], numpy.corrcoef(here, carried)[0, 1], delta=0.005)
        self.assertAlmostEqual(found["same_place"], numpy.corrcoef(here, same)[0, 1], delta=0.01)

    def test_lengths_are_in_voxels_of_the_velocity(self):
        """UFLIC, because AUFLIC's mean along the flow is over texture voxels: it lengthens coarse streaks more."""
        lengths = {}
        for refine in 1, 2, 3:
            self.outputs("vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "7-8", "--refine", refine,
                         "--method", "uflic", "--finish", 0, "--lead-in", 2)
            report = self.report(WAKE, "lic.%04d.vdb", "--frames", "7-8", "--samples", 30000)
            lags = report["lags"]
            self.assertEqual((lags[0], lags[-1]), (0.5 / refine, 16))
            self.assertEqual(lags, sorted({0.5 * n / refine for n in range(1, 33)} | {0.5 * n for n in range(1, 33)}))
            for figures in report["frames"][0]["raw"], report["mean"]["smoothed"]:
                self.assertEqual([len(figures["along"]), len(figures["across"])], [len(lags)] * 2)
            raw = report["mean"]["raw"]
            lengths[refine] = raw["along_length"]["mean"], refine * raw["across_length"]["mean"]
            self.assertGreater(raw["gain"]["mean"], 0.1)
        for refine in 2, 3:  # streaks of the same length, as many texture voxels wide
            self.assertAlmostEqual(lengths[refine][0] / lengths[1][0], 1, delta=0.15)
            self.assertAlmostEqual(lengths[refine][1] / lengths[1][1], 1.2, delta=0.15)

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

    def test_textures_with_substeps(self):
        """Those of the velocity's frames are measured; a selection need not begin with the first frame."""
        velocity, _ = self.uniform(3)
        self.outputs("vdblic_advect", velocity, "-o", "substep.%04d.vdb", "--substeps", 3)
        for frame in 1, 2, 3:
            grid = vdb.read(str(self.folder / f"substep.{3 * frame - 2:04}.vdb"), "density")
            vdb.write(str(self.folder / f"plain.{frame:04}.vdb"), grid)
        for frames in [], ["--frames", "2-3"]:
            reports = []
            for name in "substep", "plain":
                run = self.run_tool("vdblic_coherence", velocity, f"{name}.%04d.vdb", "--json", f"{name}.json", *frames)
                self.assertEqual(run.returncode, 0, run.stderr)
                reports.append(json.loads((self.folder / f"{name}.json").read_text())["frames"])
            self.assertEqual(*reports)
        os.remove(self.folder / "substep.0004.vdb")
        message = self.fails(3, "vdblic_coherence", velocity, "substep.%04d.vdb")
        self.assertIn("substep.0004.vdb: the texture of frame 2 is missing", message)

    def test_bad_input(self):
        pair = self.uniform(3)
        self.assertIn("present: density", self.fails(3, "vdblic_coherence", *pair, "--texture", "smoke"))
        self.assertIn("frame 4", self.fails(3, "vdblic_coherence", *pair, "--frames", "1-9"))
        moved = vdb.read(str(self.folder / "lic.0002.vdb"), "density")
        moved.transform = vdb.createLinearTransform(voxelSize=0.77)
        vdb.write(str(self.folder / "moved.0002.vdb"), moved)
        self.assertIn("transform", self.fails(3, "vdblic_coherence", pair[0], "moved.%04d.vdb", "--frames", "2"))
        shutil.copy(self.folder / "lic.0001.vdb", self.folder / "mixed.0001.vdb")
        self.outputs("vdblic_advect", "vel.0002.vdb", "-o", "mixed.0002.vdb", "--refine", "2", "1", "1")
        message = self.fails(3, "vdblic_coherence", pair[0], "mixed.%04d.vdb", "--frames", "1-2")
        self.assertIn("mixed.0002.vdb: grid density: 2 x 1 x 1 texture voxels", message)
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
        self.assertEqual(self.files(), ["lic.0001.vdb", "vel.0001.vdb"])


if __name__ == "__main__":
    unittest.main()
