"""Choices are said, and messages name what is wrong and what would mend it."""

import fcntl
import os
import pathlib
import pty
import struct
import subprocess
import termios
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, ToolTest


class Messages(ToolTest):
    def synth(self, frames="1-4", prefix="v"):
        self.outputs("vdblic_synth", "abc", "-o", f"{prefix}.%04d.vdb", "--size", 12, 12, 12, "--frames", frames)

    def textures(self, *options):
        self.synth()
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", *options)

    def says(self, tool, *arguments, **options):
        """The messages of a run that succeeds."""
        done = self.run_tool(tool, *arguments, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr

    def truncate(self, name):
        data = self.contents(name)
        (self.folder / name).write_bytes(data[:len(data) // 2])
        return data

    # Rendering

    RENDER = ("vdblic_render", "lic.%04d.vdb", "-o", "i.%04d.png", "--size", 24, 24)

    def test_pictures_after_a_damaged_frame_are_told_of(self):
        self.synth("1-6")
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb")
        self.truncate("lic.0002.vdb")
        for _ in range(5):  # a busy machine may begin no further frame before it meets the damaged one
            for path in self.folder.glob("i.*"):
                path.unlink()
            done = self.run_tool("vdblic_render", "lic.%04d.vdb", "-o", "i.%04d.png", "--size", 200, 200, "--threads", 4)
            self.assertEqual(done.returncode, 3)
            self.assertEqual(done.stdout.split(), [name for name in self.files() if name.startswith("i.")])
            if len(done.stdout.split()) > 1:
                return
        self.fail("no picture after that of the damaged frame")

    def test_damaged_frames_are_left_out(self):
        self.textures()
        whole = {path.name: path.read_bytes() for path in self.outputs(*self.RENDER)}
        for damaged in ("lic.0003.vdb",), ("lic.0001.vdb",), ("lic.0002.vdb", "lic.0004.vdb"):
            kept = {name: self.truncate(name) for name in damaged}
            for path in self.folder.glob("i.*"):
                path.unlink()
            self.assertEqual(self.run_tool(*self.RENDER).returncode, 3)
            for path in self.folder.glob("i.*"):
                path.unlink()
            done = self.run_tool(*self.RENDER, "--keep-going")
            self.assertEqual(done.returncode, 3)
            for name in damaged:
                self.assertRegex(done.stderr, f"warning: {name}: .*it is truncated.*; the frame is left out")
            self.assertIn(f"{len(damaged)} of 4 frames could not be rendered", done.stderr)
            left = [f"i.{name[4:8]}.png" for name in damaged]
            self.assertEqual(done.stdout.split(), sorted(whole.keys() - set(left)))
            for name, data in kept.items():
                (self.folder / name).write_bytes(data)
            # The frames that were left out can follow.
            messages = self.says(*self.RENDER, "--keep-going", "--skip-existing")
            self.assertIn(f"{4 - len(damaged)} of 4 images were there already", messages)
            self.assertTrue(all((self.folder / name).is_file() for name in left))

    def test_logs_tell_each_frame(self):
        self.textures()
        messages = self.says(*self.RENDER)
        for frame in 1, 2, 3, 4:
            self.assertRegex(messages, rf"vdblic_render: frame {frame}: \d+\.\d s, {frame}/4 done")
        self.assertEqual(self.says(*self.RENDER, "-q"), "")

    def test_the_choices_of_a_pipe(self):
        self.textures()
        paths = "".join(f"lic.000{frame}.vdb\n" for frame in (1, 2, 3, 4))
        pipe = ("vdblic_render", "-", "-o", "p.%04d.png", "--size", 24, 24)
        self.assertIn("range and opacity are chosen from the first frame alone; --transfer takes them from a file, which "
                      "--transfer-out writes", self.says(*pipe, stdin=paths))
        made, = self.outputs("vdblic_render", "lic.%04d.vdb", "--transfer-out", "t.json")
        self.assertEqual(made.name, "t.json")
        self.says(*self.RENDER)
        self.assertNotEqual([self.contents(f"p.000{frame}.png") for frame in (1, 2, 3, 4)],
                            [self.contents(f"i.000{frame}.png") for frame in (1, 2, 3, 4)])
        camera = ("--eye", 3, 3, 3, "--target", 0.5, 0.5, 0.5)
        messages = self.says(*pipe, *camera, "--transfer", "t.json", stdin=paths)
        self.assertNotIn("first frame alone", messages)
        self.says(*self.RENDER, *camera, "--transfer", "t.json")
        alone = self.outputs(*self.RENDER, *camera, "--transfer-out", "t2.json")
        self.assertEqual(self.contents("t.json"), self.contents("t2.json"))
        self.assertEqual(len(alone), 5)

    def test_the_texture_is_found_by_what_made_it(self):
        smoke = vdb.FloatGrid()
        smoke.name = "density"
        smoke.fill((0, 0, 0), (11, 11, 11), 0.5)
        self.synth()
        for frame in range(1, 5):
            velocity = vdb.read(str(self.folder / f"v.{frame:04}.vdb"), "velocity")
            smoke.transform = velocity.transform
            vdb.write(str(self.folder / f"s.{frame:04}.vdb"), grids=[smoke, velocity])
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb")
        self.outputs("vdblic_advect", "s.%04d.vdb", "-o", "carried.%04d.vdb", "--carry", "density", "--texture-name", "lic",
                     "--dt", vdb.readMetadata(str(self.folder / "lic.0001.vdb"))["dt"])
        for source in "carried.%04d.vdb", "-":
            paths = "".join(f"carried.000{frame}.vdb\n" for frame in (1, 2, 3, 4)) if source == "-" else ""
            self.says("vdblic_render", source, "-o", "c.%04d.png", "--size", 24, 24, stdin=paths)
            listed = "".join(f"lic.000{frame}.vdb\n" for frame in (1, 2, 3, 4)) if source == "-" else ""
            self.says("vdblic_render", "-" if listed else "lic.%04d.vdb", "-o", "i.%04d.png", "--size", 24, 24, stdin=listed)
            for frame in range(1, 5):
                self.assertEqual(self.contents(f"c.{frame:04}.png"), self.contents(f"i.{frame:04}.png"))
        figures = [self.says("vdblic_coherence", "v.%04d.vdb", f"{name}.%04d.vdb") for name in ("carried", "lic")]
        numbers = [[line for line in text.splitlines() if " done" not in line] for text in figures]
        self.assertEqual(*numbers)

    def test_nothing_to_see(self):
        self.textures()
        for options, reason in ((("--eye", 100, 0, 0, "--target", 200, 0, 0), "the camera at 100 0 0 looks at 200 0 0"),
                                (("--range", 1000, 2000), r"the values, .* lie outside of --range 1000 to 2000"),
                                (("--clip-box", 9, 9, 9, 10, 10, 10), "--clip-box or --clip-plane cut everything away"),
                                (("--opacity", "0:0,1:0"), "every sample is transparent")):
            self.assertRegex(self.says(*self.RENDER, *options), "warning: the images show nothing: " + reason)
        self.assertNotIn("warning", self.says(*self.RENDER))
        empty = vdb.FloatGrid()
        empty.name = "density"
        vdb.write(str(self.folder / "e.0001.vdb"), empty)
        self.assertIn("warning: no frame has an active voxel", self.says("vdblic_render", "e.0001.vdb", "-o", "e.png"))
        cloud = vdb.FloatGrid()
        cloud.name = "density"
        cloud.fill((0, 0, 0), (7, 7, 7), 1)
        cloud.fill((8, 8, 8), (15, 15, 15), 1)
        vdb.write(str(self.folder / "cloud.vdb"), cloud)
        self.assertIn("--solid domain makes 75 % of the texture's box a body, as around a cloud",
                      self.says("vdblic_render", "cloud.vdb", "-o", "e.png", "--solid", "domain"))
        for tool, *more in ("vdblic_render", "-o", "e.png"), ("vdblic_view", "--port", 0):
            self.assertIn("v.0001.vdb: holds a velocity and no texture 'density'; vdblic_film shows a velocity",
                          self.fails(3, tool, "v.0001.vdb", *more))
        self.assertIn("warning: frame 1: v.0001.vdb: no active voxel lies inside --bbox",
                      self.says("vdblic_advect", "v.0001.vdb", "-o", "o.vdb", "--bbox", "99,99,99,100,100,100"))
        self.assertRegex(self.says("vdblic_advect", "v.0001.vdb", "-o", "o.vdb", "--velocity-scale", 1e-9),
                         "warning: frame 1: .*: grid velocity moves nothing by more than .* voxels a step")

    # Velocities

    def write_grids(self, name, *grids):
        vdb.write(str(self.folder / name), grids=list(grids))

    @staticmethod
    def vectors(name):
        grid = vdb.Vec3SGrid()
        grid.name = name
        grid.fill((0, 0, 0), (7, 7, 7), (1, 2, 3))
        return grid

    @staticmethod
    def scalar(name, value):
        grid = vdb.FloatGrid()
        grid.name = name
        grid.fill((0, 0, 0), (7, 7, 7), value)
        return grid

    def test_velocities_of_other_names(self):
        run = ("vdblic_advect", "n.vdb", "-o", "l.vdb", "--dt", 1)
        self.write_grids("n.vdb", self.vectors("velocity"))
        self.says(*run)
        expected = self.contents("l.vdb")
        for names, option in ((("u", "v", "w"), ()), (("U", "V", "W"), ()), (("velocityX", "velocityY", "velocityZ"), ()),
                              (("vel_X", "vel_Y", "vel_Z"), ()), (("a", "b", "c"), ("--velocity", "a,b,c")),
                              (("Ux", "Uy", "Uz"), ("--velocity", "U"))):
            self.write_grids("n.vdb", *(self.scalar(name, value) for name, value in zip(names, (1, 2, 3))))
            self.says(*run, *option)
            self.assertEqual(self.contents("l.vdb"), expected, names)
        self.fails(3, *run, "--velocity", "Ux,Uy,none")

        self.write_grids("n.vdb", self.vectors("wind"))
        self.assertIn("the files hold no grid called velocity: taking 'wind'; choose with --velocity", self.says(*run))
        for other in "vorticity", "color", "Cd", "gradient":
            self.write_grids("n.vdb", self.vectors(other))
            message = self.fails(3, *run)
            self.assertIn(f"no velocity: a vector grid, or three scalars", message)
            self.assertIn(f"present: {other} (vec3s); choose with --velocity NAME", message)
            self.says(*run, "--velocity", other)

    def test_a_flow_that_moves_too_far_is_warned_of(self):
        self.synth()
        fast = ("vdblic_advect", "v.0001.vdb", "-o", "l.vdb", "--velocity-scale", 100)
        said = "too far for streaks: check --velocity-unit and the frame spacing, or give --voxels-per-frame 4"
        self.assertIn(said, self.says(*fast))
        self.assertNotIn(said, self.says(*fast, "--method", "lic"))

    # Comparing

    def test_metadata_numbers_have_a_tolerance(self):
        def write(name, **metadata):
            vdb.write(str(self.folder / name), grids=[self.scalar("a", 1)], metadata=metadata)

        write("a.vdb", dt=0.05)
        for dt in 0.05 * (1 + 1e-12), 0.05 + 1e-17:
            write("b.vdb", dt=dt)
            self.assertEqual(self.run_tool("vdblic_diff", "a.vdb", "b.vdb").returncode, 0)
        write("b.vdb", dt=0.05 * (1 + 1e-5))
        message = self.run_tool("vdblic_diff", "a.vdb", "b.vdb")
        self.assertEqual(message.returncode, 1)
        self.assertIn("metadata dt: '0.05' | '0.05", message.stderr)
        self.assertIn("--ignore-metadata leaves such names out", message.stderr)
        self.assertNotIn("'0.05' | '0.05'", message.stderr)
        self.assertEqual(self.run_tool("vdblic_diff", "a.vdb", "b.vdb", "--ignore-metadata", "dt").returncode, 0)

    # Arguments

    def test_patterns_that_are_none(self):
        self.synth()
        (self.folder / "cache").mkdir()
        for frame in 1, 2:
            os.link(self.folder / "v.0001.vdb", self.folder / f"cache/flow.{frame:03}.vdb")
        (self.folder / "bare").mkdir()
        for pattern, advice in (("v.*.vdb", "'*' is no frame field; write v.%04d.vdb"),
                                ("v.%4d.vdb", "'%4d' is no frame field; write v.%04d.vdb"),
                                ("v.%04i.vdb", "'%04i' is no frame field; write v.%04d.vdb"),
                                ("cache", "it is a folder holding flow.001.vdb ...; write cache/flow.%03d.vdb"),
                                ("bare", "it is a folder; name a file or a pattern such as name.%04d.vdb")):
            for command in (("vdblic_advect", pattern, "-o", "o.%04d.vdb"), ("vdblic_render", pattern, "-o", "o.%04d.png"),
                            ("vdblic_diff", pattern, pattern), ("vdblic_coherence", pattern, pattern)):
                self.assertIn(advice, self.fails(2, *command))
        for pattern in "v.%03d.vdb", "v.#.vdb", "v.%d.vdb", "v.@@@@@.vdb":
            self.assertIn("no file matches the pattern; the files on disk match v.%04d.vdb",
                          self.fails(3, "vdblic_advect", pattern, "-o", "o.%04d.vdb"))
        self.assertIn("'%4d' is no frame field; write o.%04d.vdb",
                      self.fails(2, "vdblic_advect", "v.%04d.vdb", "-o", "o.%4d.vdb"))

    def test_an_expanded_pattern(self):
        self.synth()
        names = sorted(path.name for path in self.folder.glob("v.*"))
        for command in (("vdblic_advect", *names, "-o", "o.%04d.vdb"), ("vdblic_render", *names, "-o", "o.png")):
            self.assertIn("3 more files are named than the tool takes, as by a pattern that the shell expanded; write the "
                          "pattern as v.%04d.vdb or in quotes", self.fails(2, *command))

    def test_mistyped_options(self):
        for tool, typed, meant in (("vdblic_advect", "--lif=3", "--life"), ("vdblic_advect", "--frame", "--frames"),
                                   ("vdblic_render", "--aouto", None), ("vdblic_synth", "--voxelsize", "--voxel-size"),
                                   ("vdblic_diff", "--ignore_metadata", "--ignore-metadata")):
            message = self.fails(2, tool, typed, "x")
            self.assertIn(f"there is no option {typed.split('=')[0]}", message)
            if meant:
                self.assertIn(f"; {meant} is one", message)
            self.assertNotIn("required", message)

    def test_boxes(self):
        self.synth()
        run = ("vdblic_advect", "v.0001.vdb", "-o", "o.vdb", "--preroll", 0)
        for option, values in ("--bbox", ("0", "0", "0", "5", "5", "5")), ("--bbox-world", ("0", "0", "0", "0.5", "0.5", "0.5")):
            self.says(*run, option, *values)
            spaces = self.contents("o.vdb")
            self.says(*run, option, ",".join(values))
            self.assertEqual(self.contents("o.vdb"), spaces)
            for wrong in values[:5], (",".join(values[:4]),):
                self.assertIn("X Y Z X Y Z", self.fails(2, *run, option, *wrong))

    def test_extensions(self):
        self.textures()
        for command in (("vdblic_synth", "abc", "--size", 4, 4, 4, "--frames", 1), ("vdblic_noise", "--size", 4, 4, 4),
                        ("vdblic_advect", "v.0001.vdb"), ("vdblic_diff", "v.0001.vdb", "v.0001.vdb")):
            self.assertIn("output 'x.%04d' must end in .vdb", self.fails(2, *command, "-o", "x.%04d"))
            self.outputs(*command, "-o", "x.VDB")
        render = ("vdblic_render", "lic.0001.vdb", "--size", 8, 8)
        self.assertIn("must end in .exr or .png", self.fails(2, *render, "-o", "x.vdb"))
        self.assertEqual(self.outputs(*render, "-o", "r.PNG")[0].read_bytes()[1:4], b"PNG")
        self.assertEqual(self.outputs(*render, "-o", "r.Exr")[0].read_bytes()[:4], b"v/1\x01")
        self.outputs(*render, "--histogram", "h.JSON")
        self.assertIn("must end in .json or .png", self.fails(2, *render, "--histogram", "h.txt"))

    def test_broken_json(self):
        self.textures()
        (self.folder / "broken.json").write_text('{\n  "range": [0, 1],\n  "opacity": [[0, 0], [1 1]]\n}\n')
        for option in "--transfer", "--camera":
            message = self.fails(3, *self.RENDER, option, "broken.json")
            self.assertRegex(message, r"broken.json: is no JSON: line 3, column \d+: unexpected number literal")
            self.assertNotIn("exception", message)
            self.assertIn("none.json: cannot be read: No such file", self.fails(3, *self.RENDER, option, "none.json"))

    def test_truncated_files(self):
        self.synth()
        self.truncate("v.0002.vdb")
        message = self.fails(3, "vdblic_noise", "--like", "v.0002.vdb", "-o", "n.vdb")
        self.assertRegex(message, r"v.0002.vdb: .*it is truncated: it has \d+ bytes, and grid 'velocity' ends at \d+")

    # Terminals

    def on_terminal(self, command, columns):
        """What a command prints on a terminal's standard error."""
        master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        with subprocess.Popen(["sh", "-c", command], cwd=self.folder, stdin=subprocess.DEVNULL,
                              stdout=subprocess.DEVNULL, stderr=slave, env=os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"}) as run:
            os.close(slave)
            text = b""
            while True:
                try:
                    part = os.read(master, 65536)
                except OSError:
                    break
                if not part:
                    break
                text += part
        os.close(master)
        self.assertEqual(run.returncode, 0, text)
        return text.decode()

    def test_the_bar_fits_the_terminal(self):
        self.synth()
        for columns in 20, 47, 200:
            text = self.on_terminal("vdblic_advect v.%04d.vdb -o l.%04d.vdb", columns)
            shown = [line for line in text.replace("\x1b[K", "").replace("\n", "\r").split("\r") if line]
            self.assertGreater(len(shown), 2)
            self.assertLess(max(map(len, shown)), columns)
        self.assertIn("[", shown[0])

    def test_two_stages_on_one_terminal(self):
        self.synth()
        text = self.on_terminal("vdblic_advect v.%04d.vdb -o l.%04d.vdb | vdblic_render - -o i.%04d.png --size 8 8", 100)
        self.assertNotIn("\x1b[K", text)
        self.assertIn("vdblic_advect: frame 4: ", text)


if __name__ == "__main__":
    unittest.main()
