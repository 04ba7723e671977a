"""The Python module against the tools: the same textures, pictures and reports; errors, interruptions and threads."""

import datetime
import json
import os
import re
import resource
import signal
import struct
import subprocess
import sys
import threading
import time
import unittest
import zlib

import numpy
import pyopenvdb as vdb

import flows
from python_module import MODULE
from support import BIN, SOURCE, ToolTest, peer

import vdblic

SIZE = 24, 20, 16


FLOW = next(vdblic.synth("abc", SIZE, [1]))["velocity"].values
BROKEN = FLOW.copy()
BROKEN[1, 2, 3, 0] = numpy.nan


def fields(count):
    """The velocities of a known flow, with their times."""
    for volume in vdblic.synth("abc", SIZE, range(1, count + 1)):
        yield volume.time, volume["velocity"].values


class Volumes(ToolTest):
    def test_what_is_written_is_read(self):
        values = numpy.random.default_rng(1).random((9, 17, 5), numpy.float32)
        active = values > 0.3
        active[[0, -1]] = active[:, [0, -1]] = active[..., [0, -1]] = True
        place = numpy.array([[0, 2, 0, 5], [1, 0, 0, 6], [0, 0, 3, 7], [0, 0, 0, 1.0]])
        scalar = vdblic.Grid(values, active, place, (-3, 2, 100), "p", {"time": 0.5, "n": 3, "is": True, "of": "air"})
        vector = vdblic.Grid(values[..., None] * [1, 2, 3], name="v", staggered=True)
        vdblic.write(self.folder / "a.vdb", [scalar, vector], {"frame": 7})
        volume = vdblic.read(self.folder / "a.vdb")
        self.assertEqual((list(volume), volume.frame, volume.time), (["p", "v"], 7, 0.5))
        back = volume["p"]
        numpy.testing.assert_array_equal(back.active, active)
        numpy.testing.assert_array_equal(back.values, numpy.where(active, values, 0))
        numpy.testing.assert_array_equal(back.transform, place)
        self.assertEqual((back.origin, back.staggered), ((-3, 2, 100), False))
        self.assertLessEqual(scalar.metadata.items(), back.metadata.items())
        numpy.testing.assert_array_equal(back.positions()[1, 2, 3], place[:3, :3] @ (-2, 4, 103) + (5, 6, 7))
        self.assertTrue(volume["v"].staggered)
        numpy.testing.assert_allclose(volume["v"].values, vector.values, rtol=1e-7)
        self.outputs("vdblic_noise", "--verify", "--like", "a.vdb", "-o", "n.vdb")
        self.assertIn("1 of them by their checksums",
                      self.run_tool("vdblic_noise", "--verify", "--like", "a.vdb", "-o", "n.vdb").stderr)
        # Any layout is taken.
        vdblic.write(self.folder / "b.vdb", vdblic.Grid(numpy.asfortranarray(values)[::-1].astype(float), name="p"))
        numpy.testing.assert_array_equal(vdblic.read(self.folder / "b.vdb")["p"].values, values[::-1])

    def test_metadata_keeps_its_types(self):
        single, whole = numpy.float32(0.1), numpy.int32(7)
        given = {"text": "12", "truth": True, "long": 2**40, "double": 0.1, "int": whole, "float": single,
                 "vec2i": (1, 2), "vec3i": (1, 2, 3), "vec3s": (single, single, single), "vec3d": (0.1, 0.2, 0.3),
                 "vec4i": numpy.array([1, 2, 3, 4]), "numpy": numpy.float64(0.5), "flag": numpy.bool_(False)}
        vdblic.write(self.folder / "a.vdb", vdblic.Grid(numpy.ones((2, 2, 2)), metadata=given), given)
        volume = vdblic.read(self.folder / "a.vdb")
        vdblic.write(self.folder / "b.vdb", volume)
        for path in "a.vdb", "b.vdb":
            volume = vdblic.read(self.folder / path)
            for back in volume.metadata, volume["density"].metadata:
                for key, value in given.items():
                    value = tuple(value.tolist()) if key == "vec4i" else value
                    types = [type(v) for v in (value if isinstance(value, tuple) else (value,))]
                    found = back[key] if isinstance(back[key], tuple) else (back[key],)
                    types = [{numpy.float64: float, numpy.bool_: bool}.get(t, t) for t in types]
                    self.assertEqual((back[key], [type(v) for v in found]), (value, types), key)
        for bad in {"a": 1}, None, [1], (1, 2, 3, 4, 5), 2**70, (2**40, 0), 1j, ["x", "y"]:
            with self.subTest(bad), self.assertRaisesRegex(ValueError, "metadata 'key' cannot be .*; it is a text"):
                vdblic.write(self.folder / "c.vdb", vdblic.Grid(numpy.ones((2, 2, 2))), {"key": bad})

    def test_metadata_of_other_types_stays(self):
        vdb.write(str(self.folder / "empty.vdb"), grids=[vdb.FloatGrid()])  # a box of the smallest and largest numbers
        vdblic.write(self.folder / "again.vdb", vdblic.read(self.folder / "empty.vdb"))
        grid = vdb.FloatGrid()
        grid.fill((0, 0, 0), (3, 3, 3), 1.0)
        matrix = [[1.0, 2, 3, 4], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        vdb.write(str(self.folder / "a.vdb"), grids=[grid], metadata={"matrix": matrix, "triple": (1, 2, 3)})
        vdblic.write(self.folder / "b.vdb", vdblic.read(self.folder / "a.vdb"))
        before, after = (vdb.readMetadata(str(self.folder / name)) for name in ("a.vdb", "b.vdb"))
        self.assertEqual((after["matrix"], after["triple"]), (before["matrix"], before["triple"]))

    def test_a_rewritten_texture_is_the_texture(self):
        self.outputs("vdblic_synth", "ring", "-o", "v.vdb", "--size", *SIZE, "--frames", 1)
        self.outputs("vdblic_advect", "v.vdb", "-o", "a.vdb", "--refine", 2, "--texture-name", "lic")
        volume = vdblic.read(self.folder / "a.vdb")
        self.assertEqual(volume.metadata["refine"], (2, 2, 2))
        vdblic.write(self.folder / "b.vdb", volume, half=True)
        self.assertEqual(vdblic.diff(self.folder / "a.vdb", self.folder / "b.vdb")["verdict"], "same")
        types = [{line.split(":")[0].strip(): line.split(":", 1)[1] for line in self.printed(path).splitlines()
                  if re.search(r"^ {8,}\w+: ", line)} for path in ("a.vdb", "b.vdb")]
        self.assertEqual(types[0], types[1])
        for path in "a", "b":
            self.outputs("vdblic_render", f"{path}.vdb", "-o", f"{path}.png", "--size", 40, 30)
        self.assertEqual(self.contents("a.png"), self.contents("b.png"))

    def test_a_globe_is_that_of_the_tool(self):
        self.outputs("vdblic_synth", "rossby", "-o", "v.vdb", "--frames", 3, "--voxel-size", 0.4)
        made, stored = next(vdblic.synth("rossby", None, [3], voxel_size=0.4)), vdblic.read(self.folder / "v.vdb")
        self.assertEqual((set(made), made.time), (set(stored), 2 * 28800))
        for name, grid in made.items():
            numpy.testing.assert_array_equal(grid.values, stored[name].values, name)
            self.assertEqual(grid.origin, stored[name].origin)
        with self.assertRaisesRegex(ValueError, "`size` is not for rossby"):
            next(vdblic.synth("rossby", 8, [1]))
        with self.assertRaisesRegex(ValueError, "`size` is missing"):
            next(vdblic.synth("abc", None, [1]))

    def test_mistakes(self):
        with self.assertRaisesRegex(ValueError, "nothing.vdb: no such file"):
            vdblic.read(self.folder / "nothing.vdb")
        (self.folder / "broken.vdb").write_bytes(b"garbage" * 99)
        with self.assertRaisesRegex(ValueError, "broken.vdb"):
            vdblic.read(self.folder / "broken.vdb")
        with self.assertRaisesRegex(OSError, "make it first"):
            vdblic.write(self.folder / "no/a.vdb", vdblic.Grid(numpy.zeros((2, 2, 2))))
        with self.assertRaisesRegex(ValueError, r"^grid 'density': `values` is no array .* its shape is \(2, 2\)$"):
            vdblic.write(self.folder / "a.vdb", vdblic.Grid(numpy.zeros((2, 2))))
        with self.assertRaisesRegex(ValueError, "`values` are complex"):
            vdblic.write(self.folder / "a.vdb", vdblic.Grid(numpy.zeros((2, 2, 2), complex)))
        with self.assertRaisesRegex(ValueError, r"`origin` cannot be \(0.5, 0, 0\); it is 3 whole numbers"):
            vdblic.write(self.folder / "a.vdb", vdblic.Grid(numpy.zeros((2, 2, 2)), origin=(0.5, 0, 0)))
        with self.assertRaisesRegex(ValueError, "grid 5: `name` cannot be 5; it is a text"):
            vdblic.write(self.folder / "a.vdb", vdblic.Grid(numpy.zeros((2, 2, 2)), name=5))
        with self.assertRaisesRegex(ValueError, "`active` is no mask of 2 x 2 x 2"):
            vdblic.write(self.folder / "a.vdb", vdblic.Grid(numpy.zeros((2, 2, 2)), numpy.ones((2, 2, 3), bool)))
        with self.assertRaisesRegex(ValueError, "`transform`"):
            vdblic.write(self.folder / "a.vdb", vdblic.Grid(numpy.zeros((2, 2, 2)), transform=numpy.zeros((4, 4))))
        with self.assertRaisesRegex(KeyError, "no grid 'q'; the volume holds p"):
            vdblic.Volume([vdblic.Grid(numpy.zeros((2, 2, 2)), name="p")])["q"]
        with self.assertRaisesRegex(ValueError, "abc, gyre"):
            next(vdblic.synth("nothing", (8, 8, 8), [1]))
        self.assertEqual(self.files(), ["broken.vdb"])


class Globe(ToolTest):
    """Particles in the wave on the Earth, of which the wind is known, with voxels of 2 degrees."""

    VOXEL, OMEGA = 6.371 * numpy.radians(2), 7.848e-6
    RATE = (28 * OMEGA - 2 * 7.292e-5) / 30

    def wind(self, places, time):
        """The formula of Williamson and others, 1992, in longitude and latitude."""
        x, y, z = places.T
        radius, ring = numpy.linalg.norm(places, axis=1), numpy.hypot(x, y)
        sine, cosine, angle = z / radius, ring / radius, 4 * (numpy.arctan2(y, x) - self.RATE * time)
        east = self.OMEGA * radius * (cosine + cosine**3 * (4 * sine**2 - cosine**2) * numpy.cos(angle))
        north = -4 * self.OMEGA * radius * cosine**3 * sine * numpy.sin(angle)
        return numpy.stack([-east * y - north * sine * x, east * x - north * sine * y, north * cosine * ring], axis=1) / ring[:, None]

    def later(self, places, time, seconds, steps=20):
        """Where particles are after some seconds (Runge-Kutta)."""
        step = seconds / steps
        for at in time + step * numpy.arange(steps):
            a = self.wind(places, at)
            b = self.wind(places + step / 2 * a, at + step / 2)
            c = self.wind(places + step / 2 * b, at + step / 2)
            d = self.wind(places + step * c, at + step)
            places = places + step / 6 * (a + 2 * b + 2 * c + d)
        return places

    def test_particles_turn_at_their_speed_at_the_poles_as_at_the_equator(self):
        frames = vdblic.synth("rossby", None, range(1, 8), voxel_size=self.VOXEL)
        *_, before, after = vdblic.streaks(frames, spacing=2)
        heads = [dict(zip(volume.lines.ids, volume.lines.points[numpy.cumsum(volume.lines.counts) - 1])) for volume in (before, after)]
        both = sorted(heads[0].keys() & heads[1].keys())
        start, end = (numpy.array([head[name] for name in both], float) for head in heads)
        radius = numpy.linalg.norm(start, axis=1)
        inside = (radius > 6.371) & (radius < 6.371 + 5 * self.VOXEL)
        start, end, radius = start[inside], end[inside], radius[inside]
        exact = self.later(start, before.time, after.time - before.time)
        self.assertLess(abs(numpy.linalg.norm(end, axis=1) - radius).mean(), 1e-3 * self.VOXEL)
        latitude = abs(numpy.degrees(numpy.arcsin(start[:, 2] / radius)))
        for low, high in (0, 10), (30, 60), (80, 90):
            band = (latitude >= low) & (latitude < high)
            self.assertGreater(band.sum(), 50)
            turn, expected = (numpy.angle((to[:, 0] + 1j * to[:, 1]) / (start[:, 0] + 1j * start[:, 1]))[band] for to in (end, exact))
            self.assertLess(abs(turn.sum() / expected.sum() - 1), 1e-3, (low, high))


class Advect(ToolTest):
    def assert_equal(self, textures, paths):
        """The textures are those of the files, bit for bit."""
        self.assertEqual(len(textures), len(paths))
        for texture, path in zip(textures, paths):
            expected = vdblic.read(path)
            self.assertEqual(list(texture), list(expected))
            self.assertEqual(texture.metadata["time"], expected.metadata["time"])
            for name in expected:
                numpy.testing.assert_array_equal(texture[name].values, expected[name].values)
                numpy.testing.assert_array_equal(texture[name].active, expected[name].active)
                numpy.testing.assert_array_equal(texture[name].transform, expected[name].transform)

    def test_arrays_and_files_give_the_textures_of_the_tool(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *SIZE, "--frames", "1-5")
        paths = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--refine", 2, "--substeps", 2,
                             "--seed", 3, "--with", "q,hits")
        options = {"refine": 2, "substeps": 2, "seed": 3, "with_": ["q", "hits"]}
        self.assert_equal(list(vdblic.advect(f"{self.folder}/v.%04d.vdb", **options)), paths)
        self.assert_equal(list(vdblic.advect(fields(5), voxel_size=0.1, **options)), paths)
        self.assert_equal(list(vdblic.advect(vdblic.synth("abc", SIZE, range(1, 6)), **options)), paths)
        film = self.outputs("vdblic_advect", "v.0001.vdb", "-o", "film.%04d.vdb", "--steady-frames", 3, "--voxels-per-frame", 2,
                            "--dt", 0.5)
        still = {"steady_frames": 3, "voxels_per_frame": 2, "dt": 0.5}
        self.assert_equal(list(vdblic.advect(f"{self.folder}/v.0001.vdb", **still)), film)
        self.assert_equal(list(vdblic.advect(fields(1), voxel_size=0.1, **still)), film)
        lic = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "steady.%04d.vdb", "--method", "lic", "--dt", 0.5)
        part = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "part.%04d.vdb", "--frames", "1,2,4")
        for frames in "1,2,4", [1, 2, 4], numpy.array([1, 2, 4]):
            self.assert_equal(list(vdblic.advect(f"{self.folder}/v.%04d.vdb", frames=frames)), part)
        arrays = [values for _, values in fields(5)]
        self.assert_equal(list(vdblic.advect(arrays, dt=0.5, voxel_size=0.1, method="lic")), lic)

    def test_errors(self):
        def broken():
            yield from fields(2)
            raise RuntimeError("no more")

        run = vdblic.advect(broken())
        with self.assertRaisesRegex(RuntimeError, "no more"):
            list(run)
        for error, words, arguments, options in (
                (ValueError, "frame 1 has the shape", ([numpy.zeros((4, 4, 4))],), {}),
                (ValueError, "^`life` cannot be 0; it is a whole number from 1 to 1000$", (fields(1),), {"life": 0}),
                (ValueError, "^`refine` cannot be x; it is 1 to 3 whole numbers from 1 to 16$", (fields(1),), {"refine": "x"}),
                (ValueError, "^`refine` cannot be 1.5; it is 1 to 3 whole numbers from 1 to 16$", (fields(1),), {"refine": 1.5}),
                (ValueError, "^`refine` cannot be 2.5 1 1; it is 1 to 3 whole", (fields(1),), {"refine": numpy.array([2.5, 1, 1])}),
                (ValueError, "^`seed` cannot be 0.5; it is a whole number", (fields(1),), {"seed": numpy.float32(0.5)}),
                (ValueError, "^`life` cannot be 1j; it is a whole number", (fields(1),), {"life": 1j}),
                (ValueError, "^`mask` cannot be array.*; it is FILE", (fields(1),), {"mask": numpy.ones(SIZE, bool)}),
                (ValueError, "`frames` selects files", (fields(1),), {"frames": "1-2"}),
                (TypeError, "`velocities` cannot be 5", (5,), {}),
                (ValueError, "frame 2: 'x' is no field", ([FLOW, "x"],), {}),
                (ValueError, "frame 2: an array of complex", ([FLOW, FLOW * 1j],), {}),
                (ValueError, r"frame 2 has the shape \(24, 20, 16\)", ([FLOW, FLOW[..., 0]],), {}),
                (ValueError, "frame 2: the time 'x' is neither", ([(0, FLOW), ("x", FLOW)],), {}),
                (ValueError, "^frame 2: its time 0 does not come after", ([(0, FLOW), (0, FLOW)],), {}),
                (ValueError, "^frame 2: grid velocity: 1 voxel is not finite, the first at .1, 2, 3.; mend the values",
                 ([FLOW, BROKEN],), {}),
                (ValueError, "^frame 2: grid 'v': `active` is no mask of 24 x 20 x 16 voxels$",
                 ([FLOW, vdblic.Grid(FLOW, numpy.ones((2, 2, 2)), name="v")],), {}),
                (ValueError, "^frame 1: no velocity: .*; present: no grids; choose with", ([vdblic.Volume([])],), {}),
                (ValueError, "`voxel_size` cannot be 0; it is one length above 0, or three", (fields(1),), {"voxel_size": 0}),
                (ValueError, "`voxel_size` cannot be -1;", (fields(1),), {"voxel_size": -1}),
                (ValueError, r"`voxel_size` cannot be \(1, 2\);", (fields(1),), {"voxel_size": (1, 2)}),
                (ValueError, "`method` cannot be x; it is one of auflic, auflic-2004, uflic, lic", (fields(1),), {"method": "x"}),
                (ValueError, "no such file", (f"{self.folder}/none.vdb",), {}),
                (ValueError, "paths on standard input are for the tools", ("-",), {}),
                (ValueError, "`steady_frames` 3 repeats a single frame|steady_frames", (fields(2),), {"steady_frames": 3}),
                (ValueError, "^`with_` hits: with `method` lic no values", (fields(1),), {"with_": "hits", "method": "lic"}),
                (ValueError, "`voxels_per_frame` and `motion` exclude each other", (fields(1),), {"motion": 2, "voxels_per_frame": 2}),
                (ValueError, "`dt` cannot be 0", (fields(1),), {"dt": 0}),
                (TypeError, r"^advect\(\) has no parameter 'refin'; 'refine' is one$", (fields(1),), {"refin": 3}),
                (TypeError, r"^advect\(\) has no parameter 'life_span'; help\(vdblic.advect\) lists them$", (fields(1),), {"life_span": 3}),
                (ValueError, "no frame to compute$", ([],), {})):
            with self.subTest(words), self.assertRaisesRegex(error, words):
                list(vdblic.advect(*arguments, **options))

    def test_errors_in_parameters_are_raised_at_once(self):
        with self.assertRaisesRegex(ValueError, "`refine` cannot be 1.5"):
            vdblic.advect(fields(1), refine=1.5)
        with self.assertRaisesRegex(ValueError, "no such file"):
            vdblic.advect(f"{self.folder}/none.vdb")

    def test_what_is_harmless_is_taken(self):
        options = {"refine": 2, "dt": 0.5, "steady_frames": 2}
        expected = list(vdblic.advect(FLOW, **options))
        for lenient in ({"refine": 2.0}, {"refine": (2.0, 2, numpy.float32(2))}, {"dt": numpy.timedelta64(500, "ms")},
                        {"dt": numpy.timedelta64(500_000_000, "ns")}, {"dt": None, "fps": 2}, {"dt": datetime.timedelta(seconds=0.5)},
                        {"steady_frames": 2.0}):
            for texture, known in zip(vdblic.advect(FLOW, **options | lenient), expected):
                numpy.testing.assert_array_equal(texture["density"], known["density"])
                self.assertEqual(texture.metadata["dt"], 0.5)
        for wrong, words in (({"life": numpy.timedelta64(4, "s")}, "`life` cannot be .*; it is a whole number"),
                             ({"dt": numpy.timedelta64("NaT")}, "`dt` cannot be nan"),
                             ({"dt": numpy.datetime64("2000-01-01")}, "`dt` cannot be numpy.datetime64.*; it is a number"),
                             ({"refine": float("inf")}, "`refine` cannot be inf"), ({"seed": True}, "`seed` cannot be true")):
            with self.subTest(wrong), self.assertRaisesRegex(ValueError, words):
                vdblic.advect(FLOW, **wrong)
        cube = next(vdblic.synth("abc", numpy.float64(8), [1], dt=numpy.timedelta64(250, "ms")))["velocity"]
        self.assertEqual((cube.shape, cube.metadata["dt"]), ((8, 8, 8, 3), 0.25))
        with self.assertRaisesRegex(ValueError, r"`size` cannot be \(8, 8, 8.5\); it is whole numbers"):
            next(vdblic.synth("abc", (8, 8, 8.5), [1]))
        sizes = [vdblic.Renderer(size=size)(FLOW[..., 0]).shape for size in (64, 64.0, (64.0, 64), numpy.array([64.0, 64]))]
        self.assertEqual(sizes, [(64, 64, 3)] * 4)

    def test_numbers_of_numpy_are_numbers(self):
        expected, = vdblic.advect([FLOW], refine=2, sharpen=0.5)
        for two in numpy.int64(2), numpy.uint8(2), numpy.array(2), numpy.array([2, 2, 2]), (numpy.int32(2), 2, 2):
            texture, = vdblic.advect([FLOW], refine=two, sharpen=numpy.float32(0.5))
            numpy.testing.assert_array_equal(texture["density"].values, expected["density"].values)

    def test_warnings_name_a_frame_once(self):
        with self.assertWarnsRegex(UserWarning, "^frame 1: no active voxels; its texture is empty"):
            list(vdblic.advect([vdblic.Grid(FLOW, numpy.zeros(SIZE, bool), name="velocity")]))

    def test_a_closed_iterator_stops_the_run(self):
        asked = []

        def endless():
            for number in range(10**6):
                asked.append(number)
                yield number / 24, numpy.ones((*SIZE, 3), numpy.float32)

        run = vdblic.advect(endless())
        next(run)
        run.close()
        self.assertLess(len(asked), 12)
        self.assertFalse([thread for thread in threading.enumerate() if thread is not threading.main_thread()])

    def test_signals_leave_nothing_behind(self):
        start = ("import vdblic, numpy\n"
                 "frames = ((n / 24, numpy.ones((32, 32, 32, 3), 'f4')) for n in range(10**6))\n"
                 "render = vdblic.Renderer(size=(64, 64))\n")
        advect = start + "for t in vdblic.advect(frames): print(t.frame, flush=True)\n"
        render = start + "t = next(vdblic.advect(frames))\nwhile True: print(render(t).shape, flush=True)\n"
        differ = start + "t = next(vdblic.advect(frames))\nwhile True: print(vdblic.diff(t, t)['verdict'], flush=True)\n"
        for program in advect, render, differ:
            for number in signal.SIGINT, signal.SIGTERM:
                run = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                       text=True, env=os.environ | {"PYTHONPATH": str(MODULE), "TMPDIR": str(self.folder)})
                run.stdout.readline()
                run.send_signal(number)
                _, messages = run.communicate(timeout=30)
                if number == signal.SIGINT:
                    self.assertIn("KeyboardInterrupt", messages)
                self.assertEqual(run.returncode, -number)
                self.assertEqual(self.files(), [], "scratch files are removed")

    def test_several_runs_at_a_time(self):
        alone = [texture["density"].values for texture in vdblic.advect(fields(4))]
        results = [[] for _ in range(3)]

        def work(result):
            result += [texture["density"].values for texture in vdblic.advect(fields(4))]

        threads = [threading.Thread(target=work, args=(result,)) for result in results]
        started = time.monotonic()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
        self.assertLess(time.monotonic() - started, 60)
        for result in results:
            numpy.testing.assert_array_equal(result, alone)

    def test_memory_is_flat_over_100_frames(self):
        peaks = []
        for number, _ in enumerate(vdblic.advect((n / 24, numpy.ones((*SIZE, 3), numpy.float32)) for n in range(100))):
            if number in (30, 99):
                peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
        self.assertEqual(number, 99)
        self.assertLess(peaks[1] - peaks[0], 8 << 10)

    def test_what_does_not_fit_names_the_tool_that_takes_a_scratch_file(self):
        program = f"""import resource, sys; sys.path[:] = {sys.path}
import numpy, vdblic
resource.setrlimit(resource.RLIMIT_DATA, (400 << 20,) * 2)
next(iter(vdblic.advect([numpy.ones((128, 128, 128, 3), numpy.float32)] * 2, refine=2)))"""
        done = subprocess.run([sys.executable, "-c", program], text=True, capture_output=True, check=False)
        self.assertRegex(done.stderr, "InputError: .* lower `refine`, .* or let vdblic_advect do it, which takes a scratch file")
        self.assertNotIn("max_memory", done.stderr)


