"""Shared by the command-line tests: running a tool like a user, in a fresh folder."""

import fcntl
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import termios
import time
import unittest

import numpy

BIN, SOURCE = pathlib.Path(os.environ["VDBLIC_BIN"]), pathlib.Path(__file__).resolve().parents[2]
MODULE = BIN.parent / "python"
# A sanitized one needs a sanitized Python.
HAS_MODULE = list(MODULE.glob("vdblic/_core*.so")) and os.environ.get("VDBLIC_SANITIZED") != "1"
WAKE = SOURCE / "samples/wake/wake.%04d.vdb"
# A rank waits 2 s for mpirun before it exits. On a busy machine that can be too short, and Open MPI 4.1 then says that the
# rank exited improperly, unless this is allowed. Exit statuses and signals of ranks still count.
MPI_ENVIRONMENT = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                                "OMPI_MCA_btl_vader_single_copy_mechanism": "none",  # for containers
                                "OMPI_MCA_orte_allowed_exit_without_sync": "1"}
# tests/nightly.sh sets it: every case instead of one of each kind. Nothing else reads the variable.
NIGHTLY = os.environ.get("VDBLIC_NIGHTLY") == "1"
# A shell ignores the one for what runs in its background, nohup the other.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)


def often(each, nightly):
    """How often: in the run for every push, and at night."""
    return nightly if NIGHTLY else each


nightly = unittest.skipUnless(NIGHTLY, "tests/nightly.sh runs it")


# What does not run says so in a line that begins with "skipped: "; tests/skipped.sh collects them.

def skip(reason):
    """End the whole file; CTest lists it as skipped (SKIP_RETURN_CODE)."""
    print(f"skipped: {reason}")
    sys.exit(77)


class Result(unittest.TextTestResult):
    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        print(f"\nskipped: {test.id().removeprefix('__main__.')}: {reason}", flush=True)


unittest.TextTestRunner.resultclass = Result


def peer(name, module):
    """The Python of a virtual environment that tests/peers.sh made, or None if it lacks the module."""
    folder = pathlib.Path(os.environ.get("VDBLIC_PEERS", pathlib.Path.home() / ".cache/vdblic/peers"))
    python = folder / name / "bin/python"
    has = [python, "-c", f"import importlib.util as u, sys; sys.exit(u.find_spec('{module}') is None)"]
    return python if python.exists() and subprocess.run(has).returncode == 0 else None


class LinePipe:
    """Standard output of a tool that waits in its line after the first so many, until somebody reads.

    So a run is still there when a test acts on it, however late the test is.
    """

    def __init__(self, lines, line):
        """@param line one of them; all are as long"""
        self.reading, self.writing = os.pipe()
        size = fcntl.fcntl(self.writing, fcntl.F_SETPIPE_SZ, os.sysconf("SC_PAGE_SIZE"))
        self.length = len(line) + 1
        self.before = size - lines * self.length
        os.write(self.writing, bytes(self.before))

    def lines(self):
        """How many lines are in it."""
        waiting = fcntl.ioctl(self.reading, termios.FIONREAD, bytes(4))
        return (int.from_bytes(waiting, sys.byteorder) - self.before) // self.length

    def read(self):
        """All lines to the end of the run, as text; once."""
        os.close(self.writing)
        with os.fdopen(self.reading, "rb") as lines:
            return lines.read()[self.before:].decode()

    def close(self):
        for end in self.reading, self.writing:
            os.close(end)


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

    def wait_until(self, condition, what, seconds=120, pause=0.02):
        """Wait for an event, as long as a busy machine may take."""
        deadline = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), deadline, what)
            time.sleep(pause)

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
