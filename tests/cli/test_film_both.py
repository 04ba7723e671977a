"""vdblic_film --method both: streaks in a dense texture."""

import os
import re
import shutil
import subprocess
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, ToolTest


class FilmOfBoth(ToolTest):
    def setUp(self):
        """Air that turns around the axis z and blows along x, the same everywhere: its vortex hides itself."""
        super().setUp()
        x, y = numpy.ogrid[-7.5:8, -7.5:8]
        flow = numpy.zeros((16, 16, 16, 3), numpy.float32)
        flow[..., 0] = 0.5 - 0.03 * y[..., None]
        flow[..., 1] = 0.03 * x[..., None]
        velocity = vdb.Vec3SGrid()
        velocity.name = "velocity"
        velocity.copyFromArray(flow, tolerance=(-1, -1, -1))
        velocity["velocity_unit"] = "voxel/s"
        velocity["dt"] = 1.0
        for frame in range(1, 4):
            vdb.write(str(self.folder / f"v.{frame}.vdb"), velocity)
        self.inputs = self.files()

    def film(self, output, *options, method="both", velocity="v.%d.vdb"):
        """The commands that the tool prints."""
        done = self.run_tool("vdblic_film", velocity, "-o", output, "--size", 64, 48, "--method", method, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return re.findall(r"^vdblic_film:   (vdblic_.*)", done.stderr, re.MULTILINE)

    def test_commands(self):
        """Three commands make the same film and the same still: a texture, lines of the same frames, pictures of both."""
        for output, *options in (("flow.mp4", "--seconds", 0.3, "--periodic", "x,y"), ("flow.mp4", "--fps", 6, "--seconds", 1, "--frame-velocity", 0, 0.1, 0),
                                 ("flow.png", "--preview")):
            with self.subTest(output=output, options=options):
                commands = self.film(output, *options)
                self.assertEqual(self.files(), sorted([*self.inputs, output]))  # no texture is left
                made = self.contents(output)
                self.assertEqual([command.split()[0] for command in commands], ["vdblic_advect", "vdblic_advect", "vdblic_render"])
                for command in commands:
                    subprocess.run(["bash", "-c", command], cwd=self.folder, check=True, capture_output=True,
                                   env=os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"})
                self.assertEqual(self.contents(output), made)
                for texture in self.folder.glob("flow.*"):
                    texture.unlink()

    def test_choices(self):
        """Each run has the options of the film with its method alone, and substeps; lines show the vortex, the texture what is around."""
        for option in "--periodic z", "--frame-velocity 0 0.1 0":
            for command in self.film("flow.png", *option.split())[:2]:
                self.assertIn(f" {option}", command)
        options = "--seconds", 0.3, "--periodic", "z"
        texture, lines, pictures = self.film("flow.mp4", *options)
        dense = self.film("flow.mp4", *options, method="dense")
        streaks = self.film("flow.mp4", *options, method="streaks")
        self.assertIn(" --with q", dense[0])
        self.assertEqual(texture, dense[0].replace(" --with q", ""))
        substeps = re.search(r" --substeps \d+", texture)[0]
        known = re.sub(r" --substeps \d+", "", streaks[0].replace("flow.texture.%04d", "flow.texture.lines.%04d"))
        self.assertEqual(lines.replace(substeps, ""), known)
        self.assertIn(substeps, lines)
        self.assertIn("--lines flow.texture.lines.%04d.vdb", pictures)
        for option in "--opacity-by", "--substeps":
            self.assertNotIn(option, pictures)
        both, streaks = (self.film("flow.png", "--look", "ink", method=method) for method in ("both", "streaks"))
        spacing = [float(re.search(r"--spacing (\S+)", command)[1]) for command in (both[1], streaks[0])]
        self.assertAlmostEqual(spacing[0] / spacing[1], 2, delta=0.1)  # without vortices, the texture is seen between lines
        texture, _, pictures = self.film("flow.png", "--look", "vortex")  # asks for the vortex in both
        self.assertIn(" --with q", texture)
        self.assertIn("--opacity-by q", pictures)

    def estimate(self, method):
        """The memory [MiB] and the processor time [s] that the tool tells before a large film, which is not made."""
        process = subprocess.Popen([BIN / "vdblic_film", "v.%d.vdb", "-o", "flow.mp4", "--size", "640", "480", "--seconds", "20",
                                    "--method", method, "-v"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        with process:
            found = next(filter(None, (re.search(r"film takes about (\S+) MiB of memory and (\d+) s", line) for line in process.stderr)))
            process.kill()
        shutil.rmtree(self.folder / "flow.mp4.textures", ignore_errors=True)
        return float(found[1]), int(found[2])

    def test_estimates(self):
        """A film of both takes the time of each, but for a sixth that fewer rays to a pixel save, and the memory of the larger one."""
        (dense_memory, dense), (lines_memory, lines), (memory, seconds) = map(self.estimate, ("dense", "streaks", "both"))
        self.assertGreater(seconds, 0.84 * dense + lines)
        self.assertGreater(min(dense, lines), 10)
        self.assertGreaterEqual(memory, 0.9 * max(dense_memory, lines_memory))

    def test_one_file(self):
        """A flow that stays as it is moves on in both."""
        texture, lines, _ = self.film("flow.mp4", "--seconds", 0.5, velocity="v.1.vdb")
        for command in texture, lines:
            self.assertIn("--steady-frames 12 ", command)

    def test_resume(self):
        """After a kill while lines are made, the finished texture is not made again, and the film is the same."""
        self.film("whole.mp4", "--seconds", 1.5)
        process = subprocess.Popen([BIN / "vdblic_film", "v.%d.vdb", "-o", "flow.mp4", "--size", "64", "48", "--method", "both", "--seconds",
                                    "1.5"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.wait_until(lambda: len(list(self.folder.glob("flow.mp4.textures/texture.lines.*.vdb"))) > 2, "no lines")
        process.kill()
        process.wait()
        done = self.run_tool("vdblic_film", "v.%d.vdb", "-o", "flow.mp4", "--size", 64, 48, "--method", "both", "--seconds", 1.5, "-v")
        self.assertEqual(done.stdout, "flow.mp4\n", done.stderr[-1000:])
        self.assertIn("checkpoint.texture.vdb: 36 textures are done", done.stderr)
        self.assertEqual(self.contents("flow.mp4"), self.contents("whole.mp4"))
        self.assertEqual(self.files(), sorted([*self.inputs, "flow.mp4", "whole.mp4"]))

    def test_pages_show_lines_alone(self):
        told = self.fails(2, "vdblic_film", "v.%d.vdb", "-o", "flow.html", "--method", "both")
        self.assertIn("--method both makes no lines alone", told)
        self.assertEqual(self.files(), self.inputs)


if __name__ == "__main__":
    unittest.main()
