"""vdblic_info: what a sequence holds, and what it advises."""

import json
import re
import resource
import time
import unittest

import numpy
import pyopenvdb as vdb

from support import SOURCE, ToolTest


class Info(ToolTest):
    def write(self, frame, velocity, size=0.5, **metadata):
        grid = vdb.Vec3SGrid()
        grid.name = "velocity"
        grid.copyFromArray(numpy.ascontiguousarray(velocity, numpy.float32), tolerance=(-1, -1, -1))
        grid.transform = vdb.createLinearTransform(size)
        for key, value in metadata.items():
            grid[key] = value
        vdb.write(str(self.folder / f"v.{frame:04}.vdb"), grid)

    def constant(self, speed, size=(16, 16, 16)):
        return numpy.full((*size, 3), (speed, 0.0, 0.0))

    def info(self, *arguments, status=0):
        """The report of one sequence as JSON, and as text."""
        done = self.run_tool("vdblic_info", *arguments, "--json", "info.json")
        self.assertEqual((done.returncode, done.stdout), (status, "info.json\n"), done.stderr)
        sequence, = json.loads((self.folder / "info.json").read_text())["sequences"]
        return sequence, done.stderr

    def test_known_sequence(self):
        for frame in 1, 2, 3, 5, 6:
            self.write(frame, self.constant(frame), time=frame * 0.25)
        info, text = self.info("v.%04d.vdb", "--values")
        self.assertEqual((info["frames"], info["missing"], info["damaged"]), ([1, 2, 3, 5, 6], [4], []))
        self.assertEqual(info["bytes"], sum(path.stat().st_size for path in self.folder.glob("v.*")))
        grid, = info["grids"]
        expected = {"name": "velocity", "type": "vec3s", "files": 5, "least_voxels": 4096, "most_voxels": 4096,
                    "box": [[0, 0, 0], [15, 15, 15]], "voxel_size": [0.5, 0.5, 0.5], "low": 1.0, "high": 6.0,
                    "not_finite": 0, "transform_changes": False}
        self.assertEqual({key: grid[key] for key in expected}, expected)
        velocity = info["velocity"]
        expected = {"grid": "velocity", "unit": "world/s", "scale": 1.0, "interval": 0.25,
                    "interval_source": "by the files' times", "largest_displacement_frame": 6}
        self.assertEqual({key: velocity[key] for key in expected}, expected)
        self.assertAlmostEqual(velocity["largest_displacement"], 6 * 0.25 / 0.5, places=5)
        self.assertAlmostEqual(velocity["mean_displacement"], 17 / 5 * 0.25 / 0.5, places=5)
        self.assertIn("v.%04d.vdb: 5 frames, 1-3,5-6; ", text)
        self.assertIn("frame 4 is missing; --frames 1-3,5-6 selects the others", info["advice"])
        self.assertIn("4096 voxels make a coarse dense texture: --refine 7", " ".join(info["advice"]))

    def test_headers_alone(self):
        self.write(1, self.constant(1), dt=0.1)
        info, text = self.info("v.0001.vdb")
        self.assertNotIn("low", info["grids"][0])
        self.assertNotIn("largest_displacement", info["velocity"])
        self.assertEqual((info["velocity"]["interval"], info["velocity"]["interval_source"]), (0.1, "by the files' dt"))
        self.assertRegex(text, r"vdblic_advect takes about .* MiB of memory and .* s of processor time")
        for options, source in ((("--dt", 2), "as given"), (("--fps", 8), "as given")):
            self.assertEqual(self.info("v.0001.vdb", *options)[0]["velocity"]["interval_source"], source)

    def test_only_the_grids_of_the_velocity_count(self):
        """Grids whose names are parts of the velocity's: `velocity` holds `v`, and `vel.x, vel.y, vel.z` holds `x`."""
        field = numpy.ascontiguousarray(self.constant(1), numpy.float32)
        velocity, other = vdb.Vec3SGrid(), vdb.FloatGrid()
        velocity.name, other.name = "velocity", "v"
        velocity.copyFromArray(field, tolerance=(-1, -1, -1))
        other.copyFromArray(numpy.ones((48, 48, 48), numpy.float32), tolerance=-1)
        vdb.write(str(self.folder / "alone.vdb"), velocity)
        vdb.write(str(self.folder / "beside.vdb"), [velocity, other])
        components = []
        for axis in "xyz":
            components.append(vdb.FloatGrid())
            components[-1].name = f"vel.{axis}"
            components[-1].copyFromArray(field[..., 0], tolerance=-1)
        other.name = "x"
        vdb.write(str(self.folder / "three.vdb"), components)
        vdb.write(str(self.folder / "four.vdb"), [*components, other])
        for alone, beside in ("alone.vdb", "beside.vdb"), ("three.vdb", "four.vdb"):
            cost = [self.info(name, "--values")[0]["velocity"] for name in (alone, beside)]
            self.assertEqual(cost[0], cost[1])
            self.assertGreater(cost[0]["memory"], 0)

    def test_streaks(self):
        """The command for streaks is one that vdblic_advect takes, and what it takes is as told."""
        pattern = str(SOURCE / "samples/wake/wake.%04d.vdb")
        info, text = self.info(pattern, "--values", "--frames", "1-3")
        told = re.search(r"vdblic_advect (--method streaks --spacing 1.5 --tail \S+ --refine 11) takes about (\S+) MiB", text)
        streaks = info["velocity"]["streaks"]
        self.assertEqual((streaks["spacing"], streaks["refine"]), ([1.5] * 3, [11] * 3))
        self.assertAlmostEqual(streaks["memory"] / 2**20, float(told[2]), delta=0.1)
        self.outputs("vdblic_advect", pattern, "-o", "s.%04d.vdb", "--frames", "1-3", *told[1].split(), "--json", "s.json",
                     "--lead-in", 0, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA,
                                                                          (int(1.35 * streaks["memory"]),) * 2))
        seconds = sum(sum(frame["seconds"][stage] for stage in ("scatter", "convolve"))
                      for frame in json.loads(self.contents("s.json"))["frames"])
        self.assertGreater(streaks["processor_seconds"], 0.3 * seconds)
        self.assertNotIn("--tail", self.info(pattern)[1])  # headers do not tell how fast the flow is

    def test_advice(self):
        self.write(1, self.constant(200, (70, 70, 4)), dt=0.1)
        advice = " ".join(self.info("v.0001.vdb", "--values")[0]["advice"])
        self.assertIn("the faster half of the flow moves 40 voxels a step, too far for streaks: check --velocity-unit and "
                      "the frame spacing, or give --voxels-per-frame 4 for slow motion", advice)
        self.assertIn("the domain is flat, 35 x 35 x 2: vdblic_render shows it better with --stretch 1 1 4", advice)
        self.write(1, self.constant(8, (64, 64, 64)), dt=0.1)
        self.assertEqual(self.info("v.0001.vdb", "--values")[0]["advice"],
                         ["one frame gives one texture: --steady-frames 24 gives a film of a flow that stays as it is"])
        broken = self.constant(8, (64, 64, 64))
        broken[3, 4, 5, 0] = numpy.nan
        self.write(1, broken, dt=0.1)
        self.write(2, self.constant(8, (64, 64, 64)), size=0.25, dt=0.1)
        info, _ = self.info("v.%04d.vdb", "--values")
        self.assertEqual(info["grids"][0]["not_finite"], 1)
        self.assertIn("1 values of grid 'velocity' are not finite: mend them, or give --nonfinite zero", info["advice"])
        self.assertIn("the transform of grid 'velocity' changes between frames", " ".join(info["advice"]))

    def test_advice_holds(self):
        """Twenty flows: what the advice of one tool names, the others take, and what it promises is so."""
        self.outputs("vdblic_synth", "abc", "-o", "abc.%04d.vdb", "--size", 10, 10, 10, "--frames", "1-8")
        self.outputs("vdblic_synth", "ring", "-o", "ring.%04d.vdb", "--size", 14, 14, 20, "--frames", "1-40")
        self.outputs("vdblic_synth", "gyre", "-o", "wide.%04d.vdb", "--size", 40, 20, 2, "--frames", "1-3")
        self.outputs("vdblic_synth", "gyre", "-o", "layer.%04d.vdb", "--size", 24, 16, 1, "--frames", "1-3")
        self.write(1, self.constant(0, (10, 10, 10)))
        jet = self.constant(0, (10, 10, 10))
        jet[:2, :2] = 48, 0, 0  # in still air: a few voxels move by 4
        self.write(2, jet)
        jet[0, 0, 0] = 1e5, 0, 0  # one voxel far too fast
        self.write(3, jet)
        kinds = set()
        for pattern, *options in (
                ("abc.%04d.vdb",), ("abc.%04d.vdb", "--dt", 0.003), ("abc.%04d.vdb", "--dt", 1e-4),
                ("abc.%04d.vdb", "--dt", 0.8), ("abc.%04d.vdb", "--dt", 0.3), ("abc.%04d.vdb", "--dt", 1e3),
                ("abc.%04d.vdb", "--velocity-unit", "voxel/s"), ("abc.%04d.vdb", "--velocity-unit", "voxel/frame"),
                ("abc.0003.vdb",), ("abc.0003.vdb", "--dt", 1e-6), ("abc.0003.vdb", "--dt", 3600),
                ("ring.%04d.vdb",), ("ring.%04d.vdb", "--dt", 0.002), ("ring.%04d.vdb", "--dt", 1e-5),
                ("wide.%04d.vdb",), ("layer.%04d.vdb",), ("layer.0001.vdb", "--dt", 1e-3),
                ("v.0001.vdb",), ("v.0002.vdb",), ("v.0003.vdb",)):
            with self.subTest(pattern=pattern, options=options):
                kinds |= self.check_advice(pattern, *options)
        self.assertEqual(kinds, {"--frames", "--voxels-per-frame", "--steady-frames", "--refine", "--stretch"})

    def check_advice(self, pattern, *options):
        """Take the advice about a sequence, and check what it promises. Returns the options that it names."""
        info, _ = self.info(pattern, "--values", *options)
        moves = info["velocity"]["faster_half_displacement"]
        advice = " ".join(info["advice"])
        self.assertNotIn("--substeps", advice)
        found = {name: re.findall(r"[^ ;]+", values) for name, values in
                 re.findall(r"(--frames|--voxels-per-frame|--steady-frames|--refine|--stretch)((?: [0-9][^ ;]*)+)", advice)}
        self.assertEqual("too little" in advice, 0 < moves < 0.25)
        self.assertEqual("too far" in advice, moves > 16)
        self.assertEqual("at rest" in advice, moves == 0)
        taken = [*map(str, options), "--frames", *found["--frames"]] if "--frames" in found else [*map(str, options)]
        after = self.info(pattern, "--values", *taken)[0]
        step = after["velocity"]["faster_half_displacement"]
        if "--frames" in found:
            self.assertGreater(step, 0.7)
            self.assertGreaterEqual(len(after["frames"]), 4)
        self.assertEqual("--steady-frames" in found, len(info["frames"]) == 1)
        if "--voxels-per-frame" in found:
            taken += ["--voxels-per-frame", *found["--voxels-per-frame"]]
        taken = [option for option in taken if option not in ("--frames", *found.get("--frames", []))]
        if "%" in pattern:
            taken += ["--frames", ",".join(map(str, after["frames"][:2]))]
        if "--steady-frames" in found:
            film = self.outputs("vdblic_advect", pattern, "-o", "film.%04d.vdb", *taken, "--steady-frames",
                                *found["--steady-frames"])
            self.assertEqual(len(film), int(found["--steady-frames"][0]))
        taken += ["--refine", *found["--refine"]] if "--refine" in found else []
        done = self.run_tool("vdblic_advect", pattern, "-o", "lic.%04d.vdb", *taken, "--preroll", 1)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("too far", done.stderr)
        if "--voxels-per-frame" in found:
            step *= float(re.search("--motion ([^ ]+),", done.stderr)[1])
            self.assertAlmostEqual(step, 4, delta=2)  # of all frames; the first one moves as far as was asked
        texture = vdb.read(str(self.folder / done.stdout.split()[0]), "density")
        if "--refine" in found:
            millions = float(re.search("gives ([^ ]+) million", advice)[1])
            self.assertAlmostEqual(texture.activeVoxelCount() / 1e6 / millions, 1, delta=0.01)
        self.outputs("vdblic_render", done.stdout.split()[0], "-o", "i.png", "--size", 32, 32,
                     *(["--stretch", *found["--stretch"]] if "--stretch" in found else []))
        for file in self.folder.glob("lic.*"):
            file.unlink()
        return set(found)

    def test_values_that_are_all_infinite(self):
        self.write(1, self.constant(numpy.inf))
        info, text = self.info("v.0001.vdb", "--values")
        self.assertIn("none of 4096 values is finite", text)
        self.assertNotIn("at rest", text)
        grid, = info["grids"]
        self.assertEqual((grid["not_finite"], "low" in grid), (4096, False))
        film = self.run_tool("vdblic_film", "v.0001.vdb", "-o", "v.png")
        self.assertEqual(film.returncode, 3)
        self.assertIn("no value of grid 'velocity' is finite", film.stderr)

    def test_grids_of_one_name(self):
        grids = []
        for size in 1, 2, 3:
            grid = vdb.FloatGrid()
            grid.fill((0, 0, 0), (size, 7, 7), float(size))
            grid.transform = vdb.createLinearTransform(size)
            grid.name = "density"
            grids.append(grid)
        vdb.write(str(self.folder / "d.0001.vdb"), grids)
        info, text = self.info("d.0001.vdb", "--values")
        self.assertIn("holds 3 grids 'density', and tools read the first", text)
        self.assertNotIn("changes between frames", text)
        grid, = info["grids"]
        self.assertEqual((grid["of_name"], grid["voxel_size"], grid["high"]), (3, [1, 1, 1], 1))

    def test_damaged_files_are_named(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 16, 16, 16, "--frames", "1-4")
        self.assertEqual(self.info("v.%04d.vdb")[0]["with_checksums"], 4)
        data = bytearray(self.contents("v.0002.vdb"))
        data[-20] ^= 4
        (self.folder / "v.0002.vdb").write_bytes(data)
        (self.folder / "v.0003.vdb").write_bytes(self.contents("v.0003.vdb")[:2000])
        info, text = self.info("v.%04d.vdb", status=3)
        self.assertEqual(len(info["damaged"]), 1)
        self.assertIn("1 file cannot be read: write it again", info["advice"])
        self.assertIn("v.%04d.vdb: 1 of 4 files cannot be read", text)
        self.assertRegex(info["damaged"][0], "v.0003.vdb: .*it is truncated")
        info, text = self.info("v.%04d.vdb", "--values", status=3)
        self.assertEqual(len(info["damaged"]), 2)
        self.assertIn("damaged: v.0002.vdb: cannot be read as a .vdb file: grid 'velocity' is damaged", text)

    def test_several_sequences_and_textures(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 16, 16, 16, "--frames", "1-2")
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb")
        files = self.files()
        for output in "-", "/dev/stdout":
            done = self.run_tool("vdblic_info", "v.%04d.vdb", "lic.%04d.vdb", "--json", output)
            velocity, texture = json.loads(done.stdout)["sequences"]
        self.assertEqual(self.files(), files)
        self.assertIn("velocity", velocity)
        self.assertNotIn("velocity", texture)
        self.assertEqual([grid["name"] for grid in texture["grids"]], ["density", "magnitude"])
        self.assertTrue(texture["creator"].startswith("VDBLIC"))
        self.assertIn("no file matches", self.fails(3, "vdblic_info", "none.%04d.vdb"))
        self.assertIn("cannot be inspected", self.fails(2, "vdblic_info", "-"))

    def test_files_that_a_shell_lists_are_one_sequence(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 16, 16, 16, "--frames", "1-4")
        files = [f"v.{frame:04}.vdb" for frame in range(1, 5)]
        for given, pattern, frames in ((files, "v.%04d.vdb", [1, 2, 3, 4]), (files[1:3], "v.%04d.vdb", [2, 3]),
                                       (files[:1], "v.0001.vdb", [1])):
            done = self.run_tool("vdblic_info", *given, "--json", "-")
            (sequence,) = json.loads(done.stdout)["sequences"]
            self.assertEqual((sequence["pattern"], sequence["frames"]), (pattern, frames))

    def test_commands_to_paste(self):
        """The report ends with commands for a film, a still, and the film step by step."""
        self.outputs("vdblic_synth", "tornado", "-o", "v.%04d.vdb", "--size", 16, 16, 16, "--frames", "1-3")
        text = self.run_tool("vdblic_info", "v.%04d.vdb", "--values").stderr
        self.assertIn("  film: vdblic_film v.%04d.vdb -o flow.mp4\n", text)
        self.assertIn("  still: vdblic_film v.%04d.vdb -o flow.png\n", text)
        advect, render = re.findall(r"the film step by step: (.*)", text)
        self.assertRegex(advect, r"^vdblic_advect v.%04d.vdb -o texture.%04d.vdb --method streaks .*--refine \d+")
        self.assertRegex(render, r"^vdblic_render texture.%04d.vdb --film flow.mp4 --fps 24 --size 1280 720 ")

    def test_a_thousand_files_in_seconds(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.0001.vdb", "--size", 32, 32, 32, "--frames", "1")
        data = self.contents("v.0001.vdb")
        for frame in range(2, 1001):
            (self.folder / f"v.{frame:04}.vdb").write_bytes(data)
        started = time.monotonic()
        info, _ = self.info("v.%04d.vdb")
        self.assertLess(time.monotonic() - started, 5)
        self.assertEqual(len(info["frames"]), 1000)


if __name__ == "__main__":
    unittest.main()
