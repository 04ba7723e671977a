"""vdblic_film: one command from velocity to a film or a still."""

import os
import re
import resource
import shutil
import signal
import subprocess
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, ToolTest


SECONDS = 3  # of a film that is stopped halfway


class Film(ToolTest):
    def setUp(self):
        super().setUp()
        self.outputs("vdblic_synth", "tornado", "-o", "v.%04d.vdb", "--size", 24, 24, 24, "--frames", "1-5")

    def film(self, output, *options, status=0, **more):
        """Run the tool on the sequence; returns its messages."""
        done = self.run_tool("vdblic_film", "v.%04d.vdb", "-o", output, "--size", 96, 64, *options, **more)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertEqual(done.stdout, f"{output}\n" if status == 0 else "")
        return done.stderr

    def pictures(self, name):
        """The number of a film's pictures, as ffmpeg counts them, and its rate."""
        told = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries",
                               "stream=nb_read_frames,r_frame_rate", "-of", "default=nw=1:nk=1", self.folder / name],
                              text=True, capture_output=True, check=True).stdout.split()
        return int(told[1]), told[0]

    def velocities(self):
        return [f"v.{frame:04}.vdb" for frame in range(1, 6)]

    def test_length(self):
        """A film has as many pictures as its seconds need, whether the sequence is longer or shorter; nothing else stays."""
        for seconds, options in (1, []), (0.25, []), (3, ["--orbit", 0.1]), (1, ["--method", "dense"]):
            with self.subTest(seconds=seconds, options=options):
                self.film("flow.mp4", "--seconds", seconds, *options)
                self.assertEqual(self.pictures("flow.mp4"), (round(seconds * 24), "24/1"))
                self.assertEqual(self.files(), sorted([*self.velocities(), "flow.mp4"]))

    def test_default_length_and_preview(self):
        text = self.film("flow.mp4")
        told = int(re.search(r"(\d+) pictures", text)[1])
        pictures, rate = self.pictures("flow.mp4")
        self.assertEqual((pictures, rate), (told, "24/1"))
        self.assertGreaterEqual(pictures, 120)
        self.film("preview.mp4", "--preview")
        fewer, rate = self.pictures("preview.mp4")
        self.assertEqual(rate, "12/1")
        self.assertLess(fewer, 0.6 * pictures)

    def test_commands(self):
        """The two commands that the tool prints make the same film and the same still."""
        environment = os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"}
        for output, *options in (("flow.mp4", "--seconds", 1, "--look", "ink"), ("flow.png", "--periodic", "x,y"),
                                 ("flow.png", "--frame-velocity", -0.5, 0, 0)):
            with self.subTest(output=output, options=options):
                text = self.film(output, *options)
                made = self.contents(output)
                (self.folder / output).unlink()
                commands = re.findall(r"^vdblic_film:   (vdblic_.*)", text, re.MULTILINE)
                self.assertEqual([command.split()[0] for command in commands], ["vdblic_advect", "vdblic_render"])
                for command in commands:
                    subprocess.run(["bash", "-c", command], cwd=self.folder, env=environment, check=True,
                                   capture_output=True)
                self.assertEqual(self.contents(output), made)
                for texture in self.folder.glob("flow.texture.*"):
                    texture.unlink()

    def test_threads(self):
        self.film("one.mp4", "--seconds", 1, "--threads", 1)
        self.film("two.mp4", "--seconds", 1, "--threads", 2)
        self.assertEqual(self.contents("one.mp4"), self.contents("two.mp4"))

    def test_still(self):
        self.film("flow.png")
        self.assertEqual(self.contents("flow.png")[16:24], bytes([0, 0, 0, 96, 0, 0, 0, 64]))
        self.assertEqual(self.files(), sorted([*self.velocities(), "flow.png"]))

    def test_steady(self):
        """A single file becomes a film of a flow that stays as it is."""
        for frame in range(2, 6):
            (self.folder / f"v.{frame:04}.vdb").unlink()
        done = self.run_tool("vdblic_film", "v.0001.vdb", "-o", "steady.mp4", "--size", 64, 64, "--seconds", 1)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.pictures("steady.mp4")[0], 24)

    def start(self, *options):
        return subprocess.Popen([BIN / "vdblic_film", "v.%04d.vdb", "-o", "flow.mp4", "--size", "96", "64", "--seconds",
                                 str(SECONDS), *options], cwd=self.folder, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)

    def test_resume(self):
        """After a stop or a kill the same command makes the same film; a stop leaves whole textures only."""
        self.film("whole.mp4", "--seconds", SECONDS)
        textures = self.folder / "flow.mp4.textures"
        for name in signal.SIGINT, signal.SIGKILL:
            with self.subTest(signal=name):
                process = self.start()
                self.wait_until(lambda: len(list(textures.glob("texture.*.vdb"))) > 4, "no texture")
                process.send_signal(name)
                _, text = process.communicate(timeout=60)
                self.assertEqual(process.returncode, -name)
                self.assertFalse((self.folder / "flow.mp4").exists())
                self.assertTrue(textures.is_dir())
                if name == signal.SIGINT:
                    self.assertIn("flow.mp4.textures: keeps the finished textures", text)
                self.assertIn("flow.mp4.textures: going on with its textures", self.film("flow.mp4", "--seconds", SECONDS))
                self.assertEqual(self.contents("flow.mp4"), self.contents("whole.mp4"))
                self.assertEqual(self.files(), sorted([*self.velocities(), "flow.mp4", "whole.mp4"]))
                (self.folder / "flow.mp4").unlink()

    def test_two_runs_do_not_mix(self):
        """One that finds another at work leaves its textures alone."""
        process = self.start()
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        textures = self.folder / "flow.mp4.textures"
        self.wait_until(lambda: list(textures.glob("texture.*.vdb")), "no texture")
        process.send_signal(signal.SIGSTOP)
        os.waitpid(process.pid, os.WUNTRACED)  # all of its threads have stopped
        (self.folder / "here").symlink_to(".")
        before = sorted(textures.iterdir())
        for output in "flow.mp4", "./flow.mp4", "here/flow.mp4":
            for seconds in 1, SECONDS:
                text = self.film(output, "--seconds", seconds, status=2)
                self.assertIn(f"{output}: another run is writing these outputs, process {process.pid} on ", text)
                self.assertEqual(sorted(textures.iterdir()), before)
        process.kill()
        self.assertIn("are made again", self.film("flow.mp4", "--seconds", 1))
        self.assertEqual(self.files(), sorted([*self.velocities(), "flow.mp4", "here"]))

    def test_other_options_and_inputs(self):
        """Textures of other options or of changed inputs are not taken over."""
        self.film("whole.mp4", "--seconds", 1)
        for change in "options", "inputs":
            with self.subTest(change=change):
                process = self.start()
                textures = self.folder / "flow.mp4.textures"
                self.wait_until(lambda: list(textures.glob("texture.*.vdb")), "no texture")
                process.kill()
                process.communicate(timeout=60)
                if change == "inputs":
                    self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 24, 24, 24, "--frames", "1-5")
                seconds = 1 if change == "options" else SECONDS
                self.assertIn("are made again", self.film("flow.mp4", "--seconds", seconds))
                if change == "options":
                    self.assertEqual(self.contents("flow.mp4"), self.contents("whole.mp4"))
                self.assertFalse(textures.exists())

    def test_bad_input(self):
        before = self.files()
        base = ("v.%04d.vdb", "-o", "flow.mp4")
        for status, arguments, message in (
                (2, ("v.%04d.vdb", "-o", "flow.avi"), "must end in .mp4 or .png or .html"),
                (2, (*base, "--look", "none"), "--look"),
                (2, (*base, "--method", "uflic"), "--method"),
                (2, (*base, "--seconds", 0), "--seconds"),
                (2, (*base, "--size", 1, 1), "--size"),
                (2, ("-", "-o", "flow.mp4"), "standard input"),
                (2, (*base, "--seconds", 300), "5 frames make a film of 42.7 s at most"),
                (2, ("v.%04d.vdb", "-o", "flow.png", "--seconds", 1), "--seconds"),
                (2, (*base, "--max-memory", "1M"), "--max-memory"),
                (2, ("v.%04d.vdb", "-o", "flow.html", "--method", "dense"), "--method dense makes no lines"),
                (2, ("v.%04d.vdb", "-o", "flow.html", "--orbit", 1), "are of films"),
                (2, ("v.%04d.vdb", "-o", "flow.html", "--look", "ink"), "are of pictures"),
                (2, ("v.%04d.vdb", "-o", "flow.html", "--solid-color", 1, 1, 1), "are of pictures"),
                (3, ("none.%04d.vdb", "-o", "flow.mp4"), "none."),
                (4, ("v.%04d.vdb", "-o", "none/flow.mp4"), "none")):
            with self.subTest(arguments=arguments):
                self.assertIn(message, self.fails(status, "vdblic_film", *arguments))
                self.assertEqual(self.files(), before)
        self.outputs("vdblic_noise", "-o", "noise.vdb", "--size", 8, 8, 8)
        self.assertIn("holds no velocity", self.fails(3, "vdblic_film", "noise.vdb", "-o", "flow.mp4"))
        damaged = self.contents("v.0003.vdb")
        (self.folder / "v.0003.vdb").write_bytes(damaged[:len(damaged) // 2])
        self.assertIn("v.0003.vdb", self.fails(3, "vdblic_film", *base))
        self.assertEqual(self.files(), sorted([*before, "noise.vdb"]))

    def choices(self, speeds, hole=False, turns=False):
        """The commands for a still of a flow along x with these speeds [voxels a frame] along z, or around z too."""
        flow = numpy.zeros((24, 24, len(speeds), 3), numpy.float32)
        flow[..., 0] = numpy.multiply(speeds, 24)
        if turns:
            x, y = numpy.ogrid[-11.5:12, -11.5:12]
            flow[..., 0] -= y[..., None]
            flow[..., 1] += x[..., None]
        grid = vdb.Vec3SGrid()
        grid.name = "velocity"
        grid.copyFromArray(flow, tolerance=(-1, -1, -1))
        if hole:
            grid.fill((8, 8, 0), (12, 12, 12), (0, 0, 0), active=False)
        grid["velocity_unit"] = "voxel/s"
        grid.transform = vdb.createLinearTransform(0.5)
        vdb.write(str(self.folder / "one.vdb"), grid)
        done = self.run_tool("vdblic_film", "one.vdb", "-o", "one.png", "--size", 96, 64)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr

    def test_choices(self):
        """An even flow shows its vortices, a body is drawn, a flat domain is stretched; others get none of this.
        A laminar flow has no vortices: opacity by q would leave nothing to see."""
        even, uneven = [2.0] * 24, [0.1] * 12 + [2.0] * 12
        sheared = [1.0 + i / 12 for i in range(24)]
        for options, text in (({"--opacity-by q"}, self.choices(even, turns=True)), (set(), self.choices(uneven)),
                              (set(), self.choices(even)), (set(), self.choices(sheared)),
                              ({"--opacity-by q", "--solid domain"}, self.choices(even, hole=True, turns=True)),
                              ({"--stretch 1 1 3"}, self.choices([2.0] * 2, turns=True))):
            self.assertNotIn("the images show nothing", text)
            every = {"--opacity-by q", "--solid domain", "--stretch 1 1 3"}
            self.assertEqual({option for option in every if option in text}, options, text)

    def test_globe(self):
        """Streaks begin within the rims of a shell around the Earth, which is solid."""
        self.outputs("vdblic_synth", "rossby", "-o", "g.%04d.vdb", "--frames", "1-3", "--voxel-size", 0.4)
        for options, part in ((), "--solid g.0001.vdb:solid --solid-color"), (("--solid", "domain"), "--solid domain"):
            done = self.run_tool("vdblic_film", "g.%04d.vdb", "-o", "globe.png", "--size", 96, 64, *options)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("--emit g.0001.vdb:rim", done.stderr)
            self.assertIn(part, done.stderr)
            self.assertIn("--carry speed", done.stderr)
            self.assertIn("--color-by speed", done.stderr)
            self.assertNotIn("--opacity-by", done.stderr)  # Q is that of the shear in the shell

    def test_view_legend_and_frames(self):
        """What a user names is in the commands; the legend is there unless the film is plain."""
        text = self.film("flow.png", "--view", "top", "--frames", "2-4")
        for part in "--view top", "--annotate colorbar,time,scalebar", "--frames 3":
            self.assertIn(part, text)
        self.assertIn("--angles 30 -60.5", self.film("flow.png", "--angles", 30, -60.5))
        self.assertIn("--angles", self.film("flow.png", "--angles", 30, 60, "--view", "top", status=2))
        self.assertNotIn("--annotate", self.film("flow.png", "--plain"))
        text = self.film("flow.png", "--solid", "v.0001.vdb:velocity", "--solid-color", 1, 0, 0, status=3)
        self.assertIn("--solid v.0001.vdb:velocity --solid-color 1 0 0", text)
        self.film("flow.mp4", "--fps", 6, "--seconds", 2)
        self.assertEqual(self.pictures("flow.mp4"), (12, "6/1"))
        self.assertIn("--frames 1-2", self.film("flow.mp4", "--frames", "1-2", "--seconds", 2))
        self.assertEqual(self.pictures("flow.mp4"), (48, "24/1"))  # of two frames, by many substeps

    def test_full_disk(self):
        before = self.files()
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))
        text = self.film("flow.mp4", "--seconds", 1, status=4, preexec_fn=limit)
        self.assertIn("cannot be written", text)
        self.assertEqual(self.files(), before)

    def page_by(self, script):
        """Start a film into a page, by a vdblic_film beside a vdblic_export that is this script; without one, if empty."""
        tool = self.folder / "tools/vdblic_film"
        tool.parent.mkdir(exist_ok=True)
        shutil.copy(BIN / "vdblic_film", tool)
        if script:
            (tool.parent / "vdblic_export").write_text(f"#!/bin/sh\n{script}\n")
            (tool.parent / "vdblic_export").chmod(0o755)
        process = subprocess.Popen([tool, "v.%04d.vdb", "-o", "flow.html", "--size", "96", "64"], cwd=self.folder, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=os.environ | {"PATH": "/usr/bin:/bin"})
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def test_page_without_the_tool(self):
        """That is told before any work."""
        process = self.page_by("")
        _, text = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 2)
        self.assertIn("vdblic_export is missing, beside this program and on PATH", text)
        self.assertEqual(self.files(), ["tools", *self.velocities()])

    def test_page_by_a_tool_that_fails(self):
        """Its message and its status are passed on, and the textures stay."""
        for status, ends in (2, "exit 2"), (3, "exit 3"), (4, "exit 4"), (3, "kill -9 $$"), (5, "exit 1"):
            with self.subTest(ends=ends):
                process = self.page_by("echo 'vdblic_export: error: s.vdb: is odd' >&2; "
                                       f"echo 'vdblic_export: warning: and more' >&2; printf 'last word' >&2; {ends}")
                told, text = process.communicate(timeout=60)
                self.assertEqual((process.returncode, told), (status, ""))
                self.assertIn("vdblic_export: s.vdb: is odd", text)
                self.assertIn("vdblic_film: warning: and more\n", text)
                self.assertIn("vdblic_film: last word\n", text)
                self.assertIn("flow.html.textures: keeps the finished textures", text)
                self.assertEqual(self.files(), ["flow.html.textures", "tools", *self.velocities()])

    def test_page_is_interrupted(self):
        """A stop ends the tool that makes the page, too; the same command goes on with the textures."""
        process = self.page_by("echo $$ > begun; exec sleep 1000")
        self.wait_until(lambda: (self.folder / "begun").exists() and self.contents("begun"), "not begun")
        process.send_signal(signal.SIGINT)
        _, text = process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signal.SIGINT, text)
        with self.assertRaises(ProcessLookupError):
            os.kill(int(self.contents("begun")), 0)
        self.assertEqual(self.files(), ["begun", "flow.html.textures", "tools", *self.velocities()])
        process = self.page_by('echo page > "$3"')
        told, text = process.communicate(timeout=60)
        self.assertEqual((process.returncode, told), (0, "flow.html\n"), text)
        self.assertIn("going on with its textures", text)
        self.assertEqual(self.files(), ["begun", "flow.html", "tools", *self.velocities()])

    def test_folder_of_others(self):
        """A folder with other files under the textures' name is left as it is."""
        (self.folder / "flow.mp4.textures").mkdir()
        (self.folder / "flow.mp4.textures/texture.mine").write_text("mine")
        self.assertIn("not of a film", self.film("flow.mp4", status=4))
        self.assertEqual(self.contents("flow.mp4.textures/texture.mine"), b"mine")


if __name__ == "__main__":
    unittest.main()
