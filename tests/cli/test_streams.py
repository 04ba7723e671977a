"""Standard streams that are closed, full or not read, named pipes as inputs and reports, and limits of the system."""

import fcntl
import os
import pathlib
import resource
import signal
import subprocess
import unittest

import numpy

from support import BIN, ToolTest

SANITIZED = os.environ.get("VDBLIC_SANITIZED") == "1"
TOOLS = [name for name in ("synth", "noise", "advect", "info", "coherence", "render", "film", "diff", "view", "import",
                           "export") if (BIN / f"vdblic_{name}").exists()]
USER = 64321  # of whom nothing else runs


class Streams(ToolTest):
    def setUp(self):
        super().setUp()
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 16, 16, 16, "--frames", "1-3")

    def start(self, tool, *arguments, **options):
        options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE} | options
        run = subprocess.Popen([BIN / tool, *map(str, arguments)], cwd=self.folder, text=True, **options)
        self.addCleanup(run.stderr.close)
        self.addCleanup(lambda: run.poll() is None and run.kill())
        return run

    @staticmethod
    def asks():
        """What every tool prints instead of doing a job."""
        for name in TOOLS:
            yield f"vdblic_{name}", "--help"
            if name not in ("import", "export"):
                yield f"vdblic_{name}", "--parameters"

    def test_answers_that_cannot_be_printed(self):
        for tool, option in self.asks():
            with self.subTest(tool=tool, option=option), open("/dev/full", "w", encoding="utf-8") as full:
                run = self.start(tool, option, stdout=full)
                said = run.stderr.read()
                self.assertEqual(run.wait(timeout=60), 4, said)
                self.assertIn("standard output: cannot be written: No space left on device", said)
                closed = self.run_tool(tool, option, preexec_fn=lambda: os.close(1))
                self.assertEqual(closed.returncode, 4, closed.stderr)
                self.assertIn("standard output: cannot be written: Bad file descriptor", closed.stderr)
                reading, writing = os.pipe()
                os.close(reading)
                run = self.start(tool, option, stdout=writing)
                os.close(writing)
                self.assertEqual((run.wait(timeout=60), run.stderr.read()), (-signal.SIGPIPE, ""))

    def test_no_file_takes_the_place_of_a_closed_stream(self):
        numpy.save(self.folder / "a.npy", numpy.ones((4, 4, 4, 3), numpy.float32))
        before = self.files()
        made_by = {"vdblic_synth": ("abc", "-o", "w.vdb", "--size", 8, 8, 8, "--frames", 1),
                   "vdblic_import": ("a.npy", "--layout", "xyzc", "-o", "w.vdb")}
        for tool, arguments in made_by.items():
            run = self.run_tool(tool, *arguments, preexec_fn=lambda: os.closerange(0, 2))
            self.assertEqual(run.returncode, 4, run.stderr)
            self.assertTrue(run.stderr.endswith("standard output: cannot be written: Bad file descriptor\n"), run.stderr)
            self.outputs("vdblic_info", "w.vdb", "--values", "--json", "w.json")  # whole
            for made in set(self.files()) - set(before):
                (self.folder / made).unlink()
        for tool in "vdblic_synth", "vdblic_import":
            usage = self.run_tool(tool, "--nonsense", preexec_fn=lambda: os.close(2))
            self.assertEqual(usage.returncode, 2)
            mute = self.run_tool(tool, *made_by[tool], preexec_fn=lambda: os.close(2))
            self.assertEqual(mute.returncode, 0)
            self.assertEqual(self.run_tool(tool, *made_by[tool], preexec_fn=lambda: os.closerange(0, 3)).returncode, 4)

    def test_reports_to_a_closed_stream(self):
        for command in (("vdblic_info", "v.0001.vdb"), ("vdblic_diff", "v.0001.vdb", "v.0001.vdb")):
            for name in "-", "/dev/stdout":
                run = self.run_tool(*command, "--json", name, preexec_fn=lambda: os.close(1))
                self.assertEqual(run.returncode, 4, run.stderr)
                self.assertIn("standard output: cannot be written: Bad file descriptor", run.stderr)

    def test_inputs_that_cannot_be_read(self):
        """A regular file of which the disk returns nothing: /proc/self/mem is one, at 0."""
        self.outputs("vdblic_noise", "--like", "v.0001.vdb", "-o", "t.vdb")
        for option in "--transfer", "--camera":
            message = self.run_tool("vdblic_render", "t.vdb", "--texture", "noise", "-o", "o.png", option, "/proc/self/mem")
            self.assertEqual(message.returncode, 3, message.stderr)
            self.assertIn("/proc/self/mem: cannot be read: Input/output error", message.stderr)

    def inputs(self):
        """Every input of every tool: commands with {} for the file, and the file's ending."""
        advect, render = ("vdblic_advect", "v.0001.vdb", "-o", "o.vdb"), ("vdblic_render", "t.vdb", "--texture", "noise", "-o", "o.png")
        yield from ((command, ".vdb") for command in (
            ("vdblic_info", "{}"), ("vdblic_info", "{}", "--values"), ("vdblic_advect", "{}", "-o", "o.vdb"),
            (*advect, "--mask", "{}"), (*advect, "--noise", "{}:noise"), ("vdblic_noise", "--like", "{}", "-o", "o.vdb"),
            ("vdblic_render", "{}", "-o", "o.png"), (*render, "--solid", "{}"), ("vdblic_diff", "{}", "v.0001.vdb"),
            ("vdblic_coherence", "{}", "v.0001.vdb"), ("vdblic_coherence", "v.0001.vdb", "{}"),
            ("vdblic_film", "{}", "-o", "o.mp4"), ("vdblic_view", "{}"), ("vdblic_export", "{}", "-o", "o.vti"),
            ("vdblic_export", "{}", "-o", "o.vdb", "--levels", 1), ("vdblic_export", "{}", "-o", "o.usda"),
            ("vdblic_import", "v.npy", "--layout", "xyzc", "-o", "o.vdb", "--like", "{}")))
        yield from (((*render, option, "{}"), ".json") for option in ("--transfer", "--camera"))
        yield ("vdblic_export", "v.0001.vdb", "-o", "o.usda", "--camera", "{}"), ".json"
        yield from ((("vdblic_import", "{}", "-o", "o.vdb"), ending) for ending in (".npy", ".nc", ".vti", ".cgns"))
        yield (*render, "--solid", "{}"), ".obj"

    def test_named_pipes_are_no_inputs(self):
        numpy.save(self.folder / "v.npy", numpy.ones((4, 4, 4, 3), numpy.float32))
        self.outputs("vdblic_noise", "--like", "v.0001.vdb", "-o", "t.vdb")
        for command, ending in self.inputs():
            if command[0].removeprefix("vdblic_") not in TOOLS:
                continue
            pipe = self.folder / f"pipe{ending}"
            if not pipe.exists():
                os.mkfifo(pipe)
            command = [pipe.name if word == "{}" else str(word).replace("{}", pipe.name) for word in command]
            with self.subTest(command=command):
                before = self.files()
                run = self.run_tool(*command, timeout=60)
                self.assertEqual(run.returncode, 3, run.stderr)
                self.assertIn(f"{pipe.name}: is no regular file", run.stderr)
                self.assertEqual(self.files(), before)

    def waits(self, run, *calls):
        """Wait until the main thread of a process is in one of these waits of the kernel."""
        where = pathlib.Path(f"/proc/{run.pid}/wchan")
        if os.geteuid() != 0 or where.read_text(encoding="ascii") == "":
            self.skipTest("this system does not tell where a process waits")
        self.wait_until(lambda: any(call in where.read_text(encoding="ascii") for call in calls), "does not wait")

    def test_a_signal_ends_the_wait_for_the_reader_of_a_report(self):
        os.mkfifo(self.folder / "pipe.json")
        run = self.start("vdblic_info", "v.%04d.vdb", "--json", "pipe.json", "-q")
        self.waits(run, "wait_for_partner", "fifo_open")
        run.send_signal(signal.SIGTERM)
        self.assertEqual((run.wait(timeout=60), run.stderr.read()), (-signal.SIGTERM, ""))

    def test_a_signal_ends_the_wait_for_the_reader_of_the_paths(self):
        reading, writing = os.pipe()
        self.addCleanup(os.close, reading)
        os.write(writing, bytes(fcntl.fcntl(writing, fcntl.F_SETPIPE_SZ, 4096)))  # there is no room for a path
        for command in (("vdblic_synth", "abc", "-o", "w.%04d.vdb", "--size", 8, 8, 8, "--frames", "1-9"),
                        ("vdblic_export", "v.%04d.vdb", "-o", "w.%04d.npz")):
            run = self.start(*command, "-q", stdout=writing)
            self.waits(run, "pipe_write")
            run.send_signal(signal.SIGTERM)
            self.assertEqual((run.wait(timeout=60), run.stderr.read()), (-signal.SIGTERM, ""), command)
        os.close(writing)