class Pictures(ToolTest):
    def test_a_picture_is_that_of_the_tool(self):
        self.outputs("vdblic_synth", "ring", "-o", "v.%04d.vdb", "--size", *SIZE, "--frames", "1-2")
        paths = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--refine", 2)
        options = ("--size", 48, 32, "--samples", 2, "--precision", "float", "--eye", 8, 9, 7, "--shadows", 0.5)
        self.outputs("vdblic_render", "-", "-o", "i.%04d.exr", *options,
                     stdin="\n".join(map(str, paths)))
        render = vdblic.Renderer(size=(48, 32), samples=2, eye=(8, 9, 7), shadows=0.5)
        for frame, path in enumerate(paths, 1):
            picture = render(vdblic.read(path)).linear
            self.assertEqual((picture.shape, picture.dtype), ((32, 48, 4), numpy.float32))
            self.assertGreater(picture[..., 3].max(), 0.3)
            numpy.testing.assert_array_equal(picture, self.pixels(f"i.{frame:04}.exr", (32, 48)))

    def test_a_globe_in_a_picture_is_that_of_the_tool(self):
        with open(self.folder / "s.obj", "w", encoding="utf-8") as file:
            file.write("v -9 -9 -9\nv 9 -9 -9\nv 0 9 -9\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        texture = self.texture()
        pictures = []
        for earth in (False, True):
            self.outputs("vdblic_render", "lic.vdb", "-o", "i.exr", "--size", 48, 32, "--precision", "float", "--solid",
                         "s.obj", *(["--earth"] if earth else []))
            render = vdblic.Renderer(size=(48, 32), solid=str(self.folder / "s.obj"), earth=earth)
            pictures.append(render(texture).linear)
            numpy.testing.assert_array_equal(pictures[-1], self.pixels("i.exr", (32, 48)))
        self.assertGreater(abs(pictures[0] - pictures[1]).max(), 0.05)

    def texture(self):
        self.outputs("vdblic_synth", "ring", "-o", "v.vdb", "--size", *SIZE, "--frames", 1)
        self.outputs("vdblic_advect", "v.vdb", "-o", "lic.vdb", "--refine", 2)
        return vdblic.read(self.folder / "lic.vdb")

    def test_streaks_have_their_look(self):
        self.outputs("vdblic_synth", "ring", "-o", "v.vdb", "--size", *SIZE, "--frames", 1)
        self.outputs("vdblic_advect", "v.vdb", "-o", "s.vdb", "--method", "streaks", "--spacing", 3, "--refine", 4)
        texture = vdblic.read(self.folder / "s.vdb")
        picture = vdblic.Renderer(size=(48, 32))(texture).linear
        numpy.testing.assert_array_equal(picture, vdblic.Renderer(size=(48, 32), look="streaks")(texture).linear)
        self.assertGreater(abs(picture - vdblic.Renderer(size=(48, 32), look="flow")(texture).linear).max(), 0.01)

    def test_lines_are_drawn_as_by_the_tool(self):
        """Alone, and in a texture; the first frame chooses the look of all."""
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *SIZE, "--frames", "1-2")
        textures = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb")
        lines = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "s.%04d.vdb", "--method", "streaks", "--draw", "lines", "--spacing", 3,
                             "--with", "q")
        size = "--size", 48, 32, "--samples", 2, "--precision", "float"
        beside, seen = f"{self.folder}/s.%04d.vdb", []
        for paths, words, options in (
                (textures[:1], (), {}), (lines[:1], (), {}),
                (lines[:1], ("--opacity-by", "q", "--look", "vortex"), {"opacity_by": "q", "look": "vortex"}),
                (textures[:1], ("--lines", beside), {"lines": beside}), (textures, ("--lines", beside), {"lines": beside}),
                (textures[:1], ("--lines", lines[1], "--opacity", "0:0.1"), {"lines": lines[1], "opacity": "0:0.1"})):
            with self.subTest(options=options):
                source = {"stdin": "\n".join(map(str, paths))} if len(paths) > 1 else {}
                self.outputs("vdblic_render", "-" if source else paths[0], "-o", "i.%04d.exr", *size, *words, **source)
                render = vdblic.Renderer(size=(48, 32), samples=2, **options)
                for frame, path in enumerate(paths, 1):
                    picture = render(vdblic.read(path)).linear
                    numpy.testing.assert_array_equal(picture, self.pixels(f"i.{frame:04}.exr", (32, 48)))
                seen.append(picture.tobytes())
        self.assertEqual(len(set(seen)), len(seen))

    def test_lines_that_cannot_be_drawn(self):
        texture = self.texture()
        self.outputs("vdblic_advect", "v.vdb", "-o", "s.vdb", "--method", "streaks", "--draw", "lines", "--spacing", 3)
        for volume, lines, words in ((texture, "none.%04d.vdb", "none.0001.vdb: the lines of frame 1 are missing"),
                                     (texture, "lic.vdb", "lic.vdb: holds no lines"),
                                     (vdblic.read(self.folder / "s.vdb"), "s.vdb", "the texture: holds lines itself")):
            with self.subTest(lines), self.assertRaisesRegex(ValueError, words) as caught:
                vdblic.Renderer(size=48, lines=self.folder / lines)(volume)
            self.assertNotIn("\n", str(caught.exception))
        with self.assertRaisesRegex(ValueError, "more than one"):
            vdblic.Renderer(lines="s.%d.%d.vdb")

    def test_a_picture_shows_itself_in_a_notebook(self):
        texture = self.texture()
        for look, options in (("flow", {}), ("ink", {}), ("paper", {}),
                              ("flow", {"annotate": ["box", "axes"], "background": (0.5, 0, 1)})):
            arguments = ["--annotate", "box,axes", "--background", 0.5, 0, 1] if options else []
            self.outputs("vdblic_render", "lic.vdb", "-o", "i.png", "--size", 48, 32, "--look", look, *arguments)
            picture = vdblic.Renderer(size=(48, 32), look=look, **options)(texture)
            with open(self.folder / "self.png", "wb") as file:
                file.write(picture._repr_png_())
            bytes_of = [subprocess.run(["oiiotool", self.folder / name, "-o", self.folder / "raw.ppm"], check=True) and
                        numpy.frombuffer(self.contents("raw.ppm")[-48 * 32 * 3:], numpy.uint8) for name in ("i.png", "self.png")]
            numpy.testing.assert_allclose(*map(numpy.int64, bytes_of), atol=1)
            shown = numpy.asarray(picture)
            self.assertEqual((shown.shape, shown.dtype, picture.shape), ((32, 48, 3), numpy.uint8, (32, 48, 3)))
            numpy.testing.assert_array_equal(shown.ravel(), bytes_of[1])
        self.assertEqual(repr(picture), "<vdblic.Picture 48 × 32>")
        self.assertEqual(numpy.array(picture, float).dtype, float)

    def test_a_picture_is_saved_as_the_tool_saves_it(self):
        picture = vdblic.Renderer(size=(48, 32))(self.texture())
        self.outputs("vdblic_render", "lic.vdb", "-o", "i.exr", "--size", 48, 32, "--precision", "float")
        picture.save(self.folder / "p.exr", precision="float")
        numpy.testing.assert_array_equal(self.pixels("p.exr", (32, 48)), self.pixels("i.exr", (32, 48)))
        picture.save(str(self.folder / "half.exr"))
        self.assertLess(len(self.contents("half.exr")), len(self.contents("p.exr")))
        picture.save(self.folder / "p.png")
        self.assertEqual(self.contents("p.png"), picture._repr_png_())
        for path, words in (("p.jpg", "p.jpg"), ("no/p.png", "make it first|no/p.png")):
            with self.assertRaisesRegex((ValueError, OSError), words):
                picture.save(self.folder / path)
        with self.assertRaisesRegex(ValueError, "double"):
            picture.save(self.folder / "q.exr", precision="double")
        with self.assertRaisesRegex(ValueError, r"`linear` has the shape \(2, 3\); a picture has \(height, width, 4\)"):
            vdblic.Picture(numpy.zeros((2, 3)))

    def test_matplotlib_shows_it_as_a_screen_does(self):
        python = peer("numpy", "matplotlib")
        if python is None:
            self.skipTest("Matplotlib is missing: tests/peers.sh gets it")
        program = ("import matplotlib; matplotlib.use('agg'); import numpy, vdblic, matplotlib.pyplot as plt\n"
                   "linear = numpy.random.default_rng(1).random((5, 7, 4)); linear[..., :3] *= linear[..., 3:]\n"
                   "picture = vdblic.Picture(linear)\n"
                   "image = plt.imshow(picture)\n"
                   "print((image.get_array() == numpy.asarray(picture)).all(), image.get_array().dtype)\n")
        done = subprocess.run([python, "-B", "-c", program], env=os.environ | {"PYTHONPATH": str(MODULE)}, text=True,
                              capture_output=True, check=True)
        self.assertEqual(done.stdout, "True uint8\n")

    def test_a_renderer_shows_its_options_and_frees_its_memory(self):
        texture = self.texture()
        with vdblic.Renderer(size=48, look="ink", eye=(1, 2, 3)) as render:
            self.assertEqual(repr(render), "vdblic.Renderer(size=48, look='ink', eye=(1, 2, 3))")
            self.assertEqual(render(texture).shape, (48, 48, 3))
        with self.assertRaisesRegex(ValueError, "the renderer is closed"):
            render(texture)

    def test_a_background_and_annotations_are_in_the_picture(self):
        texture = self.texture()
        plain = vdblic.Renderer(size=(48, 32), background=(1, 0, 0), background_alpha=0)(texture).linear
        behind = vdblic.Renderer(size=(48, 32), background=(1, 0, 0))(texture).linear
        numpy.testing.assert_allclose(behind, plain + (1 - plain[..., 3:]) * [1, 0, 0, 1], atol=1e-6)
        self.outputs("vdblic_render", "lic.vdb", "-o", "i.exr", "--size", 48, 32, "--precision", "float", "--background",
                     1, 0, 0)
        numpy.testing.assert_array_equal(behind, self.pixels("i.exr", (32, 48)))
        self.assertGreater(abs(vdblic.Renderer(size=(48, 32), background=(1, 0, 0), annotate="box")(texture).linear - behind).max(), 0.2)

    def test_lists_stand_for_texts(self):
        texture = self.texture()
        for text, lists in (
                ({"colors": "0:#102040,0.5:#e2581a,1:#fff6d5"},
                 [[(0, "#102040"), (0.5, "#e2581a"), (1, "#fff6d5")], ["0:#102040", "0.5:#e2581a", "1:#fff6d5"]]),
                ({"opacity": "0:0,0.5:0.1,1:0.75"}, [[(0, 0), (0.5, 0.1), (1, 0.75)], [[0, 0], [0.5, 0.1], [1, 0.75]],
                                                     numpy.array([[0, 0], [0.5, 0.1], [1, 0.75]])]),
                ({"annotate": "box,axes"}, [["box", "axes"], ("box", "axes")])):
            (key, value), = text.items()
            expected = vdblic.Renderer(size=(48, 32), **text)(texture).linear
            for given in lists:
                with self.subTest(given):
                    numpy.testing.assert_array_equal(vdblic.Renderer(size=(48, 32), **{key: given})(texture).linear, expected)
        for options, words in (
                ({"colors": [(0, (1, 0, 0))]}, "`colors` cannot be .*; it is POSITION:#RRGGBB,..."),
                ({"colors": {0: "#000000"}}, "`colors` cannot be .*; it is POSITION:#RRGGBB,..."),
                ({"opacity": [0, 0.5]}, "'0' is not POSITION:OPACITY"),
                ({"size": (20.5, 30)}, "`size` cannot be 20.5 30; it is 2 whole numbers")):
            with self.subTest(options), self.assertRaisesRegex(ValueError, words):
                vdblic.Renderer(**options)

    def test_arrays_and_grids_are_textures(self):
        values = self.texture()["density"].values
        expected = vdblic.Renderer(size=(48, 32))(vdblic.Volume([vdblic.Grid(values)])).linear
        self.assertGreater(expected[..., 3].max(), 0.1)
        for texture in values, values.astype(float), vdblic.Grid(values), vdblic.Grid(values, name="any"):
            numpy.testing.assert_array_equal(vdblic.Renderer(size=(48, 32))(texture).linear, expected)
        numpy.testing.assert_array_equal(vdblic.Renderer(size=(48, 32), texture="mine")(values).linear, expected)
        for bad, words in ((FLOW, r"the texture has the shape \(24, 20, 16, 3\); a texture has \(x, y, z\)"),
                           (values[0], "is no field"), ("lic.vdb", "'lic.vdb' is no field; vdblic.read")):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                vdblic.Renderer()(bad)

    def pixels(self, name, shape):
        """The pixels (y, x, RGBA) of an .exr file of floats, sixteen rows a block of ZIP."""
        data, at = self.contents(name), 8
        while data[at]:  # attributes: name, type, size, value
            at = data.index(0, data.index(0, at) + 1) + 1
            at += 4 + struct.unpack_from("<i", data, at)[0]
        rows = []
        for offset in struct.unpack_from(f"<{-(-shape[0] // 16)}Q", data, at + 1):
            _, size = struct.unpack_from("<ii", data, offset)
            block = data[offset + 8:offset + 8 + size]
            count = min(16, shape[0] - len(rows)) * shape[1] * 16  # bytes
            if size < count:  # differences of the low bytes, then of the others
                halves = numpy.cumsum(numpy.frombuffer(zlib.decompress(block), numpy.uint8).astype(int) - 128) + 128
                block = halves.astype(numpy.uint8).reshape(2, -1).T.tobytes()
            rows.extend(numpy.frombuffer(block, "<f4").reshape(-1, 4, shape[1])[:, ::-1].transpose(0, 2, 1))
        return numpy.array(rows)

    def test_mistakes(self):
        for wrong, words in (("width", r"help\(vdblic.Renderer\) lists them"), ("colour_map", "'colormap' is one"), ("backg", "'background' is one")):
            with self.assertRaisesRegex(TypeError, rf"^Renderer\(\) has no parameter '{wrong}'; {words}$"):
                vdblic.Renderer(**{wrong: 3})
        with self.assertRaisesRegex(ValueError, "flow, vortex"):
            vdblic.Renderer(look="nice")
        with self.assertRaisesRegex(ValueError, r"^the texture: no float grid 'density'; present: p \(float\); choose"):
            vdblic.Renderer()(vdblic.Volume([vdblic.Grid(numpy.zeros((2, 2, 2)), name="p")]))


