"""vdblic_render draws lines in a texture of voxels."""

import numpy
import pyopenvdb as vdb

from support import RenderTest

PLAIN = ("--size", 120, 90, "--samples", 1, "--projection", "orthographic", "--view-height", 26, "--eye", 11.5, 11.5, 80, "--target",
         11.5, 11.5, 11.5, "--up", 0, 1, 0, "--range", 0, 2, "--exposure", 0, "--shadows", 0, "--occlusion", 0, "--depth-cue", 0,
         "--aov", "depth,normal,samples", "--precision", "float")
OPACITY = 0.1  # of a voxel
ROUNDING = 2e-6
SPENT = 2 / 256  # the light that a ray may leave, of colours that may be above 1


class LinesInTexture(RenderTest):
    def setUp(self):
        """Air that turns about the axis z, as lines in 24³ voxels."""
        super().setUp()
        place = numpy.indices((24, 24, 24)).transpose(1, 2, 3, 0) - 11.5
        velocity = vdb.Vec3SGrid()
        velocity.name = "velocity"
        velocity.copyFromArray((numpy.stack([-place[..., 1], place[..., 0], 0 * place[..., 0]], -1) * 0.1).astype(numpy.float32))
        for frame in 1, 2:
            vdb.write(str(self.folder / f"v.{frame}.vdb"), [velocity])
        self.outputs("vdblic_advect", "v.%d.vdb", "--dt", 1, "--method", "streaks", "--draw", "lines", "--spacing", 4, "-o", "l.%d.vdb")

    def fog(self, low, high, name="t.2.vdb", **values):
        """A texture without structure between two heights."""
        grids = []
        for grid_name, value in {"density": 1.0, "magnitude": 1.0, **values}.items():
            grid = vdb.FloatGrid()
            grid.name = grid_name
            grid.fill((-4, -4, low), (27, 27, high), value, True)
            grids.append(grid)
        vdb.write(str(self.folder / name), grids)

    def picture(self, *arguments):
        self.renders(*arguments, *PLAIN, "-o", "a.exr")
        red, green, blue, alpha, depth, samples = self.pixels("a.exr", "R", "G", "B", "A", "Z", "samples")
        return numpy.stack([red, green, blue, alpha]), depth, samples

    def alone(self, *options):
        """The texture alone, and the lines alone."""
        return self.picture("t.2.vdb", "--opacity", f"0:{OPACITY}", *options), self.picture("l.2.vdb", *options)

    def both(self, *options):
        return self.picture("t.2.vdb", "--lines", "l.%d.vdb", "--opacity", f"0:{OPACITY}", *options)

    def test_lines_before_the_texture(self):
        self.fog(-20, -11)
        (texture, behind, _), (lines, before, _) = self.alone()
        both, depth, _ = self.both()
        numpy.testing.assert_allclose(both, lines + (1 - lines[3]) * texture, atol=SPENT)
        solid = lines[3] > 0.9
        self.assertTrue(solid.any())
        seen = (lines[3] > 0) & (lines[3] < 0.99)
        mean = lines[3, seen] * before[seen] + ((1 - lines[3]) * texture[3])[seen] * behind[seen]
        mean /= both[3, seen]
        numpy.testing.assert_allclose(depth[seen], mean, rtol=1e-4)
        open_ = lines[3] == 0
        numpy.testing.assert_array_equal(both[:, open_], texture[:, open_])
        numpy.testing.assert_array_equal(depth[open_], behind[open_])

    def test_lines_behind_the_texture(self):
        self.fog(36, 45)
        (texture, _, _), (lines, _, _) = self.alone()
        left = (1 - OPACITY) ** 10
        before = texture[3] > 0
        numpy.testing.assert_allclose(1 - texture[3, before], left, atol=ROUNDING)
        numpy.testing.assert_allclose(self.both()[0][:, before], (texture + left * lines)[:, before], atol=SPENT)

    def test_lines_behind_opaque_voxels(self):
        self.fog(36, 45)
        options = ("--opacity", "0:0.999")
        texture = self.picture("t.2.vdb", *options)[0]
        self.assertTrue((texture[3] > 0.999).any())
        numpy.testing.assert_allclose(self.picture("t.2.vdb", "--lines", "l.2.vdb", *options)[0][:, texture[3] > 0], texture[:, texture[3] > 0], atol=1e-4)

    def test_lines_inside_the_texture(self):
        """Voxels before a tube attenuate it, and it those behind: known where a ray meets one tube."""
        self.fog(-2, 25)
        options = ("--shading", "none")
        (texture, _, _), (lines, place, met) = self.alone(*options)
        both = self.both(*options)[0]
        kept = (1 - lines[3]) * (1 - texture[3])
        numpy.testing.assert_allclose(both[3], 1 - kept, atol=SPENT)
        one = met == 1
        self.assertGreater(one.sum(), 50)
        before = (1 - OPACITY) ** (place - 54.5)[one]  # the eye is 54.5 above
        whole = (1 - OPACITY) ** 28
        color = texture[:3, one] / texture[3, one]
        expected = color * (1 - before) + before * lines[:3, one] + color * (1 - lines[3, one]) * (before - whole)
        numpy.testing.assert_allclose(both[:3, one], expected, atol=SPENT)

    def test_cuts_are_of_both_and_regions_of_the_texture(self):
        self.fog(-20, -11)
        for cut in (("--clip-plane", 11.5, 0, 0, 1, 0, 0), ("--clip-box", 0, 0, -30, 11, 23, 30)):
            with self.subTest(cut):
                (texture, _, _), (lines, _, _) = self.alone(*cut)
                numpy.testing.assert_allclose(self.both(*cut)[0], lines + (1 - lines[3]) * texture, atol=SPENT)
        region = ("--roi-box", 0, 0, -30, 11, 23, 30)
        (texture, _, _), (lines, _, _) = self.alone(*region)[0], self.alone()[1]
        numpy.testing.assert_allclose(self.both(*region)[0], lines + (1 - lines[3]) * texture, atol=SPENT)

    def test_any_number_of_threads_draws_the_same_picture(self):
        self.fog(-2, 25)
        made = []
        for threads in 1, 2, 5:
            self.renders("t.2.vdb", "--lines", "l.%d.vdb", "-o", f"t{threads}.exr", "--size", 160, 90, "--look", "vortex", "--opacity-by",
                         "magnitude", "--opacity", "0:0.05", "--ground", "below", "--annotate", "colorbar", "--aov", "all", "--threads", threads)
            made.append((self.folder / f"t{threads}.exr").read_bytes())
        self.assertEqual(made[0], made[1])
        self.assertEqual(made[0], made[2])

    def test_the_ground_takes_the_shadow_of_lines(self):
        self.fog(-2, 25)
        camera = ("--size", 160, 90, "--eye", 11, -80, 60, "--target", 11, 11, 0, "--exposure", 0)
        self.renders("l.2.vdb", "-o", "a.exr", *camera)
        open_ = self.pixels("a.exr", "A")[0] == 0
        seen = []
        for options in ((), ("--lines", "l.2.vdb")):
            self.renders("t.2.vdb", *options, "-o", "a.exr", "--opacity", "0:0.0001", "--ground", "below", *camera)
            seen.append(numpy.stack(self.pixels("a.exr", "R", "G", "B")).sum(0))
        open_ &= seen[0] > 0.01
        self.assertLess((seen[1][open_] / seen[0][open_]).min(), 0.9)

    def test_what_is_told(self):
        """Colours have the texture's range; opacity follows q where lines carry it; a colour bar shows both."""
        self.outputs("vdblic_advect", "v.%d.vdb", "--dt", 1, "--method", "streaks", "--draw", "lines", "--spacing", 4, "--with", "q", "-o", "q.%d.vdb")
        self.fog(-20, -11)
        for lines, scalar in ("l", "magnitude"), ("q", "q"):
            done = self.run_tool("vdblic_render", "t.2.vdb", "--lines", f"{lines}.%d.vdb", "-o", "a.exr", *PLAIN, "--annotate", "colorbar")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"lines: colours of magnitude 0 to 2, opacity by {scalar} ", done.stderr)
            bar = self.pixels("a.exr", "annotation.A")[0][66:, 90:]
            self.assertEqual(bool((bar > 0).any()), scalar == "q")

    def test_what_cannot_be(self):
        self.fog(-20, -11)
        self.fog(-20, -11, "t.3.vdb")
        self.fog(-20, -11, "h.2.vdb", heat=1.0)
        for words, arguments in (
                (("l.3.vdb", "frame 3", "--frames"), ("t.%d.vdb", "--lines", "l.%d.vdb", "--frames", 3)),
                (("none.2.vdb", "missing"), ("t.2.vdb", "--lines", "none.%d.vdb")),
                (("t.2.vdb", "no lines", "--method streaks --draw lines"), ("t.2.vdb", "--lines", "t.2.vdb")),
                (("v.2.vdb", "no lines"), ("t.2.vdb", "--lines", "v.2.vdb")),
                (("l.2.vdb", "holds lines itself"), ("l.2.vdb", "--lines", "l.2.vdb")),
                (("l.2.vdb", "no scalar 'heat'", "--color-by"), ("h.2.vdb", "--lines", "l.2.vdb", "--by", "heat"))):
            with self.subTest(arguments):
                told = self.refuses(3, *arguments, "-o", "x.%d.png", "--size", 32, 24)
                self.assertEqual(len(told.strip().splitlines()), 1, told)
                for word in words:
                    self.assertIn(word, told)
        self.assertIn("more than one", self.refuses(2, "t.2.vdb", "--lines", "l.%d.%d.vdb", "-o", "x.png"))

    def test_frames_without_lines_can_be_left_out(self):
        """They neither stop the others, nor choose their view."""
        self.fog(-20, -11)
        self.fog(-20, -11, "t.0.vdb")
        done = self.run_tool("vdblic_render", "t.%d.vdb", "--lines", "l.%d.vdb", "-o", "a.%d.png", "--size", 32, 24, "--keep-going")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertEqual(done.stdout.split(), ["a.2.png"])
        self.renders("t.%d.vdb", "--lines", "l.%d.vdb", "-o", "b.%d.png", "--size", 32, 24, "--frames", 2)
        self.assertEqual((self.folder / "a.2.png").read_bytes(), (self.folder / "b.2.png").read_bytes())

    def test_no_line_at_all(self):
        velocity = vdb.Vec3SGrid()
        velocity.name = "velocity"
        vdb.write(str(self.folder / "n.2.vdb"), [velocity])
        self.outputs("vdblic_advect", "n.2.vdb", "--dt", 1, "--method", "streaks", "--draw", "lines", "--spacing", 3, "-o", "e.2.vdb")
        self.fog(-20, -11)
        options = (*PLAIN, "--opacity", f"0:{OPACITY}")
        done = self.run_tool("vdblic_render", "t.2.vdb", "--lines", "e.2.vdb", "-o", "a.exr", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("no frame has a line to show", done.stderr)
        first = self.pixels("a.exr", "R", "A")
        self.renders("t.2.vdb", "-o", "b.exr", *options)
        numpy.testing.assert_array_equal(first, self.pixels("b.exr", "R", "A"))

    def test_outputs_never_replace_lines(self):
        self.fog(-20, -11)
        before = (self.folder / "l.2.vdb").read_bytes()
        self.refuses(2, "t.2.vdb", "--lines", "l.2.vdb", "-o", "a.png", "--transfer-out", "l.2.vdb")
        self.assertEqual((self.folder / "l.2.vdb").read_bytes(), before)


if __name__ == "__main__":
    import unittest

    unittest.main()