@unittest.skipIf(SANITIZED, "sanitizers need threads and addresses of their own")
class Limits(ToolTest):
    JOBS = (("vdblic_synth", "abc", "-o", "{}w.%04d.vdb", "--size", 32, 32, 32, "--frames", "1-2"),
            ("vdblic_noise", "--like", "v.0001.vdb", "-o", "{}n.vdb"),
            ("vdblic_advect", "v.%04d.vdb", "-o", "{}lic.%04d.vdb", "--preroll", 1),
            ("vdblic_info", "v.%04d.vdb", "--values", "--json", "{}i.json"),
            ("vdblic_diff", "v.0001.vdb", "v.0001.vdb", "--json", "{}d.json"),
            ("vdblic_coherence", "v.0001.vdb", "n.vdb", "--texture", "noise", "--json", "{}c.json"),
            ("vdblic_render", "n.vdb", "--texture", "noise", "-o", "{}r.png", "--size", 32, 24),
            ("vdblic_export", "v.0001.vdb", "-o", "{}e.npz"))

    def setUp(self):
        super().setUp()
        self.folder.chmod(0o777)
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 32, 32, 32, "--frames", "1-3")
        self.outputs("vdblic_noise", "--like", "v.0001.vdb", "-o", "n.vdb")

    def jobs(self, begin, *others):
        for command in (*self.JOBS, *others):
            if command[0].removeprefix("vdblic_") in TOOLS:
                yield [str(word).replace("{}", begin) for word in command]

    def threads_of_loading(self):
        """Threads of a tool that waits: the first one, and those that OpenVDB's libraries start while they are loaded."""
        waiting = subprocess.Popen([BIN / "vdblic_advect", "-", "-o", "none.%04d.vdb"], cwd=self.folder,
                                   stdin=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.addCleanup(waiting.wait)
        self.addCleanup(waiting.kill)
        self.addCleanup(waiting.stdin.close)
        where = pathlib.Path(f"/proc/{waiting.pid}")
        self.wait_until(lambda: "poll" in (where / "wchan").read_text(encoding="ascii"), "does not wait")
        return len(os.listdir(where / "task"))

    @unittest.skipUnless(os.geteuid() == 0, "the limit on processes is one of a user, whom only root may choose")
    def test_few_threads(self):
        def of_user(threads):
            resource.setrlimit(resource.RLIMIT_NPROC, (threads, threads))
            os.setuid(USER)

        loaded = self.threads_of_loading()
        for whole, command in zip(self.jobs("whole."), self.jobs("alone.")):
            with self.subTest(command=command):
                expected = [path.read_bytes() for path in self.outputs(*whole)]
                needed = 8 if command[0] == "vdblic_export" else loaded
                made = self.run_tool(*command, preexec_fn=lambda: of_user(needed))
                self.assertEqual(made.returncode, 0, made.stderr)
                found = [(self.folder / name).read_bytes() for name in made.stdout.split()]
                self.assertEqual(len(found), len(expected))
                if not command[-1].endswith(".json"):  # of which some tell times
                    self.assertTrue(found == expected, "other bytes")
                if command[0] != "vdblic_export" and len(os.sched_getaffinity(0)) > 1:
                    self.assertIn(f"1 of {len(os.sched_getaffinity(0))} threads compute", made.stderr)
                if loaded > 1:  # not even what its libraries need
                    refused = self.run_tool(*command, preexec_fn=lambda: of_user(1))
                    self.assertEqual(refused.returncode, 3, refused.stderr)
                    self.assertRegex(refused.stderr, f"{command[0]}: error: .*(thread can be started|start new thread)")

    def test_few_addresses(self):
        for mebibytes in 80, 100, 130, 160, 200:
            limit = mebibytes << 20
            for command in self.jobs("few."):
                if command[0] == "vdblic_export":  # Python ends before it is ours
                    continue
                with self.subTest(mebibytes=mebibytes, command=command):
                    run = self.run_tool(*command, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
                    if run.returncode == 127:  # the loader had no room for the libraries
                        continue
                    self.assertIn(run.returncode, (0, 3), run.stderr)
                    self.assertEqual(run.returncode == 3, "error:" in run.stderr)

    def test_small_stacks(self):
        """Threads get as much as the user allows them (ulimit -s); here it is a 32nd of the usual."""
        small = lambda: resource.setrlimit(resource.RLIMIT_STACK, (256 << 10,) * 2)
        others = [("vdblic_advect", "v.0001.vdb", "-o", f"{{}}{method}.vdb", "--preroll", 1, "--method", method)
                  for method in ("auflic-2004", "uflic", "lic", "streaks", "ibfv", "lea", "ufac")]
        others.append(("vdblic_film", "v.%04d.vdb", "-o", "{}film.png", "--size", 32, 24, "--preview"))
        for whole, command in zip(self.jobs("whole.", *others), self.jobs("small.", *others)):
            with self.subTest(command=command):
                expected = [path.read_bytes() for path in self.outputs(*whole)]
                found = [path.read_bytes() for path in self.outputs(*command, preexec_fn=small)]
                self.assertEqual(len(found), len(expected))
                if not command[-1].endswith(".json"):
                    self.assertTrue(found == expected, "other bytes")


if __name__ == "__main__":
    unittest.main()
