"""vdblic_render draws lines between frames."""

import re
import shutil

import numpy
import pyopenvdb as vdb

from support import RenderTest

LOOK = ("--size", 160, 120, "--samples", 1, "--projection", "orthographic", "--view-height", 24, "--eye", 11.5, 11.5, 80, "--target",
        11.5, 11.5, 11.5, "--up", 0, 1, 0, "--range", 0, 2, "--opacity", "0:0.9", "--exposure", 0, "--shadows", 0, "--occlusion", 0)
STREAKS = ("--dt", 1, "--method", "streaks", "--draw", "lines", "--spacing", 4)


class LineSubsteps(RenderTest):
    def setUp(self):
        """Air that turns about the axis z ever faster, in 24³ voxels."""
        super().setUp()
        place = numpy.indices((24, 24, 24)).transpose(1, 2, 3, 0) - 11.5
        for frame in 1, 2, 3:
            velocity = vdb.Vec3SGrid()
            velocity.name = "velocity"
            turning = numpy.stack([-place[..., 1], place[..., 0], 0 * place[..., 0]], -1) * (0.08 + 0.02 * frame)
            velocity.copyFromArray(turning.astype(numpy.float32))
            vdb.write(str(self.folder / f"v.{frame}.vdb"), [velocity])
        self.outputs("vdblic_advect", "v.%d.vdb", *STREAKS, "--tail", 3, "-o", "l.%d.vdb")

    def drawn(self, name):
        return numpy.stack(self.pixels(name, "R", "G", "B", "A"))

    def test_pictures_are_those_of_advected_substeps(self):
        self.outputs("vdblic_advect", "v.%d.vdb", *STREAKS, "--tail", 3, "--substeps", 4, "-o", "f.%d.vdb")
        made = self.renders("l.%d.vdb", "--substeps", 4, *LOOK, "-o", "a.%d.exr")
        self.assertEqual(made, [name.replace("b.", "a.") for name in self.renders("f.%d.vdb", *LOOK, "-o", "b.%d.exr")])
        pictures = [[self.drawn(f"{name}.{number}.exr") for number in range(1, 10)] for name in "ab"]
        difference = lambda a, b: numpy.abs(a - b).mean()
        for i, (between, advected) in enumerate(zip(*pictures)):
            if i % 4 == 0:
                numpy.testing.assert_array_equal(between, advected)
                continue
            step = difference(pictures[1][i - 1], advected)
            self.assertLess(difference(between, advected), 0.4 * step, i)
            self.assertGreater(difference(between, pictures[0][i - 1]), 0.8 * step, i)

    def test_an_observer_moves_on(self):
        """Lines that stand still to an observer who moves along move evenly through the world."""
        velocity = vdb.Vec3SGrid()
        velocity.name = "velocity"
        velocity.fill((0, 0, 0), (31, 15, 15), (2, 0, 0), True)
        for frame in 1, 2:
            vdb.write(str(self.folder / f"u.{frame}.vdb"), [velocity])
        self.outputs("vdblic_advect", "u.%d.vdb", *STREAKS, "--frame-velocity", 2, 0, 0, "--tail", 3, "-o", "o.%d.vdb")
        self.renders("o.%d.vdb", "--substeps", 2, *LOOK, "--by", "age", "--annotate", "box", "-o", "o.%d.exr")
        pictures = [self.drawn(f"o.{number}.exr")[3] for number in (1, 2, 3)]
        pixels = 5  # of a voxel, by which the observer moves in a substep
        self.assertGreater(pictures[1].sum(), 10)
        for before, after in zip(pictures, pictures[1:]):
            self.assertGreater((before > 0.1).sum(), 500)
            others = numpy.abs(after[:, pixels:] - before[:, :-pixels]) > 0.1
            self.assertLess(others.sum(), 0.05 * (before > 0.1).sum())  # of streaks that fade in or out

    def test_frames_selects_pictures(self):
        self.renders("l.%d.vdb", "--substeps", 3, *LOOK, "-o", "all.%d.exr")
        told = self.renders("l.%d.vdb", "--substeps", 3, *LOOK, "-o", "some.%d.exr", "--frames", "2-6x2,9", "--clamp-frames")
        self.assertEqual(told, ["some.2.exr", "some.4.exr", "some.6.exr"])
        for number in 2, 4, 6:
            numpy.testing.assert_array_equal(self.drawn(f"some.{number}.exr"), self.drawn(f"all.{number}.exr"))

    def test_numbers_of_a_sequence_with_gaps_are_those_of_advect(self):
        for frame in 3, 2, 1:
            (self.folder / f"l.{frame}.vdb").rename(self.folder / f"g.{10 * frame}.vdb")
        told = self.renders("g.%d.vdb", "--substeps", 2, *LOOK, "-o", "g.%d.exr")
        self.assertEqual(told, [f"g.{number}.exr" for number in (10, 11, 30, 31, 50)])
        self.assertIn("no picture 12", self.refuses(3, "g.%d.vdb", "--substeps", 2, "-o", "h.%d.exr", "--frames", 12))

    def test_any_number_of_threads_draws_the_same_picture(self):
        made = []
        for threads in 1, 2, 5:
            self.renders("l.%d.vdb", "--substeps", 5, "--frames", "3,8", *LOOK, "-o", f"t{threads}.%d.exr", "--threads", threads)
            made.append([(self.folder / f"t{threads}.{number}.exr").read_bytes() for number in (3, 8)])
        self.assertEqual(made[0], made[1])
        self.assertEqual(made[0], made[2])

    def test_time_and_camera_move_on(self):
        camera = ("--size", 160, 120, "--orbit", 0.3, "--annotate", "time")
        self.renders("l.%d.vdb", "--substeps", 2, *camera, "-o", "a.%d.exr")
        headers = [self.run_peer("exrheader", self.folder / f"a.{number}.exr") for number in (1, 2, 3)]
        eyes = [re.search(r"^eye .*", header, re.MULTILINE)[0] for header in headers]
        self.assertEqual(len(set(eyes)), 3)
        self.assertEqual([re.findall(r"^moment .*: (.*)", header, re.MULTILINE) for header in headers], [[], ["1.5"], []])
        texts = [self.pixels(f"a.{number}.exr", "annotation.A")[0] for number in (1, 2, 3)]
        self.assertFalse((texts[0] == texts[1]).all() or (texts[1] == texts[2]).all())

    def test_existing_pictures_are_left(self):
        self.renders("l.%d.vdb", "--substeps", 2, *LOOK, "-o", "a.%d.png", "--frames", "2")
        first = (self.folder / "a.2.png").stat().st_mtime_ns
        self.renders("l.%d.vdb", "--substeps", 2, *LOOK, "-o", "a.%d.png", "--skip-existing")
        self.assertEqual((self.folder / "a.2.png").stat().st_mtime_ns, first)
        self.assertTrue((self.folder / "a.5.png").exists())

    def test_what_cannot_be(self):
        grid = vdb.FloatGrid()
        grid.name = "density"
        grid.fill((0, 0, 0), (7, 7, 7), 1.0, True)
        for frame in 1, 2:
            vdb.write(str(self.folder / f"t.{frame}.vdb"), [grid])
            lines = (self.folder / f"l.{frame}.vdb").read_bytes()
            untold = lines.replace(b"\2\0\0\0dt", b"\2\0\0\0ds").replace(b"\x08\0\0\0checksum", b"\x08\0\0\0checksun")
            (self.folder / f"untold.{frame}.vdb").write_bytes(untold)
            shutil.copy(self.folder / "l.1.vdb", self.folder / f"still.{frame}.vdb")
        self.outputs("vdblic_advect", "v.%d.vdb", *STREAKS, "--tail", 0.5, "-o", "short.%d.vdb")
        for words, arguments in (
                (("t.1.vdb", "no lines", "vdblic_advect --substeps"), ("t.%d.vdb",)),
                (("short.2.vdb", "0.5 frames", "--tail"), ("short.%d.vdb",)),
                (("still.2.vdb", "time"), ("still.%d.vdb",)),
                (("untold.2.vdb", "dt"), ("untold.%d.vdb",)),
                (("none.%d.vdb", "no file matches"), ("none.%d.vdb",))):
            with self.subTest(arguments):
                done = self.run_tool("vdblic_render", *arguments, "--substeps", 2, "-o", "x.%d.png", "--size", 32, 24, "-q")
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertNotIn("x.2.png", done.stdout)
                self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
                for word in words:
                    self.assertIn(word, done.stderr)
        for words, arguments in ((("is no pattern",), ("l.1.vdb",)), (("is no pattern",), ("-",)),
                                 (("--lines",), ("t.%d.vdb", "--lines", "l.%d.vdb"))):
            with self.subTest(arguments):
                told = self.refuses(2, *arguments, "--substeps", 2, "-o", "x.%d.png")
                for word in words:
                    self.assertIn(word, told)

    def test_a_missing_frame(self):
        (self.folder / "l.3.vdb").rename(self.folder / "l.4.vdb")
        told = self.refuses(3, "l.%d.vdb", "--substeps", 2, *LOOK, "-o", "x.%d.png")
        self.assertIn("frame 3 is missing", told)
        self.renders("l.%d.vdb", "--substeps", 2, *LOOK, "-o", "x.%d.png", "--frames", "1-3")

    def test_outputs_never_replace_inputs(self):
        before = (self.folder / "l.2.vdb").read_bytes()
        self.refuses(2, "l.%d.vdb", "--substeps", 2, "--frames", 2, "-o", "a.%d.png", "--transfer-out", "l.2.vdb")
        self.assertEqual((self.folder / "l.2.vdb").read_bytes(), before)


if __name__ == "__main__":
    import unittest

    unittest.main()
