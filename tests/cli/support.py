"""What the command-line tests share: running a tool as a user would, in a fresh folder."""

import os
import pathlib
import subprocess
import tempfile
import unittest

BIN = pathlib.Path(os.environ["VDBLIC_BIN"])


class ToolTest(unittest.TestCase):
    """A test case with a fresh folder `self.folder`, removed afterwards, in which its tools run."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="vdblic-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_tool(self, tool, *arguments, stdin="", **options):
        """Run a tool; returns the finished process, its output as text, whatever its exit status is.

        Arguments become text. `options` go to subprocess.run: `env`, `preexec_fn`, `timeout` ...
        """
        options.setdefault("timeout", 120)
        return subprocess.run(
            [str(BIN / tool), *map(str, arguments)],
            input=stdin, text=True, capture_output=True, cwd=self.folder, **options)

    def outputs(self, tool, *arguments, **options):
        """Run a tool that must succeed; returns the paths it printed, which must all be files."""
        done = self.run_tool(tool, *arguments, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        paths = [self.folder / line for line in done.stdout.splitlines()]
        for path in paths:
            self.assertTrue(path.is_file(), f"{tool} printed {path}, which is no file")
        return paths

    def fails(self, status, tool, *arguments, **options):
        """Run a tool that must fail with an exit status and print nothing on standard output.

        Returns its message, which must be there.
        """
        done = self.run_tool(tool, *arguments, **options)
        self.assertEqual(done.returncode, status, f"{tool} {arguments}\n{done.stdout}\n{done.stderr}")
        self.assertEqual(done.stdout, "")
        self.assertNotEqual(done.stderr.strip(), "")
        return done.stderr

    def contents(self, path):
        return (self.folder / path).read_bytes()

    def printed(self, path):
        """What OpenVDB's own vdb_print says about a file's grids;"""
        command = ["vdb_print", "-l", self.folder / path]
        return subprocess.run(command, text=True, capture_output=True, check=True).stdout

    def files(self):
        """The names of everything in the folder, hidden files included."""
        return sorted(path.name for path in self.folder.iterdir())