class Measures(ToolTest):
    def test_reports_are_those_of_the_tools(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *SIZE, "--frames", "1-3")
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb")
        velocity, texture = f"{self.folder}/v.%04d.vdb", f"{self.folder}/lic.%04d.vdb"
        self.assertEqual(vdblic.diff(velocity, velocity)["verdict"], "same")
        one, two = (vdblic.read(self.folder / f"lic.{frame:04}.vdb") for frame in (1, 2))
        self.assertEqual((vdblic.diff(one, one)["verdict"], vdblic.diff(one, two)["verdict"]), ("same", "different"))
        path = self.folder / "lic.0001.vdb"
        self.assertEqual((vdblic.diff(one, path)["verdict"], vdblic.diff(path, two)["verdict"]), ("same", "different"))
        expected = vdblic.diff(path, self.folder / "lic.0002.vdb")
        report = vdblic.diff(one, two)
        self.assertEqual((report["a"], report["b"]), ("a", "b"))
        self.assertEqual([grid["values"] for grid in report["frames"][0]["grids"]],
                         [grid["values"] for grid in expected["frames"][0]["grids"]])
        broken = vdblic.Volume([vdblic.Grid(FLOW, numpy.ones((2, 2, 2)), name="v")])
        for arguments, words in (((one, broken), "^b: grid 'v': `active` is no mask"), ((one, "none.vdb"), "^none.vdb: no such file")):
            with self.assertRaisesRegex(ValueError, words):
                vdblic.diff(*arguments)
        self.outputs("vdblic_coherence", "v.%04d.vdb", "lic.%04d.vdb", "--json", "c.json", "--samples", 2000)
        report = vdblic.coherence(velocity, texture, samples=2000)
        expected = json.loads(self.contents("c.json"))
        self.assertEqual(report["frames"], expected["frames"])


