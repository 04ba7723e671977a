"""vdblic_film with a file of another format: vdblic_import comes first."""

import os
import re
import signal
import subprocess
import unittest

import numpy

import earth_flows
from earth_flows import wind
from support import BIN, ToolTest


class FilmOfAnotherFormat(ToolTest):
    def setUp(self):
        super().setUp()
        self.file = wind(numpy.arange(0.0, 360, 9), numpy.arange(-85.5, 90, 9))
        earth_flows.write(self.folder / "air.nc", self.file)

    def film(self, *options, name="air.nc", status=0):
        done = self.run_tool("vdblic_film", name, "-o", "flow.png", "--size", 96, 64, *options)
        self.assertEqual(done.returncode, status, done.stderr)
        return done.stderr

    def test_commands(self):
        """The three commands that the tool prints make the same still; nothing else stays."""
        text = self.film("--globe")
        self.assertEqual(self.files(), ["air.nc", "flow.png"])
        made = self.contents("flow.png")
        commands = re.findall(r"^vdblic_film:   (vdblic_.*)", text, re.MULTILINE)
        self.assertEqual([command.split()[0] for command in commands], ["vdblic_import", "vdblic_advect", "vdblic_render"])
        (self.folder / "flow.png").unlink()
        for command in commands:
            subprocess.run(["bash", "-c", command], cwd=self.folder, check=True, capture_output=True,
                           env=os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"})
        self.assertEqual(self.contents("flow.png"), made)

    def test_plane(self):
        self.film()
        plane = self.contents("flow.png")
        self.film("--globe")
        self.assertNotEqual(self.contents("flow.png"), plane)

    def test_goes_on_with_a_complete_import(self):
        """A film that fails keeps the velocity; another file or another option replaces it."""
        self.film("--globe", "--solid", "none.vdb", status=3)
        self.assertIn("flow.png.velocity", self.files())
        self.assertIn("going on with its velocity", self.film("--globe"))
        self.assertEqual(self.files(), ["air.nc", "flow.png"])
        self.film("--globe", "--solid", "none.vdb", status=3)
        self.assertNotIn("going on", self.film())
        self.film("--globe", "--solid", "none.vdb", status=3)
        self.file["u"][1][:] *= 2
        earth_flows.write(self.folder / "air.nc", self.file)
        self.assertNotIn("going on", self.film("--globe"))
        self.assertEqual(self.files(), ["air.nc", "flow.png"])

    def test_foreign_files_stay(self):
        (self.folder / "flow.png.velocity").mkdir()
        (self.folder / "flow.png.velocity/mine.txt").write_text("mine")
        self.film()
        self.assertEqual((self.folder / "flow.png.velocity/mine.txt").read_text(), "mine")

    def test_refusals(self):
        """The message is that of vdblic_import, with its status, and says where its options belong."""
        del self.file["u"][2]["units"]
        earth_flows.write(self.folder / "air.nc", self.file)
        text = self.film("--globe", status=3)
        self.assertIn("vdblic_import: air.nc:", text)
        self.assertIn("--attribute", text)
        self.assertIn("run vdblic_import and then vdblic_film on its sequence", text)
        self.assertEqual(self.files(), ["air.nc"])
        text = self.film(name="nothing.nc", status=3)
        self.assertIn("nothing.nc: no such file", text)
        self.assertNotIn("run vdblic_import", text)
        self.assertIn("--globe is of files", self.film("--globe", name="v.%04d.vdb", status=2))
        self.assertEqual(self.files(), ["air.nc"])

    def test_interruption(self):
        """A signal during the import leaves nothing."""
        process = subprocess.Popen([BIN / "vdblic_film", "air.nc", "-o", "flow.png", "--globe"], cwd=self.folder,
                                   stderr=subprocess.PIPE, text=True)
        folder = self.folder / "flow.png.velocity"
        while process.poll() is None and not folder.exists():
            pass
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signal.SIGTERM)
        self.assertEqual(self.files(), ["air.nc"])


if __name__ == "__main__":
    unittest.main()
