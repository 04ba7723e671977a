"""Every tool on damaged files: no crash, no hang, no more memory than allowed, status 0 or 3, no partial outputs.

For every push each file goes through one tool; tests/nightly.sh runs more files through every tool that may read them. A
file is known by its number: the first ones are the same in every run.
"""

import concurrent.futures
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, NIGHTLY, ToolTest, often

FILES = often(300, 2000)
MEMORY = 300 << 20
SUPPORT = os.environ["VDBLIC_TEST_SUPPORT"]
SANITIZED = os.environ.get("VDBLIC_SANITIZED") == "1"
LIMIT = 100 if SANITIZED else 10  # seconds

FORMATS = [b"", b"\0" * 5000, b"#!/bin/sh\necho no volume\n", b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 8,
           b"v/1\x01\x02\0\0\0channels\0chlist\0" + b"\0" * 900, b"\x1f\x8b\x08\0" + b"x" * 700,
           b"\x7fELF\x02\x01\x01" + b"\0" * 3000, b"NanoVDB0" + b"\x20\x00\x03\x00" * 400]


def grids(shape=(18, 13, 11)):
    """A fog volume with tiles and holes, and a velocity."""
    x, y, z = numpy.meshgrid(*(numpy.arange(n, dtype=float) for n in shape), indexing="ij")
    fog = vdb.FloatGrid()
    fog.name = "density"
    fog.gridClass = vdb.GridClass.FOG_VOLUME
    fog.copyFromArray((0.5 + 0.5 * numpy.sin(x * y + z)).astype(numpy.float32), ijk=(-3, 4, 0), tolerance=-1)
    fog.fill((64, 64, 64), (79, 71, 71), 0.25)
    flow = vdb.Vec3SGrid()
    flow.name = "velocity"
    flow["dt"] = 1.0
    array = numpy.stack([numpy.sin(y), numpy.cos(x + z), 0.1 * z], axis=-1).astype(numpy.float32)
    flow.copyFromArray(numpy.ascontiguousarray(array), ijk=(-3, 4, 0), tolerance=(-1, -1, -1))
    half = flow.deepCopy()
    half.saveFloatAsHalf = True
    return {"fog": [fog], "flow": [flow], "half": [half], "both": [flow, fog]}


