"""Shared by the command-line tests: running a tool like a user, in a fresh folder."""

import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy

BIN = pathlib.Path(os.environ["VDBLIC_BIN"])
# A shell ignores the one for what runs in its background, nohup the other.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)


def skip(reason):
    """End the whole file; CTest lists it as skipped (SKIP_RETURN_CODE)."""
    print(f"skipped: {reason}")
    sys.exit(77)


def peer(name, module):
    """The Python of a virtual environment that tests/peers.sh made, or None if it lacks the module."""
    folder = pathlib.Path(os.environ.get("VDBLIC_PEERS", pathlib.Path.home() / ".cache/vdblic/peers"))
    python = folder / name / "bin/python"
    has = [python, "-c", f"import importlib.util as u, sys; sys.exit(u.find_spec('{module}') is None)"]
    return python if python.exists() and subprocess.run(has).returncode == 0 else None


class ToolTest(unittest.TestCase):
    """A test case whose tools run in a fresh folder `self.folder`, removed afterwards."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="vdblic-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_tool(self, tool, *arguments, stdin="", **options):
        """Run a tool; returns the finished process with its output as text, for any exit status.

        Arguments become text. `options` go to subprocess.run: `env`, `preexec_fn`, `timeout` ...
        """
        options.setdefault("timeout", 120)
        return subprocess.run(
            [str(BIN / tool), *map(str, arguments)],
            input=stdin, text=True, capture_output=True, cwd=self.folder, **options)

    def outputs(self, tool, *arguments, **options):
        """Run a tool that must succeed; returns the printed paths, which must all be files."""
        done = self.run_tool(tool, *arguments, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        paths = [self.folder / line for line in done.stdout.splitlines()]
        for path in paths:
            self.assertTrue(path.is_file(), f"{tool} printed {path}, which is not a file")
        return paths

    def fails(self, status, tool, *arguments, **options):
        """Run a tool that must fail with this exit status, print nothing on standard output and give a message.

        Returns the message.
        """
        done = self.run_tool(tool, *arguments, **options)
        self.assertEqual(done.returncode, status, f"{tool} {arguments}\n{done.stdout}\n{done.stderr}")
        self.assertEqual(done.stdout, "")
        self.assertNotEqual(done.stderr.strip(), "")
        return done.stderr

    def wait_until(self, condition, what, seconds=120):
        """Wait for an event, as long as a busy machine may take."""
        deadline = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), deadline, what)
            time.sleep(0.02)

    def contents(self, path):
        return (self.folder / path).read_bytes()

    def printed(self, path):
        """The output of OpenVDB's own vdb_print about a file's grids."""
        command = ["vdb_print", "-l", self.folder / path]
        return subprocess.run(command, text=True, capture_output=True, check=True).stdout

    def files(self):
        """The names of all files and folders in the folder, hidden ones included."""
        return sorted(path.name for path in self.folder.iterdir())


class RenderTest(ToolTest):
    """A test case of vdblic_render."""

    def renders(self, *arguments, **options):
        return [path.name for path in self.outputs("vdblic_render", *arguments, **options)]

    def refuses(self, status, *arguments, **options):
        before = self.files()
        message = self.fails(status, "vdblic_render", *arguments, **options)
        self.assertEqual(self.files(), before, arguments)
        return message

    def run_peer(self, *command):
        done = subprocess.run(list(map(str, command)), cwd=self.folder, text=True, capture_output=True)
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    def pixels(self, name, *channels):
        """The channels of an .exr as arrays, by OpenImageIO."""
        text = self.run_peer("oiiotool", "-v", "--dumpdata", name)
        names = re.sub(r" \(\w+\)", "", re.search(r"channel list: (.*)", text)[1]).split(", ")
        pixels = re.findall(r"Pixel \((\d+), (\d+)\): (.*)", text)
        values = numpy.array([values.split() for *_, values in pixels], float).reshape(int(pixels[-1][1]) + 1, -1, len(names))
        return [values[..., names.index(channel)] for channel in channels]
