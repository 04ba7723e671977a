"""Observers who move: --frame-velocity and --frame-rotation of vdblic_advect, vdblic_coherence and vdblic_film."""

import json
import re
import unittest

import numpy
import pyopenvdb as vdb

import python_module  # pylint: disable=unused-import
from support import WAKE, ToolTest

from vdblic._core import read_lines

VOXEL, DT = 0.5, 0.25
SHIFT = numpy.array([3, -2, 1])  # voxels a frame
U = SHIFT * VOXEL / DT
FRAMES = (1, 2, 3, 4)


def grid_of(path, name):
    """Values, first voxel and transform (its columns and origin) of a grid."""
    grid = vdb.read(str(path), name)
    low, high = grid.evalActiveVoxelBoundingBox()
    array = numpy.full([h - l + 1 for l, h in zip(low, high)] + ([3] if "vec3" in grid.valueTypeName else []), numpy.nan,
                       numpy.float32)
    grid.copyToArray(array, ijk=low)
    corner = [grid.transform.indexToWorld(at) for at in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))]
    return array, numpy.array(low), numpy.array(corner)


class Observer(ToolTest):
    def write(self, frame, velocity, first=(0, 0, 0), name="v", voxel=VOXEL, timed=True, carry=None):
        grid = vdb.Vec3SGrid()
        grid.name = "velocity"
        grid.copyFromArray(numpy.ascontiguousarray(velocity, numpy.float32), ijk=first, tolerance=(-1, -1, -1))
        grids = [grid]
        if carry is not None:
            heat = vdb.FloatGrid()
            heat.name = "heat"
            heat.copyFromArray(numpy.ascontiguousarray(carry, numpy.float32), ijk=first, tolerance=-1)
            grids.append(heat)
        for one in grids:
            one.transform = vdb.createLinearTransform(voxel)
        metadata = {"time": 10 + DT * (frame - 1), "dt": DT} if timed else {}
        vdb.write(str(self.folder / f"{name}.{frame:04}.vdb"), grids=grids, metadata=metadata)

    def uniform(self, speed=(3, -1, 0.5), frames=FRAMES, **how):
        for frame in frames:
            self.write(frame, numpy.broadcast_to(speed, (24, 18, 16, 3)), **how)

    def unsteady(self):
        """A flow at rest, "rest", and the same carried along by U, "moving"; all sums are exact in single precision."""
        place = numpy.indices((26, 18, 22)).transpose(1, 2, 3, 0) * 0.4
        for frame in FRAMES:
            x, y, z = numpy.moveaxis(place + 0.3 * frame, 3, 0)
            flow = numpy.stack([numpy.sin(z) + numpy.cos(y), numpy.sin(x) + numpy.cos(z), numpy.sin(y) + numpy.cos(x)], axis=-1)
            flow = numpy.round(flow * 2**12) / 2**12
            self.write(frame, flow, name="rest", carry=x)
            self.write(frame, flow + U, first=tuple(int(i) for i in SHIFT * (frame - 1)), name="moving", carry=x)

    def advect(self, pattern, output, *options):
        return self.outputs("vdblic_advect", f"{pattern}.%04d.vdb", "-o", f"{output}.%04d.vdb", *options)

    def assert_same_bytes(self, first, second):
        self.assertEqual(len(first), len(second))
        for a, b in zip(first, second):
            self.assertEqual(a.read_bytes(), b.read_bytes(), b.name)

    def assert_same_grids(self, first, second, names, moved=None):
        """@param moved  world-space way of each of the second files; None: its transform is that of the first"""
        for i, (a, b) in enumerate(zip(first, second, strict=True)):
            for name in names:
                one, other = grid_of(a, name), grid_of(b, name)
                self.assertEqual(one[0].tobytes(), other[0].tobytes(), (b.name, name))
                numpy.testing.assert_array_equal(one[1], other[1])
                numpy.testing.assert_allclose(other[2] - one[2], 0 if moved is None else numpy.tile(moved[i], (4, 1)), atol=1e-12)

    def test_a_uniform_flow_seen_from_itself_is_at_rest(self):
        self.uniform()
        for velocity in (3, -1, 0.5), ("mean",):
            done = self.run_tool("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--frame-velocity", *velocity)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("moves nothing", done.stderr)
            if velocity == ("mean",):
                self.assertIn("mean velocity of frame 1: --frame-velocity 3 -1 0.5", done.stderr)
            for line in done.stdout.split():
                self.assertEqual(abs(grid_of(self.folder / line, "magnitude")[0]).max(), 0)
                self.assertEqual(vdb.readMetadata(str(self.folder / line))["frame_velocity"], (3, -1, 0.5))

    def test_whole_voxels_a_frame_are_the_flow_at_rest(self):
        """Equal to the bit, with the transform of the flow at rest, or moved along."""
        self.unsteady()
        options = "--frame-velocity", *U
        for method, more, names in (
                ("auflic", ("--refine", 2, "--substeps", 2, "--with", "vorticity,q"), ("density", "magnitude", "vorticity", "q")),
                ("auflic", ("--with", "velocity", "--scalars", "texture"), ("density", "vel")),
                ("ibfv", ("--substeps", 2), ("density",)), ("lea", (), ("density",)), ("ufac", (), ("density",)),
                ("streaks", ("--spacing", 3, "--substeps", 2), ("density", "magnitude"))):
            with self.subTest(method=method, more=more):
                rest = self.advect("rest", "rest_lic", "--method", method, *more)
                stays = self.advect("moving", "stays", "--method", method, *more, *options, "--stay")
                self.assert_same_grids(rest, stays, names)
                moves = self.advect("moving", "moves", "--method", method, *more, *options)
                step = 1 / 2 if "--substeps" in more else 1
                self.assert_same_grids(rest, moves, [name for name in names if name != "vel"],
                                       [U * DT * step * i for i in range(len(rest))])
                if "vel" in names:
                    for a, b in zip(rest, moves):
                        numpy.testing.assert_allclose(grid_of(b, "vel")[0], grid_of(a, "vel")[0] + U, atol=0.005)

    def test_lines_of_whole_voxels_a_frame(self):
        self.unsteady()
        options = "--method", "streaks", "--draw", "lines", "--spacing", 3, "--carry", "heat"
        rest = self.advect("rest", "rest_l", *options)
        moves = self.advect("moving", "moves", *options, "--frame-velocity", *U)
        for frame, (a, b) in enumerate(zip(rest, moves)):
            one, other = read_lines(a)[0], read_lines(b)[0]
            self.assertGreater(len(one["counts"]), 20)
            numpy.testing.assert_array_equal(one["counts"], other["counts"])
            numpy.testing.assert_allclose(other["points"] - one["points"], numpy.tile(U * DT * frame, (len(one["points"]), 1)),
                                          atol=1e-5)
            for name in "magnitude", "heat":
                numpy.testing.assert_array_equal(one["scalars"][name], other["scalars"][name])

    def vortex(self, centre, place, speed):
        """Lamb and Oseen's vortex about z, carried along x."""
        x, y = place[..., 0] - centre, place[..., 1]
        square = x**2 + y**2 + 1e-12
        turn = 60 * (1 - numpy.exp(-square / 9)) / square
        return numpy.stack([speed - turn * y, turn * x, 0 * x], axis=-1)

    def test_a_carried_vortex_shows_closed_loops(self):
        """Its streaks are circles for the observer who moves along, and no circles in the world."""
        speed, frames = 10.3, range(1, 9)
        place = numpy.indices((96, 48, 8)).transpose(1, 2, 3, 0) * VOXEL - numpy.array([12, 12, 0])
        for frame in frames:
            self.write(frame, self.vortex(speed * DT * (frame - 1), place, speed))
        spread = {}
        for name, options in ("rest", ()), ("seen", ("--frame-velocity", speed, 0, 0)):
            path = self.advect("v", name, "--method", "streaks", "--draw", "lines", "--spacing", 2, "--tail", 6, *options)[-1]
            lines = read_lines(path)[0]
            centre = 12 + speed * DT * (len(frames) - 1), 12
            spreads, turns = [], []
            for count, end in zip(lines["counts"], numpy.cumsum(lines["counts"])):
                at = lines["points"][end - count:end, :2] - numpy.array(centre)
                radius = numpy.hypot(*at.T)
                if 1 < radius.min() and radius[-1] < 4 and count > 5:
                    spreads.append(numpy.ptp(radius) / radius.mean())
                    turns.append(numpy.ptp(numpy.unwrap(numpy.arctan2(at[:, 1], at[:, 0]))))
            self.assertGreater(len(spreads), 5, name)
            spread[name] = numpy.median(spreads), max(turns)
        self.assertLess(spread["seen"][0], 0.05)
        self.assertGreater(spread["seen"][1], 2 * numpy.pi)
        self.assertGreater(spread["rest"][0], 0.2)

    def test_a_turning_observer_sees_a_rigid_rotation_at_rest(self):
        rpm, axis, point = 6, numpy.array([1, 2, 2]), numpy.array([3, 4, 5])
        spin = axis / 3 * rpm * 2 * numpy.pi / 60
        place = numpy.indices((26, 22, 20)).transpose(1, 2, 3, 0) * VOXEL
        for frame in FRAMES:
            self.write(frame, numpy.cross(spin, place - point))
        options = "--frame-rotation", rpm, "--frame-axis", *axis, "--frame-point", *point, "--precision", "float"
        moves, stays = self.advect("v", "moves", *options), self.advect("v", "stays", *options, "--stay")
        angle = rpm / 60 * 2 * numpy.pi * DT
        for frame, (a, b) in enumerate(zip(moves, stays)):
            speed, low, corners = grid_of(a, "magnitude")
            inside = vdb.read(str(a), "magnitude")
            index = numpy.indices(speed.shape).reshape(3, -1).T + low
            world = corners[0] + index @ (corners[1:] - corners[0])
            deep = ((world > 1) & (world < numpy.array([26, 22, 20]) * VOXEL - 1.5)).all(axis=1)
            self.assertGreater(deep.sum(), 1000)
            self.assertLess(speed.ravel()[deep].max(), 1e-5)
            active = numpy.array([item["min"] for item in inside.citerOnValues()]) @ (corners[1:] - corners[0]) + corners[0]
            self.assertTrue(((active > -VOXEL) & (active < numpy.array([26, 22, 20]) * VOXEL)).all())
            self.assertAlmostEqual(len(active) / place[..., 0].size, 1, delta=0.05)
            # The voxel's axes turned, and the same voxels where they stay.
            turned = (corners[1] - corners[0]) / VOXEL
            along = axis / 3 * (axis[0] / 3)
            self.assertAlmostEqual(turned @ numpy.array([1, 0, 0]) - along[0], (1 - along[0]) * numpy.cos(angle * frame), places=9)
            other = grid_of(b, "magnitude")
            self.assertEqual(speed.tobytes(), other[0].tobytes())
            numpy.testing.assert_allclose(other[2][1:] - other[2][0], numpy.eye(3) * VOXEL, atol=1e-12)

    def test_velocity_for_motion_blur_is_that_of_the_space_it_is_in(self):
        rpm, place = 6, numpy.indices((20, 22, 8)).transpose(1, 2, 3, 0) * VOXEL
        flow = numpy.stack([1 + 0.2 * place[..., 1], 0.1 * place[..., 0], 0.3 + 0 * place[..., 0]], axis=-1)
        for frame in (1, 2):
            self.write(frame, flow)
        path = self.advect("v", "lic", "--frame-velocity", 0.4, 0, 0, "--frame-rotation", rpm, "--with", "velocity")[1]
        found, low, corners = grid_of(path, "vel")
        world = corners[0] + (numpy.indices(found.shape[:3]).reshape(3, -1).T + low) @ (corners[1:] - corners[0])
        deep = ((world > 1) & (world < numpy.array([20, 22, 8]) * VOXEL - 1.5)).all(axis=1)
        self.assertGreater(deep.sum(), 100)
        x, y, _ = world[deep].T
        numpy.testing.assert_allclose(found.reshape(-1, 3)[deep], numpy.stack([1 + 0.2 * y, 0.1 * x, 0.3 + 0 * x], axis=-1),
                                      atol=0.01)

    def test_coherence_is_as_high_as_at_rest(self):
        """The measure knows the observer from the textures."""
        figures = {}
        for name, options in ("rest", ()), ("mean", ("--frame-velocity", "mean")), ("stays", ("--frame-velocity", "mean", "--stay")):
            self.outputs("vdblic_advect", WAKE, "--frames", "1-5", "-o", f"{name}.%04d.vdb", *options)
            self.outputs("vdblic_coherence", WAKE, "--frames", "1-5", f"{name}.%04d.vdb", "--json", f"{name}.json")
            figures[name] = json.loads((self.folder / f"{name}.json").read_text())["mean"]["smoothed"]["temporal"]["mean"]
        self.assertGreater(figures["rest"], 0.8)
        self.assertGreater(figures["mean"], figures["rest"] - 0.02)
        self.assertAlmostEqual(figures["stays"], figures["mean"])

    def test_any_number_of_threads_a_resumed_run_and_a_part_give_the_same_bytes(self):
        self.unsteady()
        for options in (("--frame-velocity", "mean", "--substeps", 2), ("--frame-velocity", "mean", "--refine", 2),
                        ("--frame-velocity", 1, 2.1, 0.3, "--frame-rotation", 3, "--frame-axis", 1, 1, 0, "--method", "streaks", "--spacing", 3),
                        ("--frame-velocity", 0.7, 0, 0, "--method", "streaks", "--draw", "lines", "--spacing", 3)):
            with self.subTest(options=options):
                whole = self.advect("moving", "whole", *options, "--threads", 1)
                for threads in 2, 5:
                    self.assert_same_bytes(whole, self.advect("moving", "other", *options, "--threads", threads))
                self.advect("moving", "resumed", *options, "--frames", "1-2", "--keep-checkpoint")
                self.assert_same_bytes(whole, self.advect("moving", "resumed", *options, "--resume"))
                if "--substeps" in options:
                    continue  # a part has numbers of its own
                part = self.advect("moving", "part", *options, "--frames", "3-4", "--lead-in", 9)
                self.assert_same_bytes(whole[-len(part):], part)

    def test_times(self):
        """By the files' times, their dt, or --dt, from the first frame on disk; the unit may be of a frame."""
        self.uniform((2, 0, 0), frames=(5, 7, 9))
        for frame in 5, 7, 9:
            self.uniform((0.5, 0, 0), frames=(frame,), name="of_frame", timed=False)
        for name, frames, options, seconds in (
                ("v", "5,7,9", (), (0, 0.5, 1)), ("v", "7-9x2", ("--lead-in", 0), (0.5, 1)), ("v", "5-9x4", (), (0, 1)),
                ("v", "5,7,9", ("--dt", 2), (0, 2, 4)),
                ("of_frame", "7,9", ("--lead-in", 0, "--dt", 0.25, "--velocity-unit", "world/frame"), (0.25, 0.5)),
                ("of_frame", "5,7", ("--dt", 0.25, "--velocity-unit", "voxel/frame"), (0, 0.25))):
            with self.subTest(name=name, frames=frames, options=options):
                paths = self.advect(name, "lic", "--frames", frames, "--frame-velocity", 1, 0, 0, *options)
                for path, time in zip(paths, seconds, strict=True):
                    speed, _, corners = grid_of(path, "magnitude")
                    self.assertAlmostEqual(corners[0][0], time)
                    expected = {"v": 2, "of_frame": 0.5 / 0.25 * (0.5 if "voxel/frame" in options else 1)}[name] - 1
                    self.assertEqual(abs(speed - expected).max(), 0)

    def test_a_steady_field_passes_the_observer(self):
        self.uniform((4, 2, 0), frames=(3,))
        paths = self.outputs("vdblic_advect", "v.0003.vdb", "-o", "lic.%04d.vdb", "--frame-velocity", 4, 0, 0, "--steady-frames", 3, "--stay")
        for frame, path in enumerate(paths):  # 2 voxels a frame
            _, low, corners = grid_of(path, "density")
            numpy.testing.assert_array_equal(low, [-2 * frame, 0, 0])
            numpy.testing.assert_allclose(corners[0], 0, atol=1e-12)

    def test_what_is_given_in_the_world_stays_there(self):
        """Boxes, masks, sources of streaks and carried grids."""
        place = numpy.indices((24, 18, 16))[0]
        for frame in FRAMES:
            self.write(frame, numpy.broadcast_to((2, 3, 0), (24, 18, 16, 3)), carry=place)
        options = "--frame-velocity", 2.7, 0, 0
        for path in self.advect("v", "lic", *options, "--bbox-world", 2, 0, 0, 6, 9, 9, "--carry", "heat"):
            density, low, corners = grid_of(path, "density")
            ends = [corners[0][0] + VOXEL * at for at in (low[0], low[0] + density.shape[0] - 1)]
            self.assertTrue(2 <= ends[0] < 2 + VOXEL and 6 - VOXEL < ends[1] <= 6, ends)
            heat, low, corners = grid_of(path, "heat")
            self.assertEqual(heat.tobytes(), place.astype(numpy.float32).tobytes())
            numpy.testing.assert_allclose(corners[0], 0, atol=1e-12)
        for number, path in enumerate(self.advect("v", "steps", *options, "--carry", "heat", "--substeps", 2, "--method", "streaks",
                                                  "--draw", "lines")):
            numpy.testing.assert_allclose(grid_of(path, "heat")[2][0], 0, atol=1e-12)
            numpy.testing.assert_allclose(grid_of(path, "magnitude")[2][0], [2.7 * DT * (number // 2), 0, 0], atol=1e-12)
        for frame, path in enumerate(self.advect("v", "stays", *options, "--carry", "heat", "--stay")):
            numpy.testing.assert_allclose(grid_of(path, "heat")[2][0], [-2.7 * DT * frame, 0, 0], atol=1e-12)
        # The smoke of a chimney drifts as it does for an observer at rest.
        chimney = "--method", "streaks", "--draw", "lines", "--spacing", 1, "--tail", 2, "--preroll", 0, "--emit-box", 2, 1, 2, 3.5, 2.5, 6
        heads = []
        for name, more in ("rest", ()), ("seen", options):
            lines = read_lines(self.advect("v", name, *chimney, *more)[-1])[0]
            heads.append(lines["points"][numpy.cumsum(lines["counts"]) - 1].mean(axis=0))
        numpy.testing.assert_allclose(*heads, atol=0.25)

    def test_refusals(self):
        self.uniform()
        self.uniform(timed=False, name="untimed")
        for status, said, pattern, options in (
                (2, "--frame-axis cannot be 0 0 0", "v", ("--frame-rotation", 1, "--frame-axis", 0, 0, 0)),
                (2, "of --frame-rotation, which is not given", "v", ("--frame-point", 0, 0, 0)),
                (2, "--stay is of an observer who moves", "v", ("--stay",)),
                (2, "--frame-velocity takes three finite numbers, or mean", "v", ("--frame-velocity", "nan", 0, 0)),
                (2, "--frame-velocity takes three finite numbers, or mean", "v", ("--frame-velocity", 1, 2)),
                (2, "--frame-velocity takes three finite numbers, or mean", "v", ("--frame-velocity", "median")),
                (2, "--frame-rotation cannot be nan", "v", ("--frame-rotation", "nan")),
                (3, "no time or dt in the files, which an observer who moves needs: give --dt", "untimed", ("--frame-velocity", 1, 0, 0)),
                (3, "no time or dt in the files, which an observer who moves needs: give --dt", "untimed", ("--frame-rotation", 1))):
            with self.subTest(options=options):
                message = self.fails(status, "vdblic_advect", f"{pattern}.%04d.vdb", "-o", "lic.%04d.vdb", *options)
                self.assertIn(said, message)
                self.assertEqual(len(message.splitlines()), 1)
        self.outputs("vdblic_advect", "v.%04d.vdb", "--frame-velocity", -1e-3, 0, 2.5, "-o", "lic.%04d.vdb", "--frames", "1")

    def test_a_film_takes_the_observer(self):
        self.unsteady()
        done = self.run_tool("vdblic_film", "moving.%04d.vdb", "-o", "film.png", "--size", 96, 64, "--frame-velocity", *U)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(re.search(r"vdblic_advect .*--frame-velocity 6 -4 2", done.stderr), done.stderr)
        self.assertNotIn("--stay", done.stderr)
        rest = self.run_tool("vdblic_film", "rest.%04d.vdb", "-o", "rest.png", "--size", 96, 64)
        spacing = [re.search("--spacing [^ ]+ --tail [^ ]+", one.stderr)[0] for one in (done, rest)]
        self.assertEqual(*spacing)  # chosen for the flow that is seen


if __name__ == "__main__":
    unittest.main()
