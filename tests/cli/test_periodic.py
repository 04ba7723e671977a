"""vdblic_advect --periodic: what leaves a box on one side enters on the other, without a seam."""

import json
import unittest

import numpy
import pyopenvdb as vdb

import python_module  # pylint: disable=unused-import
from support import ToolTest

from vdblic._core import read_lines

SIZE = 32
ALL = "--periodic", "x,y,z"
SCATTER, BACKWARD = ("auflic", "auflic-2004", "uflic"), ("ibfv", "lea", "ufac", "lic")


class Periodic(ToolTest):
    def write(self, name, velocity, noise=None):
        """A velocity in voxels a second."""
        grids = [vdb.Vec3SGrid()]
        grids[0].name = "velocity"
        grids[0].copyFromArray(numpy.ascontiguousarray(velocity, numpy.float32))
        if noise is not None:
            grids.append(vdb.FloatGrid())
            grids[1].name = "noise"
            grids[1].copyFromArray(numpy.ascontiguousarray(noise, numpy.float32))
        vdb.write(str(self.folder / name), grids)

    def abc(self, shift=0, frames=4, more=0):
        """An ABC flow of about two voxels a frame whose phase moves, as one period and `more` layers that repeat the first
        ones; shifted by so many voxels."""
        for frame in range(1, frames + 1):
            turn = 2 * numpy.pi * (numpy.indices((SIZE + more,) * 3) - shift + 0.3 * frame) / SIZE
            (x, y, z), (p, q, r) = numpy.sin(turn), numpy.cos(turn)
            velocity = numpy.stack([1.7 * z + q, 1.4 * x + 1.7 * r, y + 1.4 * p], axis=-1)
            self.write(f"abc{shift}.{frame:04}.vdb", velocity)
        return f"abc{shift}.%04d.vdb", "--dt", 1

    def uniform(self, shift, velocity=(1.25, -2.5, 0.75), steady=3):
        """A uniform flow, and noise, shifted. All positions along its paths are exact."""
        noise = numpy.random.default_rng(5).random((SIZE,) * 3)
        self.write(f"u{shift}.vdb", numpy.broadcast_to(velocity, (SIZE,) * 3 + (3,)), numpy.roll(noise, shift, (0, 1, 2)))
        return f"u{shift}.vdb", "--dt", 1, "--noise", f"u{shift}.vdb:noise", *(("--steady-frames", steady) if steady else ())

    def advect(self, *arguments, output="t.%04d.vdb", **options):
        return self.outputs("vdblic_advect", *arguments, "-o", output, **options)

    def values(self, path, name="density", factor=1):
        array = numpy.zeros((SIZE * factor,) * 3, numpy.float32)
        vdb.read(str(path), name).copyToArray(array)
        return array

    def measured(self, velocity, pattern):
        self.outputs("vdblic_coherence", velocity, pattern, "--dt", 1, "--json", "m.json")
        return json.loads((self.folder / "m.json").read_text())

    def seams(self, texture):
        """For each axis, how much neighbours across the seam differ, as a multiple of what other neighbours do."""
        means = (numpy.abs(texture - numpy.roll(texture, 1, axis)).mean(axis=tuple({0, 1, 2} - {axis})) for axis in range(3))
        return [steps[0] / steps[1:].mean() for steps in means]

    def test_shifted_noise_gives_the_shifted_texture(self):
        """To the bit, but for the methods whose particles take turns by their place of release."""
        for method in *SCATTER, *BACKWARD:
            with self.subTest(method):
                textures = []
                for shift in 0, SIZE // 2:
                    flow = self.uniform(shift, steady=None if method == "lic" else 3)
                    path = self.advect(*flow, "--method", method, *ALL, "--precision", "float", output=f"{method}.%04d.vdb")[-1]
                    textures.append(numpy.roll(self.values(path), -shift, (0, 1, 2)))
                if method.startswith("auflic"):
                    self.assertGreater(numpy.corrcoef(textures[0].ravel(), textures[1].ravel())[0, 1], 0.9)
                else:
                    numpy.testing.assert_array_equal(*textures)

    def test_a_shifted_flow_gives_as_good_a_texture(self):
        measures = []
        for shift in 0, SIZE // 2:
            velocity, *options = self.abc(shift)
            self.advect(velocity, *options, *ALL)
            measures.append(self.measured(velocity, "t.%04d.vdb"))
        one, other = (found["mean"] for found in measures)
        for kind in "raw", "smoothed":
            for name in "temporal", "same_place", "gain", "along_length", "across_length", "deviation":
                ratio = other[kind][name]["mean"] / one[kind][name]["mean"]
                self.assertAlmostEqual(ratio, 1, delta=0.05, msg=(kind, name))

    def test_no_seam(self):
        """Neighbours across the seam differ as much as others; without --periodic they are strangers."""
        flow = self.abc()
        for method in *SCATTER, *BACKWARD:
            for options, least, most in (ALL, 0.85, 1.15), ((), 1.25, 3):
                seams = self.seams(self.values(self.advect(*flow, "--method", method, *options)[-1]))
                self.assertTrue(least < min(seams) and max(seams) < most, (method, options, seams))

    def test_other_axes_stay_open(self):
        flow = self.abc()
        seams = self.seams(self.values(self.advect(*flow, "--periodic", "y")[-1]))
        self.assertTrue(seams[1] < 1.15 and min(seams[0], seams[2]) > 1.25, seams)

    def test_a_channel_with_a_body(self):
        """Open voxels beside solid ones at the seam."""
        velocity = numpy.zeros((SIZE, 24, 16, 3))
        velocity[:, 3:21] = 3, 0.5, -0.25
        velocity[SIZE - 6:, 9:14, 4:9] = velocity[:5, 9:14, 4:9] = 0
        grid = vdb.Vec3SGrid()
        grid.name = "velocity"
        grid.copyFromArray(velocity.astype(numpy.float32))
        vdb.write(str(self.folder / "c.vdb"), grid)
        for method in *SCATTER, "ibfv", "lea", "streaks":
            one, many = (self.advect("c.vdb", "--dt", 1, "--steady-frames", 4, "--periodic", "x,z", "--method", method,
                                     "--threads", threads, output=f"t{threads}.%04d.vdb") for threads in (1, 5))
            self.assertEqual([path.read_bytes() for path in one], [path.read_bytes() for path in many])
        message = self.fails(3, "vdblic_advect", "c.vdb", "-o", "t.vdb", *ALL)
        self.assertIn("along y its 18 voxels, 3 to 20, cannot be --periodic", message)

    def test_small_periods_and_long_ways(self):
        """A step goes around the box more than once."""
        place = 2 * numpy.pi * numpy.indices((8, 16, 40)) / numpy.reshape((8, 16, 40), (3, 1, 1, 1))
        velocity = numpy.stack([30 + 5 * numpy.sin(place[1]), 4 * numpy.cos(place[2]), 50 + numpy.sin(place[0])], axis=-1)
        self.write("v.vdb", velocity)
        for method in *SCATTER, *BACKWARD, "streaks":
            steady = () if method == "lic" else ("--steady-frames", 4)
            one, many = (self.advect("v.vdb", "--dt", 1, *steady, *ALL, "--method", method, "--life", 2, "--threads", threads,
                                     output=f"t{threads}.%04d.vdb") for threads in (1, 5))
            self.assertEqual([path.read_bytes() for path in one], [path.read_bytes() for path in many])

    def test_threads_and_interruptions_change_no_byte(self):
        flow = self.abc()
        cases = [(method,) for method in (*SCATTER, "ibfv", "lea", "lic")]
        cases += [("auflic", "--substeps", 2, "--refine", "2,1,2"), ("auflic", "--refine", 2, "--interpolation", "cubic"),
                  ("streaks", "--substeps", 2, "--spacing", 3), ("streaks", "--draw", "lines")]
        for method, *options in cases:
            arguments = *flow, "--method", method, *options, *ALL, "--with", "q"
            one = self.advect(*arguments, "--threads", 1, output="one.%04d.vdb")
            for threads in 2, 5:
                for path, other in zip(one, self.advect(*arguments, "--threads", threads, output="many.%04d.vdb")):
                    self.assertEqual(path.read_bytes(), other.read_bytes(), (method, options, threads))
            self.advect(*arguments, "--frames", "1-2", "--keep-checkpoint", output="on.%04d.vdb")
            on = self.advect(*arguments, "--frames", "1-4", "--resume", "--threads", 2, output="on.%04d.vdb")
            self.assertEqual([path.read_bytes() for path in on], [path.read_bytes() for path in one], (method, options))

    def test_a_repeated_layer_is_left_out(self):
        """Values of the velocity outside the box have no influence."""
        self.abc(shift=0)
        self.abc(shift=SIZE, more=1)  # the same flow
        for options in (), ("--refine", 2, "--interpolation", "cubic"), ("--method", "streaks", "--spacing", 3):
            one = self.advect("abc0.%04d.vdb", "--dt", 1, *ALL, *options, "--frames", "1-2", output="a.%04d.vdb")
            box = "--bbox", 0, 0, 0, *(SIZE - 1,) * 3
            other = self.advect(f"abc{SIZE}.%04d.vdb", "--dt", 1, *ALL, *box, *options, "--frames", "1-2", output="b.%04d.vdb")
            for path, same in zip(one, other):
                self.outputs("vdblic_diff", path, same)

    def test_vorticity_is_that_of_the_whole_flow(self):
        place = 2 * numpy.pi * numpy.indices((SIZE,) * 3) / SIZE
        velocity = numpy.zeros((SIZE,) * 3 + (3,))
        velocity[..., 2] = 2 + numpy.sin(place[0])  # a vector of zeros would be no voxel
        self.write("v.vdb", velocity)
        found = self.values(self.advect("v.vdb", "--dt", 1, *ALL, "--with", "vorticity", "--precision", "float",
                                        output="w.vdb")[0], "vorticity")
        exact = numpy.sin(2 * numpy.pi / SIZE) * numpy.abs(numpy.cos(place[0]))
        numpy.testing.assert_allclose(found, exact, atol=1e-5)

    def streaks(self, *arguments, output="s.%04d.vdb"):
        paths = self.advect(*arguments, "--method", "streaks", "--draw", "lines", "--spacing", 4, "--tail", 5, output=output)
        return [read_lines(path)[0] for path in paths]

    def test_streaks_never_end_in_a_uniform_flow(self):
        velocity = 1.25, -2.5, 0.75
        self.write("v.vdb", numpy.broadcast_to(velocity, (SIZE,) * 3 + (3,)))
        found = self.streaks("v.vdb", "--dt", 1, "--steady-frames", 30, *ALL)
        heads = []
        for lines in found:
            points, ends = lines["points"], numpy.cumsum(lines["counts"])
            self.assertTrue(((points > -0.501) & (points < SIZE - 0.499)).all())
            is_head = lines["age"][ends - 1] == 0
            heads.append(dict(zip(lines["id"][is_head].tolist(), points[ends - 1][is_head])))
            steps = numpy.linalg.norm(numpy.diff(points, axis=0), axis=1)
            steps[ends[:-1] - 1] = 0
            # Cut at seams, the parts of a tail are together as long as the way, but for its invisible end.
            self.assertAlmostEqual(steps.sum() / len(heads[-1]) / (5 * numpy.linalg.norm(velocity)), 0.96, delta=0.03)
        self.assertLessEqual(set(heads[0]), set(heads[-1]))  # gaps were filled
        for name, place in heads[0].items():
            way = heads[-1][name] - place - 29 * numpy.array(velocity)
            numpy.testing.assert_allclose(way, SIZE * numpy.round(way / SIZE), atol=0.01)

    def test_streaks_keep_their_distance_across_the_seam(self):
        """Those too close together are on their way out; in an open box strangers are close across the seam."""
        close = {}
        for options in ALL, ():
            lines = self.streaks(*self.abc(frames=6), *options)[-1]
            ends = numpy.cumsum(lines["counts"])
            heads = lines["points"][ends - 1][lines["age"][ends - 1] == 0]
            apart = heads[:, None] - heads[None]
            apart -= SIZE * numpy.round(apart / SIZE)
            nearest = numpy.sort(numpy.linalg.norm(apart, axis=2), axis=1)[:, 1]
            close[options] = (nearest < 0.45 * 4).sum()
            if options:
                density = numpy.histogram(heads, SIZE // 4, (-0.5, SIZE - 0.5))[0]
                self.assertLess(numpy.ptp(density), 0.25 * density.mean())
        self.assertLess(close[ALL], 0.7 * close[()])

    def test_streaks_of_voxels_have_no_seam(self):
        texture = self.values(self.advect(*self.abc(), "--method", "streaks", "--spacing", 4, "--refine", 2, *ALL)[-1], factor=2)
        seams = self.seams(texture)
        self.assertTrue(0.8 < min(seams) and max(seams) < 1.2, seams)

    def test_mistakes(self):
        self.abc(frames=1, more=1)
        for status, words, *options in (
                (3, "along x its 33 voxels, 0 to 32, cannot be --periodic", *ALL),
                (2, "--periodic has the axis x twice", "--periodic", "x,y,x"),
                (2, "--periodic and an observer who moves exclude each other", *ALL, "--frame-velocity", "1", "0", "0"),
                (2, "--periodic cannot be w; it is one of x, y, z", "--periodic", "w")):
            message = self.fails(status, "vdblic_advect", "abc0.0001.vdb", "-o", "t.vdb", *options)
            self.assertIn(words, message)
        self.abc(frames=2)
        velocity = numpy.ones((24, SIZE, SIZE, 3))
        self.write("abc0.0002.vdb", velocity)
        message = self.fails(3, "vdblic_advect", "abc0.%04d.vdb", "-o", "t.%04d.vdb", *ALL)
        self.assertRegex(message, r"abc0.0002.vdb: grid velocity: the active voxels end elsewhere than in the frames before")


if __name__ == "__main__":
    unittest.main()