class Originals:
    """Undamaged files of every kind: name → bytes."""

    def __init__(self, folder):
        self.files = {}
        for name, content in grids().items():
            vdb.write(str(folder / f"{name}.vdb"), grids=content, metadata={"note": "a test"})
        subprocess.run([f"{SUPPORT}/write_points", folder / "points.vdb", folder / "points_none.vdb"], check=True)
        for name in "fog", "flow":  # uncompressed: a changed byte changes a value
            self.recode(folder, name, "none")
        self.recode(folder, "fog", "zip")
        subprocess.run([BIN / "vdblic_synth", "abc", "-o", "ours.vdb", "--size", "16", "8", "8", "--frames", "1"],
                       cwd=folder, check=True, capture_output=True)
        for path in sorted(folder.glob("*.vdb")):
            self.files[path.stem] = path.read_bytes()

    @staticmethod
    def recode(folder, name, codec):
        command = ["vdb_tool", "-read", f"{name}.vdb", "-write", f"codec={codec}", f"{name}_{codec}.vdb"]
        subprocess.run(command, cwd=folder, capture_output=True, check=True)

    def mutated(self, number):
        """Damaged file number `number`: its kind and its bytes. Most damage is in the header."""
        choice = random.Random(number)
        kind = choice.choice(sorted(self.files))
        data = bytearray(self.files[kind])
        what = choice.random()
        header = min(len(data), 1500)
        if what < 0.2:
            del data[choice.randrange(len(data)):]
        elif what < 0.6:
            data[choice.randrange(header)] ^= choice.randrange(1, 256)
        elif what < 0.75:
            data[choice.randrange(len(data))] ^= choice.randrange(1, 256)
        elif what < 0.85:
            at = choice.randrange(len(data) - 8) if choice.random() < 0.5 else choice.randrange(header)
            data[at:at + 4] = choice.choice([b"\xff" * 4, b"\0" * 4, b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0\0\x10\0"])
        elif what < 0.95:
            other = self.files[choice.choice(sorted(self.files))]
            cut, begin = choice.randrange(len(data)), choice.randrange(len(other))
            data[cut:] = other[begin if choice.random() < 0.5 else min(cut, len(other)):]
        else:
            data = bytearray(choice.choice(FORMATS))
        return kind, bytes(data)


def commands(kind):
    """The commands that read a damaged file bad.vdb of this kind; their other files are undamaged."""
    small = ("--size", "24", "16")
    few = ("--samples", "2000")
    flow = (("vdblic_advect", "bad.vdb", "-o", "out.vdb", "--preroll", "1"),
            ("vdblic_coherence", "bad.vdb", "fog.vdb", *few))
    fog = (("vdblic_render", "bad.vdb", "-o", "out.png", *small), ("vdblic_coherence", "flow.vdb", "bad.vdb", *few),
           ("vdblic_advect", "flow.vdb", "-o", "out.vdb", "--preroll", "0", "--mask", "bad.vdb"),
           ("vdblic_advect", "flow.vdb", "-o", "out.vdb", "--preroll", "0", "--noise", "bad.vdb:density"))
    any_kind = (("vdblic_noise", "-o", "out.vdb", "--like", "bad.vdb"), ("vdblic_info", "bad.vdb", "--values"),
                ("vdblic_diff", "bad.vdb", f"{kind}.vdb", "-o", "out.vdb"))
    every = any_kind + (fog if "fog" in kind else flow if kind != "both" else flow + fog)
    return every + fog if "points" in kind else every


class HostileFiles(ToolTest):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="vdblic-")
        cls.addClassCleanup(folder.cleanup)
        cls.undamaged = pathlib.Path(folder.name)
        cls.originals = Originals(cls.undamaged)

    def complaint(self, command, data):
        """Run a tool on a damaged file in a folder of its own; returns what went wrong, or None."""
        with tempfile.TemporaryDirectory(dir=self.folder) as name:
            folder = pathlib.Path(name)
            (folder / "bad.vdb").write_bytes(data)
            for argument in command:
                if (self.undamaged / argument).is_file():
                    os.link(self.undamaged / argument, folder / argument)
            before = set(folder.iterdir())
            limits = [] if SANITIZED else ["--max-memory", str(MEMORY)]
            started = time.monotonic()
            with open(folder / "messages", "w+", encoding="utf-8", errors="replace") as messages:
                process = subprocess.Popen([BIN / command[0], *command[1:], "--threads", "1", *limits], cwd=folder,
                                           stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=messages)
                killer = threading.Timer(12 * LIMIT, os.kill, (process.pid, signal.SIGKILL))
                killer.start()
                _, status, usage = os.wait4(process.pid, 0)
                process.returncode = status
                killer.cancel()
                messages.seek(0)
                said = messages.read()
            (folder / "messages").unlink()
            code = os.waitstatus_to_exitcode(status)
            left = {path.name for path in set(folder.iterdir()) - before}
            allowed = {0, 1, 3} if command[0] == "vdblic_diff" else {0, 3}
            if SANITIZED and re.search("AddressSanitizer: (allocator is out of memory|requested allocation size)", said):
                return None  # a build without sanitizers has an exception here
            if code not in allowed:
                return f"status {code}: {said}"
            if usage.ru_utime + usage.ru_stime > LIMIT:
                return f"{time.monotonic() - started:.1f} s"
            if usage.ru_maxrss << 10 > MEMORY and not SANITIZED:
                return f"{usage.ru_maxrss >> 10} MiB"
            if left and (code == 3 or left - {"out.vdb", "out.png"}):
                return f"status {code}, left behind: {left}"
            if code == 3 and ("bad.vdb" not in said or len(said) > 1500):
                return f"an unhelpful message: {said}"
            return None

    def test_mutations(self):
        jobs = []
        for number in range(FILES):
            kind, _ = self.originals.mutated(number)
            ways = commands(kind)
            jobs += [(number, way) for way in (ways if NIGHTLY else [ways[number % len(ways)]])]
        complaints = []
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            # Each job makes its own file: the peak memory of a child starts at the memory of this process.
            runs = {pool.submit(lambda number, way: self.complaint(way, self.originals.mutated(number)[1]), *job): job
                    for job in jobs}
            for run in concurrent.futures.as_completed(runs):
                if run.result():
                    complaints.append((*runs[run], run.result()))
        listed = "".join(f"\n{number}, {' '.join(way)}: {complaint}" for number, way, complaint in sorted(complaints))
        self.assertFalse(complaints, f"{len(complaints)} of {len(jobs)} runs:{listed}")

    @unittest.skipIf(SANITIZED, "a sanitizer tells of the crash first")
    def test_a_file_that_crashes_openvdb(self):
        """Every tool ends with a message; a program with the module ends, as docs/CONTRIBUTING.md says."""
        data = bytearray(self.originals.files["points"])
        length = data.index(b"mass") + 24  # of a leaf's values of an attribute, which OpenVDB copies as it is told
        data[length:length + 4] = (1 << 24).to_bytes(4, "little")
        for path in self.undamaged.iterdir():
            os.link(path, self.folder / path.name)
        (self.folder / "bad.vdb").write_bytes(data)
        numpy.save(self.folder / "v.npy", numpy.ones((4, 4, 4, 3)))
        before = self.files()
        every = commands("points")
        if (BIN / "vdblic_export").exists():
            every += (("vdblic_export", "bad.vdb", "-o", "out.npz"), ("vdblic_export", "bad.vdb", "-o", "out.vti"),
                      ("vdblic_export", "bad.vdb", "-o", "out.vdb", "--levels", "1"),
                      ("vdblic_import", "v.npy", "--layout", "xyzc", "-o", "out.vdb", "--like", "bad.vdb"))
        for command in every:
            with self.subTest(command=command):
                message = self.fails(3, *command)
                self.assertEqual(message.count("error: "), 1, message)
                self.assertIn("bad.vdb: cannot be read: it is damaged; OpenVDB crashed on it", message)
                self.assertEqual(self.files(), before)
        if list((BIN.parent / "python").glob("vdblic/_core*.so")):
            read = "import sys; sys.path.insert(0, sys.argv[1]); import vdblic; vdblic.read('bad.vdb')"
            run = subprocess.run([sys.executable, "-c", read, BIN.parent / "python"], cwd=self.folder, capture_output=True)
            self.assertIn(run.returncode, (-signal.SIGSEGV, -signal.SIGABRT), run.stderr)

    def test_every_tool_has_handlers_of_crashes(self):
        """Also those in Python. A crash outside of a parser stays one."""
        crashes = (signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGILL, signal.SIGABRT, signal.SIGXCPU)
        for tool, output in (("vdblic_advect", "a.%04d.vdb"), ("vdblic_render", "r.%04d.png"), ("vdblic_export", "e.%04d.npz"),
                             ("vdblic_import", "i.%04d.vdb")):
            with self.subTest(tool=tool):
                run = subprocess.Popen([BIN / tool, "-", "-o", output], cwd=self.folder, stdin=subprocess.PIPE,
                                       stderr=subprocess.PIPE)
                self.addCleanup(run.kill)
                status = pathlib.Path(f"/proc/{run.pid}/status")

                def caught():
                    mask = re.search(r"SigCgt:\s*(\w+)", status.read_text(encoding="ascii"))[1]
                    return all(int(mask, 16) >> (number - 1) & 1 for number in (*crashes, signal.SIGTERM))

                self.wait_until(caught, "not all signals have handlers")
                run.send_signal(signal.SIGSEGV)
                said = run.communicate(timeout=60)[1]
                self.assertEqual(run.returncode, -signal.SIGSEGV, said)

    def test_a_crash_in_the_allocator_ends_a_python_tool(self):
        """The handler, in a library that was loaded late, must not allocate, and so wait for the allocator's lock."""
        if not list((BIN.parent / "python").glob("vdblic/_core*.so")):
            self.skipTest("the module is not there")
        code = ("import sys; sys.path.insert(0, sys.argv[1]); from vdblic import _core\n"
                "_core.guard_against_crashes('tool'); print('ready', flush=True)\n"
                "while True: [bytes(2000 + i) for i in range(50)]")  # nearly always in the allocator
        for _ in range(12):
            run = subprocess.Popen([sys.executable, "-c", code, BIN.parent / "python"], stdout=subprocess.PIPE)
            self.addCleanup(run.stdout.close)
            self.addCleanup(run.kill)
            run.stdout.readline()
            run.send_signal(signal.SIGSEGV)
            self.assertEqual(run.wait(timeout=30), -signal.SIGSEGV)

    def test_a_crash_of_a_library_of_python_names_the_file(self):
        if not list((BIN.parent / "python").glob("vdblic/_core*.so")):
            self.skipTest("the module is not there")
        code = ("import os, signal, sys; sys.path.insert(0, sys.argv[1]); from vdblic import _core\n"
                "_core.guard_against_crashes('tool')\n"
                "with _core.Parsing('wind.nc', 'HDF5', True):\n"
                "    os.kill(os.getpid(), getattr(signal, sys.argv[2]))")
        for name, told in ("SIGSEGV", "HDF5 crashed on it"), ("SIGXCPU", "reading it does not come to an end"):
            done = subprocess.run([sys.executable, "-c", code, BIN.parent / "python", name], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr),
                             (3, f"tool: error: wind.nc: cannot be read: it is damaged; {told}\n"))

    def test_the_undamaged_files_are_taken(self):
        self.assertEqual(len(self.originals.files), 10, self.originals.files.keys())
        for path in self.undamaged.iterdir():
            os.link(path, self.folder / path.name)
        for kind, data in self.originals.files.items():
            (self.folder / "bad.vdb").write_bytes(data)
            for command in commands(kind)[:2]:
                done = self.run_tool(*command)
                self.assertEqual(done.returncode, 0, f"{kind} {command} {done.stderr}")


if __name__ == "__main__":
    unittest.main()