class Packaged(ToolTest):
    def run_python(self, *arguments, path=MODULE):
        environment = os.environ | {"PYTHONPATH": str(path), "PATH": f"{BIN}:{os.environ['PATH']}"}
        done = subprocess.run([sys.executable, *map(str, arguments)], cwd=self.folder, env=environment, text=True,
                              capture_output=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_samples(self):
        for name in "field_to_picture.py", "import_to_film.py", "solver_stream.py":
            self.assertIn("usage: " + name, self.run_python(SOURCE / "samples/python" / name, "--help"))
        self.assertEqual(self.files(), [])
        self.run_python(SOURCE / "samples/python/field_to_picture.py", "picture.png")
        self.run_python(SOURCE / "samples/python/solver_stream.py", "flow.%04d.png", "--size", 16, "--steps", 4)
        self.assertEqual([name for name in self.files() if name.startswith("flow.")], [f"flow.{k:04}.png" for k in range(1, 5)])
        for name, size in ("picture.png", (400, 640)), ("flow.0004.png", (480, 480)):
            subprocess.run(["oiiotool", self.folder / name, "-o", self.folder / "raw.ppm"], check=True)
            picture = numpy.frombuffer(self.contents("raw.ppm")[15:], numpy.uint8).reshape(*size, 3)
            self.assertGreater(picture.std(), 10)
        flows.write_foam(self.folder / "case", [0, 0.1])
        self.run_python(SOURCE / "samples/python/import_to_film.py", "case", "film.mp4", "--size", 8, 6, 4)
        self.assertGreater(len(self.contents("film.mp4")), 1000)

    def test_installed(self):
        subprocess.run(["cmake", "--install", BIN.parent, "--prefix", self.folder / "prefix"], check=True,
                       capture_output=True)
        packages = self.folder / "prefix/lib/python3/dist-packages"
        program = "import vdblic; print(vdblic.__file__, len(list(vdblic.synth('abc', (4, 4, 4), [1]))))"
        where = self.run_python("-c", program, path=packages)
        self.assertEqual(where.split(), [str(packages / "vdblic/__init__.py"), "1"])
        self.assertTrue((packages / "vdblic/py.typed").is_file())
        numpy.savez(self.folder / "v.npz", velocity=numpy.ones((4, 4, 4, 3)), voxel_size=1)
        for tool, source, output in ("import", "v.npz", "v.vdb"), ("export", "v.vdb", "v.vti"):
            command = [self.folder / f"prefix/bin/vdblic_{tool}", source, "-o", output]
            subprocess.run(command, cwd=self.folder, check=True, capture_output=True)
            self.assertIn(output, self.files())


if __name__ == "__main__":
    unittest.main()
