"""Jobs that take more than the memory that they may take: the same bytes, with a scratch file."""

import os
import pathlib
import random
import resource
import signal
import subprocess
import time
import unittest

from support import BIN, WAKE, LinePipe, ToolTest, nightly, often, skip

if os.environ.get("VDBLIC_SANITIZED") == "1":
    skip("sanitizers hold more memory than there is")

DATA = os.environ.get("VDBLIC_DATA")
MEBIBYTE = 1 << 20
LIMIT = 128  # MiB, the least
LATE = 1.1  # under load, use may exceed the limit briefly
SAID = "of memory may be used: the rest lies in a scratch file"
# A child's peak includes the memory of the process that starts it, so a small one does, and tells the peak.
SMALL = """import os, sys
pipe = int(sys.argv[1])
os.set_inheritable(pipe, False)
_, status, usage = os.wait4(os.posix_spawn(sys.argv[2], sys.argv[2:], os.environ), 0)
os.write(pipe, str(usage.ru_maxrss).encode())
sys.exit(os.waitstatus_to_exitcode(status))"""


class Scratch(ToolTest):
    def start(self, *arguments, tool="vdblic_advect", **options):
        options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL} | options
        return subprocess.Popen([BIN / tool, *map(str, arguments)], cwd=self.folder, text=True, **options)

    def run_in(self, memory, folder, *arguments, **options):
        """A run with a limit in MiB, None for none; returns its messages and the most memory it held [MiB]."""
        (self.folder / folder).mkdir(exist_ok=True)
        limit = () if memory is None else ("--max-memory", f"{memory}M")
        return self.measured(0, "vdblic_advect", *arguments, "-o", f"{folder}/lic.%04d.vdb", *limit, **options)

    def measured(self, wanted, tool, *arguments, **options):
        """Run a tool to the exit status that is wanted; returns its messages and the most memory it held [MiB]."""
        options = {"stdout": subprocess.DEVNULL} | options
        reading, writing = os.pipe()
        run = subprocess.run(["/usr/bin/python3", "-S", "-c", SMALL, str(writing), BIN / tool, *map(str, arguments)],
                             cwd=self.folder, text=True, stderr=subprocess.PIPE, pass_fds=(writing,), **options)
        os.close(writing)
        with os.fdopen(reading) as pipe:
            peak = pipe.read()
        self.assertEqual(run.returncode, wanted, run.stderr)
        return run.stderr, int(peak) / 1024

    def assert_same(self, one, other):
        names = sorted(os.listdir(self.folder / one))
        self.assertEqual(sorted(os.listdir(self.folder / other)), names)
        for name in names:
            self.assertEqual(self.contents(f"{other}/{name}"), self.contents(f"{one}/{name}"), name)

    def assert_kept(self, run, arguments):
        """A run keeps to the limit. Returns its messages."""
        messages, peak = run()
        self.assertLessEqual(peak, LATE * LIMIT, arguments)
        return messages

    def check(self, *arguments):
        """The same bytes within the limit as without one."""
        messages, _ = self.run_in(None, "whole", *arguments)
        self.assertNotIn("scratch", messages)
        self.assertIn(SAID, self.assert_kept(lambda: self.run_in(LIMIT, "parts", *arguments), arguments))
        self.assert_same("whole", "parts")

    def flow(self, size=96, frames="1-2"):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", size, size, size, "--frames", frames)
        return "v.%04d.vdb", "--preroll", 1

    def test_every_method(self):
        flow = self.flow()
        for method in ("auflic", "streaks", "ibfv", *often((), ("uflic", "auflic-2004", "lic", "lea", "ufac"))):
            with self.subTest(method=method):
                self.check(*flow, "--method", method)

    def test_substeps_carried_grids_and_cubic_interpolation(self):
        flow = self.flow(64)
        self.check(*flow, "--substeps", 2, "--refine", 2, "--interpolation", "cubic", "--carry", "velocity",
                   "--with", "q,vorticity")

    def test_the_wake(self):
        self.check(WAKE, "--frames", "3-4", "--lead-in", 0, "--refine", 3)

    @unittest.skipUnless(DATA, "VDBLIC_DATA does not name the folder of the large data sets")
    def test_data_of_other_programs(self):
        for name, *more in (("era5_west_europe/era5.%04d.vdb", "--refine", 4, 4, 1),
                            ("mantaflow_drift/fluid_data_%04d.vdb", "--refine", 6)):
            with self.subTest(name=name):
                self.check(pathlib.Path(DATA) / name, "--frames", "20-21", "--lead-in", 0, *more)

    @nightly
    def test_a_frame_larger_than_the_memory(self):
        flow, *_ = self.flow(232, "1-1")
        self.check(flow, "--method", "lic", "--bbox", 0, 0, 0, 231, 231, 60)

    def check_tool(self, tool, *arguments, status=0):
        """The same report and outputs within the limit as without one."""
        def run(*limit):
            with open(self.folder / "printed", "w") as printed:
                return self.measured(status, tool, *arguments, *limit, stdout=printed)

        def outputs():
            return [self.contents(name) for name in (self.folder / "printed").read_text().split()]

        messages, _ = run()
        whole = outputs()
        self.assertEqual(self.assert_kept(lambda: run("--max-memory", f"{LIMIT}M"), arguments), messages)
        self.assertTrue(outputs() == whole, "other outputs")
        missing = self.fails(2, tool, *arguments, "--scratch", "nowhere")
        self.assertIn("--scratch nowhere: no such folder", missing)

    def noise(self, name, size, seed):
        self.outputs("vdblic_noise", "--size", size, size, size, "--seed", seed, "-o", name)

    def test_pictures(self):
        self.noise("noise.vdb", 192, 1)
        self.check_tool("vdblic_render", "noise.vdb", "--texture", "noise", "-o", "image.exr", "--size", 64, 48, "-q")

    def test_differences(self):
        self.noise("a.vdb", 208, 1)
        self.noise("b.vdb", 208, 2)
        self.check_tool("vdblic_diff", "a.vdb", "b.vdb", "-o", "difference.vdb", "--json", "report.json", "-q",
                        status=1)

    def test_values(self):
        self.flow(208, "1-1")
        self.check_tool("vdblic_info", "v.%04d.vdb", "--values", "--json", "report.json", "-q")

    def test_coherence(self):
        flow, *_ = self.flow(136)
        self.outputs("vdblic_advect", flow, "-o", "lic.%04d.vdb", "--lead-in", 0)
        self.check_tool("vdblic_coherence", flow, "lic.%04d.vdb", "--samples", 20000, "--json", "report.json", "-q")

    def test_flows_and_noise(self):
        self.check_tool("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 208, 208, 208, "--frames", "1-2", "-q")
        self.check_tool("vdblic_noise", "--size", 256, 256, 256, "-o", "noise.vdb", "-q")
        self.noise("coarse.vdb", 60, 1)
        self.check_tool("vdblic_noise", "--like", "coarse.vdb", "--refine", 4, "-o", "fine.vdb", "-q")
        self.assertEqual(self.files(), ["coarse.vdb", "fine.vdb", "noise.vdb", "printed", "v.0001.vdb", "v.0002.vdb"])

    def test_films(self):
        self.flow(64, "1-3")
        self.check_tool("vdblic_film", "v.%04d.vdb", "-o", "still.png", "--method", "dense", "--size", 192, 144, "-q")
        self.check_tool("vdblic_film", "v.%04d.vdb", "-o", "flow.mp4", "--size", 192, 144, "--seconds", 0.2, "-q")
        self.assertEqual(self.files(), ["flow.mp4", "printed", "still.png", "v.0001.vdb", "v.0002.vdb", "v.0003.vdb"])

    def test_without_pressure_there_is_no_scratch_file(self):
        flow = self.flow(64)
        missing = self.fails(2, "vdblic_advect", *flow, "-o", "lic.%04d.vdb", "--scratch", "nowhere")
        self.assertIn("--scratch nowhere: no such folder", missing)
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8 * MEBIBYTE,) * 2)  # a scratch file would be larger
        messages, _ = self.run_in(256, "lic", *flow, "--scratch", ".", preexec_fn=limit)
        self.assertNotIn("scratch", messages)

    def test_the_operator_new_of_the_tools(self):
        """Its alignments where the memory is used up, and what it leaves of errno."""
        for folder in self.folder, "/dev/shm":  # which knows fewer calls, and so errors
            subprocess.run([pathlib.Path(os.environ["VDBLIC_TEST_SUPPORT"]) / "use_scratch", folder], check=True)

    @unittest.skipIf(os.geteuid() != 0, "only root may mount a small file system")
    def test_a_full_disk(self):
        small = self.folder / "small"
        small.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8m", "none", small], check=False).returncode:
            self.skipTest("mounting is not allowed here")
        self.addCleanup(lambda: subprocess.run(["umount", small], check=True))
        flow = self.flow(frames="1-3")
        self.run_in(None, "whole", *flow)
        (self.folder / "lic").mkdir()
        command = "vdblic_advect", *flow, "-o", "lic/lic.%04d.vdb", "--max-memory", f"{LIMIT}M"
        self.assertIn("small: there is no room for a scratch file of", self.fails(4, *command, "--scratch", "small"))
        self.assertEqual(os.listdir(self.folder / "lic") + os.listdir(small), [])
        paths = LinePipe(1, "lic/lic.0001.vdb")
        run = self.start(*command[1:], stdout=paths.writing)
        self.wait_until(lambda: run.poll() is not None or paths.lines() == 1, "no outputs")
        run.send_signal(signal.SIGTERM)
        paths.read()
        run.wait()
        before = sorted(os.listdir(self.folder / "lic"))
        self.assertIn("checkpoint.lic.vdb", before)
        full = self.run_tool(*command, "--scratch", "small", "--resume")
        self.assertEqual(full.returncode, 4, full.stderr)
        self.assertIn("No space left on device; make room, or give another folder with --scratch", full.stderr)
        self.assertEqual(sorted(os.listdir(self.folder / "lic")), before)
        self.outputs(*command, "--resume")
        self.assert_same("whole", "lic")

    def test_kills_and_other_limits(self):
        flow = self.flow(frames="1-3")
        self.run_in(None, "whole", *flow)
        (self.folder / "lic").mkdir()
        choice, there = random.Random(3), lambda: sum(name.startswith("lic.") for name in os.listdir(self.folder / "lic"))
        for _ in range(often(3, 6)):
            limit = choice.choice(((), ("--max-memory", f"{LIMIT}M"), ("--max-memory", "144M")))
            farther, pause = min(there() + choice.randint(0, 1), 2), choice.uniform(0, 0.2)
            paths = LinePipe(2, "lic/lic.0001.vdb")  # so that the run is there until it is killed
            run = self.start(*flow, "-o", "lic/lic.%04d.vdb", "--resume", "--checkpoint-every", 1, "--threads",
                             choice.choice((1, 2, 3)), *limit, stdout=paths.writing)
            self.wait_until(lambda n=farther: run.poll() is not None or there() >= n, "no outputs", pause=0.001)
            time.sleep(pause)  # at any moment of a frame
            run.kill()
            paths.close()
            self.assertEqual(run.wait(), -signal.SIGKILL)
            for name in os.listdir(self.folder / "lic"):
                self.assertTrue(name.startswith(("lic.", "checkpoint.lic.", ".checkpoint.lic.lock")), name)
        self.run_in(LIMIT, "lic", *flow, "--resume")
        self.assert_same("whole", "lic")


if __name__ == "__main__":
    unittest.main()
