"""Slow and quick motion, and films of a steady field."""

import re
import unittest

import numpy
import pyopenvdb as vdb

from support import ToolTest


def values(path, name):
    grid = vdb.read(str(path), name)
    low, high = grid.evalActiveVoxelBoundingBox()
    array = numpy.zeros([h - l + 1 for l, h in zip(low, high)], numpy.float32)
    grid.copyToArray(array, ijk=low)
    return array


class Motion(ToolTest):
    def write_uniform(self, speed, name="v.0007.vdb", **metadata):
        """A flow along x."""
        velocity = numpy.zeros((48, 16, 16, 3), numpy.float32)
        velocity[..., 0] = speed
        grid = vdb.Vec3SGrid()
        grid.name = "velocity"
        grid.copyFromArray(velocity, tolerance=(-1, -1, -1))
        grid.transform = vdb.createLinearTransform(0.5)
        vdb.write(str(self.folder / name), grids=[grid], metadata=metadata)

    def advect(self, *arguments):
        """The outputs and the messages of a run."""
        done = self.run_tool("vdblic_advect", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [self.folder / line for line in done.stdout.split()], done.stderr

    def test_motion_scales_paths_and_not_the_speed(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 20, 18, 16, "--frames", "1-4")
        plain, slow, scaled = (self.advect("v.%04d.vdb", "-o", f"{name}.%04d.vdb", *options)[0] for name, *options in (
            ("plain",), ("slow", "--motion", 0.5), ("scaled", "--velocity-scale", 0.5)))
        for first, second, third in zip(plain, slow, scaled):
            self.assertEqual(values(second, "density").tobytes(), values(third, "density").tobytes())
            self.assertNotEqual(values(second, "density").tobytes(), values(first, "density").tobytes())
            self.assertEqual(values(second, "magnitude").tobytes(), values(first, "magnitude").tobytes())
        self.assertEqual(vdb.readMetadata(str(slow[0]))["motion"], 0.5)
        self.assertNotIn("motion", vdb.readMetadata(str(plain[0])))

    def test_voxels_per_frame(self):
        """The factor is that of the first frame, and repeats the run when it is given."""
        for frame, speed in (1, 1.0), (2, 3.0), (3, 2.0):
            self.write_uniform(speed, f"v.{frame:04}.vdb", time=0.1 * frame)  # 0.2, 0.6, 0.4 voxels
        chosen, messages = self.advect("v.%04d.vdb", "-o", "chosen.%04d.vdb", "--voxels-per-frame", 3)
        self.assertIn("the faster half of frame 1 moves 0.2 voxels, and 3 with --motion ", messages)
        factor = float(re.search("--motion ([^ ]+),", messages)[1])
        self.assertAlmostEqual(factor * 0.2 / 3, 1, delta=0.01)
        given, messages = self.advect("v.%04d.vdb", "-o", "given.%04d.vdb", "--motion", factor)
        self.assertNotIn("--motion", messages)
        for first, second in zip(chosen, given):
            self.assertEqual(first.read_bytes(), second.read_bytes())
            self.assertEqual(vdb.readMetadata(str(first))["motion"], factor)
        again, messages = self.advect("v.%04d.vdb", "-o", "part.%04d.vdb", "--frames", "3", "--lead-in", 1,
                                      "--voxels-per-frame", 3)
        self.assertIn("of frame 2 moves 0.6 voxels", messages)
        self.assertAlmostEqual(vdb.readMetadata(str(again[0]))["motion"] * 0.6 / 3, 1, delta=0.01)
        self.assertIn("exclude each other",
                      self.fails(2, "vdblic_advect", "v.%04d.vdb", "-o", "x.%04d.vdb", "--motion", 2, "--voxels-per-frame", 3))

    def test_a_flow_at_rest_is_not_scaled(self):
        self.write_uniform(0)
        path, messages = self.advect("v.0007.vdb", "-o", "lic.vdb", "--voxels-per-frame", 3, "--dt", 1)
        self.assertIn("moves nothing", messages)
        self.assertNotIn("motion", vdb.readMetadata(str(path[0])))

    def test_coherence_follows_the_scaled_flow(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 28, 28, 28, "--frames", "1-4", "--dt", 0.003)
        self.advect("v.%04d.vdb", "-o", "lic.%04d.vdb", "--voxels-per-frame", 2)
        done = self.run_tool("vdblic_coherence", "v.%04d.vdb", "lic.%04d.vdb")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("nowhere inside does the flow move", done.stderr)

    # A steady field

    def film(self, name, *options):
        return self.advect("v.0007.vdb", "-o", f"{name}.%04d.vdb", "--dt", 0.25, *options)[0]

    def test_streaks_move_with_a_steady_flow(self):
        self.write_uniform(6.0, time=1.5)  # 3 voxels a frame
        for method in "auflic", "uflic", "auflic-2004":
            with self.subTest(method=method):
                paths = self.film(method, "--method", method, "--steady-frames", 5)
                self.assertEqual([path.name for path in paths], [f"{method}.{frame:04}.vdb" for frame in range(7, 12)])
                for i, path in enumerate(paths):
                    metadata = vdb.readMetadata(str(path))
                    expected = {"frame": 7 + i, "source_frame": 7, "time": 1.5 + 0.25 * i, "dt": 0.25}
                    self.assertEqual({key: metadata[key] for key in expected}, expected)
                # Each texture is the one before it, 3 voxels farther; the ends are where fluid enters and leaves.
                frames = [values(path, "density")[12:-12] for path in paths]
                for before, after in zip(frames, frames[1:]):
                    moved = [numpy.corrcoef(before[:-6].ravel(), after[shift:shift - 6 or None].ravel())[0, 1]
                             for shift in range(7)]
                    self.assertEqual(numpy.argmax(moved), 3, moved)
                    self.assertGreater(moved[3], 0.7)

    def test_a_steady_film_is_the_run_over_copies_of_the_frame(self):
        self.write_uniform(6.0)
        for frame in range(7, 10):
            self.write_uniform(6.0, f"copy.{frame:04}.vdb")
        for options in ((), ("--substeps", 2, "--refine", 2, 1, 1)):
            films = self.film("film", "--steady-frames", 3, *options)
            copies, _ = self.advect("copy.%04d.vdb", "-o", "by_copies.%04d.vdb", "--dt", 0.25, *options)
            self.assertEqual(len(films), len(copies))
            for film, copy in zip(films, copies):
                self.assertEqual(values(film, "density").tobytes(), values(copy, "density").tobytes())

    def test_a_frame_of_a_sequence_and_a_path(self):
        """A frame among others stands for itself; a mask is that of the frame."""
        self.outputs("vdblic_synth", "abc", "-o", "s.%04d.vdb", "--size", 16, 16, 16, "--frames", "1-5")
        mask = vdb.BoolGrid()
        mask.fill((0, 0, 0), (15, 15, 7), True)
        mask.name = "mask"
        mask.transform = vdb.createLinearTransform(0.1)
        vdb.write(str(self.folder / "m.0003.vdb"), mask)
        options = "--steady-frames", 4, "--mask", "m.%04d.vdb"
        chosen, messages = self.advect("s.%04d.vdb", "-o", "a.%04d.vdb", "--frames", 3, *options)
        self.assertNotIn("computed first", messages)
        single, _ = self.advect("s.0003.vdb", "-o", "b.%04d.vdb", *options)
        done = self.run_tool("vdblic_advect", "-", "-o", "c.%04d.vdb", *options, stdin="s.0003.vdb\n")
        piped = [self.folder / line for line in done.stdout.split()]
        self.assertEqual([path.name[2:] for path in chosen], [f"{frame:04}.vdb" for frame in range(3, 7)])
        self.assertEqual([path.read_bytes() for path in chosen], [path.read_bytes() for path in single])
        self.assertEqual([path.read_bytes() for path in chosen], [path.read_bytes() for path in piped])
        self.assertEqual(vdb.read(str(chosen[3]), "density").activeVoxelCount(), 16 * 16 * 8)

    def test_one_clear_error(self):
        self.outputs("vdblic_synth", "abc", "-o", "s.%04d.vdb", "--size", 8, 8, 8, "--frames", "1-5")
        several = self.fails(2, "vdblic_advect", "s.%04d.vdb", "-o", "o.%04d.vdb", "--steady-frames", 4)
        self.assertIn("--steady-frames 4 repeats a single frame, and there are 5 in s.%04d.vdb: name one file", several)
        piped = self.fails(2, "vdblic_advect", "-", "-o", "o.%04d.vdb", "--steady-frames", 4,
                           stdin="s.0001.vdb\ns.0002.vdb\n")
        self.assertIn("--steady-frames 4 repeats a single frame, and there are several", piped)
        lic = self.fails(2, "vdblic_advect", "s.0001.vdb", "-o", "o.%04d.vdb", "--steady-frames", 4, "--method", "lic")
        self.assertIn("the same texture in every frame with --method lic", lic)
        self.assertIn("names one file but there are more frames",
                      self.fails(2, "vdblic_advect", "s.0001.vdb", "-o", "o.vdb", "--steady-frames", 4))
        for message in several, piped, lic:
            self.assertEqual(len(message.splitlines()), 1, message)


if __name__ == "__main__":
    unittest.main()
