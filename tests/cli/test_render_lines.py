"""vdblic_render and vdblic_film draw lines."""

import numpy
import pyopenvdb as vdb

from support import RenderTest


class RenderLines(RenderTest):
    def setUp(self):
        super().setUp()
        self.flow()

    def flow(self, heat=1.0):
        """Air that turns about the axis z, 12 frames of a second in 24³ voxels, and a scalar."""
        place = numpy.indices((24, 24, 24)).transpose(1, 2, 3, 0) - 11.5
        velocity = vdb.Vec3SGrid()
        velocity.name = "velocity"
        velocity.copyFromArray((numpy.stack([-place[..., 1], place[..., 0], 0 * place[..., 0]], -1) * 0.1).astype(numpy.float32))
        scalar = vdb.FloatGrid()
        scalar.name = "heat"
        scalar.copyFromArray((place[..., 0] * heat).astype(numpy.float32))
        for frame in range(1, 4):
            vdb.write(str(self.folder / f"v.{frame}.vdb"), [velocity, scalar])

    def lines(self, *arguments, output="l.%d.vdb"):
        return self.outputs("vdblic_advect", "v.%d.vdb", "--dt", 1, "--method", "streaks", "--draw", "lines", "--spacing", 3,
                            "--carry", "heat", *arguments, "-o", output)

    def test_lines_are_what_is_shown(self):
        """Also beside scalars: colour, opacity and their units come from the points."""
        self.lines()
        self.renders("l.%d.vdb", "-o", "speed.%d.exr", "--size", 160, 90)
        alpha, red = self.pixels("speed.2.exr", "A", "R")
        self.assertTrue(0.05 < (alpha > 0.1).mean() < 0.95)
        self.renders("l.2.vdb", "-o", "heat.exr", "--size", 160, 90, "--by", "heat", "--range", 0, 12, "--aov", "depth,normal,magnitude,samples")
        warm = self.pixels("heat.exr", "A")[0]
        self.assertTrue(0 < (warm > 0).mean() < (alpha > 0).mean())
        depth, heat, samples = self.pixels("heat.exr", "Z", "magnitude", "samples")
        shown = warm > 0
        self.assertTrue((heat[shown] > 0).all() and numpy.isfinite(depth[shown]).all() and (samples[shown] >= 1).all())

    def test_any_number_of_threads_draws_the_same_pixels(self):
        self.lines()
        pictures = []
        for threads in (1, 2, 5):
            self.renders("l.2.vdb", "-o", f"t{threads}.exr", "--size", 200, 120, "--samples", 4, "--threads", threads, "--ground",
                         "below", "--solid", "domain", "--aov", "depth,normal")
            pictures.append(numpy.stack(self.pixels(f"t{threads}.exr", "R", "G", "B", "A", "Z")))
        for picture in pictures[1:]:
            numpy.testing.assert_array_equal(picture, pictures[0])

    def test_two_scalars(self):
        self.lines("--with", "q")
        for options in (("--opacity-by", "heat"), ("--color-by", "age", "--opacity-by", "magnitude"), ("--by", "q"),
                        ("--color-scale", "log"), ("--look", "vortex")):
            with self.subTest(options):
                self.renders("l.2.vdb", "-o", "a.exr", "--size", 80, 60, *options)
                self.assertTrue((self.pixels("a.exr", "A")[0] > 0).any())

    def test_cuts(self):
        self.lines()
        whole = self.shown()
        for options in (("--roi-box", 0, 0, 0, 11, 23, 23), ("--clip-box", 0, 0, 0, 11, 23, 23), ("--clip-plane", 11, 11, 11, 1, 0, 0)):
            with self.subTest(options):
                self.assertLess(self.shown(*options), 0.8 * whole)
        told = self.run_tool("vdblic_render", "l.2.vdb", "-o", "a.exr", "--size", 80, 60, "--clip-box", 90, 90, 90, 91, 91, 91)
        self.assertIn("cut everything away", told.stderr)

    def shown(self, *options):
        self.renders("l.2.vdb", "-o", "a.exr", "--size", 80, 60, "--eye", 11, 11, 80, "--target", 11, 11, 11, "--up", 0, 1, 0, *options)
        return (self.pixels("a.exr", "A")[0] > 0).sum()

    def test_what_cannot_be_is_told(self):
        self.lines()
        told = self.refuses(3, "l.2.vdb", "-o", "a.png", "--by", "q")
        for part in ("l.2.vdb", "no scalar 'q'", "heat", "--with q"):
            self.assertIn(part, told)
        told = self.fails(2, "vdblic_advect", "v.%d.vdb", "--dt", 1, "--draw", "lines", "-o", "a.%d.vdb")
        self.assertIn("`draw`", told.replace("--draw", "`draw`"))
        for option in (("--scalars", "texture"), ("--texture-name", "mine")):
            self.fails(2, "vdblic_advect", "v.%d.vdb", "--dt", 1, "--method", "streaks", "--draw", "lines", *option, "-o", "a.%d.vdb")

    def test_a_scalar_without_a_value(self):
        """Lines are left out where there is none, and that is said."""
        self.flow(heat=numpy.nan)
        self.lines(output="n.%d.vdb")
        told = self.run_tool("vdblic_render", "n.2.vdb", "-o", "a.png", "--by", "heat", "--size", 80, 60)
        self.assertEqual(told.returncode, 0)
        for part in ("n.2.vdb", "not finite", "nothing to see"):
            self.assertIn(part, told.stderr)

    def test_air_at_rest(self):
        """Its lines are dots, which no speed makes visible; age does."""
        velocity = vdb.Vec3SGrid()
        velocity.name = "velocity"
        velocity.copyFromArray(numpy.full((16, 16, 16, 3), 1e-30, numpy.float32))
        vdb.write(str(self.folder / "v.1.vdb"), [velocity])
        self.outputs("vdblic_advect", "v.1.vdb", "--dt", 1, "--method", "streaks", "--draw", "lines", "--spacing", 3, "-o", "r.1.vdb")
        done = self.run_tool("vdblic_render", "r.1.vdb", "-o", "a.png", "--size", 80, 60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("show nothing", done.stderr)
        self.renders("r.1.vdb", "-o", "b.exr", "--size", 80, 60, "--by", "age", "--opacity", "0:1,1:1")
        self.assertTrue((self.pixels("b.exr", "A")[0] > 0).any())

    def test_no_air_at_all(self):
        velocity = vdb.Vec3SGrid()
        velocity.name = "velocity"
        vdb.write(str(self.folder / "v.1.vdb"), [velocity])
        for form in "voxels", "lines":
            with self.subTest(form):
                self.outputs("vdblic_advect", "v.1.vdb", "--dt", 1, "--method", "streaks", "--draw", form, "--spacing", 3, "-o", "e.1.vdb")
                done = self.run_tool("vdblic_render", "e.1.vdb", "-o", "a.png", "--size", 80, 60)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("nothing to see", done.stderr)

    def test_frames_share_a_view(self):
        """And a histogram beside a picture does not change it."""
        self.lines()
        self.renders("l.%d.vdb", "-o", "a.%d.exr", "--size", 80, 60)
        self.renders("l.%d.vdb", "-o", "b.%d.exr", "--size", 80, 60, "--histogram", "h.json")
        for frame in (1, 2, 3):
            numpy.testing.assert_array_equal(*(numpy.stack(self.pixels(f"{name}.{frame}.exr", "R", "A")) for name in "ab"))

    def test_a_film_shows_lines(self):
        self.outputs("vdblic_film", "v.%d.vdb", "-o", "film.png", "--size", 160, 90, "--method", "streaks")
        self.assertTrue((self.folder / "film.png").exists())


if __name__ == "__main__":
    import unittest

    unittest.main()
