"""Man pages and completions of shells say what the tools say of themselves."""

import gzip
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, SOURCE, ToolTest

MANUALS = SOURCE / "tools/packaging/manuals.py"


class Manuals(ToolTest):
    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.TemporaryDirectory(prefix="vdblic-")
        cls.addClassCleanup(cls.made.cleanup)
        cls.share = pathlib.Path(cls.made.name)
        subprocess.run([sys.executable, MANUALS, BIN, cls.share], check=True)

    def help_of(self, tool):
        return subprocess.run([BIN / tool, "--help"], text=True, capture_output=True, check=True).stdout

    def completed(self, *words):
        """What bash offers for the last word."""
        script = self.share / f"bash-completion/completions/{words[0]}"
        quoted = " ".join(f"'{word}'" for word in words)
        lines = f"source {script}; COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; _{words[0]}; echo ${{COMPREPLY[@]}}"
        done = subprocess.run(["bash", "-c", lines], text=True, capture_output=True, check=True, cwd=self.folder,
                              env=os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"})
        return done.stdout.split()

    def test_every_option_is_in_its_manual(self):
        for page in sorted((self.share / "man/man1").iterdir()):
            tool = page.name.removesuffix(".1.gz")
            text = gzip.decompress(page.read_bytes()).decode()
            options = re.findall(r"^  (-\S+)", self.help_of(tool), re.MULTILINE)
            self.assertTrue(options)
            offered = self.completed(tool, "-")
            for name in (name for names in options for name in names.split(",")):
                with self.subTest(tool=tool, option=name):
                    self.assertIn("\\fB" + name.replace("-", "\\-") + "\\fR", text)
                    self.assertIn(name, offered)

    @unittest.skipUnless(shutil.which("groff"), "groff is not installed")
    def test_manuals_are_well_formed(self):
        for page in (self.share / "man/man1").iterdir():
            done = subprocess.run(["groff", "-man", "-Tutf8", "-ww"], input=gzip.decompress(page.read_bytes()),
                                  capture_output=True, check=True)
            self.assertEqual(done.stderr.decode(), "", page.name)

    def test_choices_and_grids_are_completed(self):
        grids = []
        for name in "density", "speed":
            grids.append(vdb.FloatGrid())
            grids[-1].name = name
            grids[-1].copyFromArray(numpy.ones((2, 2, 2), numpy.float32))
        vdb.write(str(self.folder / "lic.vdb"), grids=grids)
        self.assertEqual(self.completed("vdblic_render", "lic.vdb", "--look", "v"), ["vortex"])
        self.assertIn("viridis", self.completed("vdblic_render", "lic.vdb", "--colormap", ""))
        self.assertEqual(self.completed("vdblic_render", "lic.vdb", "--color-by", ""), ["density", "speed"])
        self.assertEqual(self.completed("vdblic_render", "--output", "l"), ["lic.vdb"])

    def test_shells_read_their_completions(self):
        for shell, folder in ("bash", "bash-completion/completions"), ("zsh", "zsh/site-functions"), \
                ("fish", "fish/vendor_completions.d"):
            if not shutil.which(shell):
                continue
            for script in (self.share / folder).iterdir():
                with self.subTest(shell=shell, script=script.name):
                    subprocess.run([shell, "-n", script], check=True)


if __name__ == "__main__":
    unittest.main()
