"""Interrupted runs, full disks, closed pipes and limited memory."""

import os
import pathlib
import random
import re
import resource
import signal
import subprocess
import time
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, LinePipe, ToolTest, often

SANITIZED = os.environ.get("VDBLIC_SANITIZED") == "1"
ROOT = os.geteuid() == 0


class Survival(ToolTest):
    def start(self, tool, *arguments, **options):
        options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE,
                   "pipesize": os.sysconf("SC_PAGE_SIZE")} | options  # so that an endless run does not write many frames
        process = subprocess.Popen([BIN / tool, *map(str, arguments)], cwd=self.folder, text=True, **options)
        for stream in process.stdin, process.stdout, process.stderr:
            if stream:
                self.addCleanup(stream.close)
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    @staticmethod
    def rest(run):
        """What a run prints to its end after readline(), whose buffer communicate() loses: paths and messages."""
        out, messages = run.stdout.read(), run.stderr.read()
        run.wait(timeout=120)
        return out, messages

    def endless_synth(self, *more, **options):
        return self.start("vdblic_synth", "abc", "-o", "v.%06d.vdb", "--size", 32, 32, 32, "--frames", "1-9000",
                          *more, **options)

    def kill_synth(self, frames, choice):
        """Kill an endless run after some frames: at any moment of the start, of a frame or of a write."""
        paths = LinePipe(frames + 3, "v.000001.vdb")
        run = self.endless_synth(stdout=paths.writing)
        self.wait_until(lambda: paths.lines() >= frames, "no outputs", pause=0.001)
        time.sleep(choice.uniform(0, 0.02))
        run.kill()
        run.wait()
        paths.close()

    def synth(self, frames, size=(16, 16, 16)):
        return self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *size, "--frames", frames)

    def assert_whole(self, names):
        """The folder has exactly these files, all of them complete."""
        self.assertEqual(self.files(), sorted(names))
        for name in names:
            if name.endswith(".vdb"):
                self.outputs("vdblic_noise", "--verify", "--like", name, "-o", "checked.vdb")
        (self.folder / "checked.vdb").unlink(missing_ok=True)

    def test_signals_end_the_run_after_the_frame(self):
        for number in signal.SIGINT, signal.SIGTERM, signal.SIGHUP:
            run = self.endless_synth()
            first = run.stdout.readline()
            run.send_signal(number)
            rest, messages = self.rest(run)
            self.assertEqual(run.returncode, -number, messages)
            self.assertIn("stopped", messages)
            self.assert_whole((first + rest).split())
            for path in self.folder.iterdir():
                path.unlink()

    def test_a_shell_sees_128_and_the_signal(self):
        command = f"{BIN}/vdblic_synth abc -o v.%06d.vdb --size 32 32 32 --frames 1-9000 > paths & " \
                  "until [ -s paths ]; do sleep 0.02; done; kill -TERM $!; wait $!; echo $?"
        done = subprocess.run(["sh", "-c", command], cwd=self.folder, capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.split()[-1], "143")

    def test_a_signal_the_caller_ignores_is_ignored(self):
        run = self.endless_synth(preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        run.stdout.readline()
        run.send_signal(signal.SIGHUP)
        for _ in range(5):
            self.assertNotEqual(run.stdout.readline(), "")
        run.terminate()
        self.rest(run)
        self.assertEqual(run.returncode, -signal.SIGTERM)

    def test_every_tool_stops(self):
        self.synth("1-12", (64, 32, 32))
        self.write_speed()
        for frame in range(2, 13):
            os.link(self.folder / "c.0001.vdb", self.folder / f"c.{frame:04}.vdb")
        numpy.savez(self.folder / "v.npz", velocity=numpy.ones((12, 32, 32, 32, 3), numpy.float32))
        for command in (("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb"),
                        ("vdblic_import", "v.npz", "--layout", "txyzc", "-o", "i.%04d.vdb"),
                        ("vdblic_export", "c.%04d.vdb", "-o", "e_%04d.vti"),
                        ("vdblic_diff", "v.%04d.vdb", "v.%04d.vdb", "-o", "d.%04d.vdb"),
                        ("vdblic_render", "c.%04d.vdb", "-o", "i.%04d.png", "--texture", "speed")):
            before = set(self.files())
            paths = LinePipe(2, command[command.index("-o") + 1] % 1)
            run = self.start(*command, stdout=paths.writing)
            self.wait_until(lambda: run.poll() is not None or paths.lines() == 2, "no outputs")
            run.terminate()
            out, messages = paths.read(), run.communicate(timeout=120)[1]
            self.assertEqual(run.returncode, -signal.SIGTERM, f"{command} {messages}")
            made, printed = set(self.files()) - before - {"checkpoint.lic.vdb"}, set(out.split())
            self.assertLessEqual(printed, made, command)
            self.assertLessEqual(len(made - printed), 1, command)  # whose path the reader made wait

    def test_a_tool_that_prints_at_its_end_stops(self):
        self.synth("1", (64, 32, 32))
        self.write_speed()
        for frame in range(2, 1000):  # for minutes
            for name in "v", "c":
                os.link(self.folder / f"{name}.0001.vdb", self.folder / f"{name}.{frame:04}.vdb")
        before = self.files()
        run = self.start("vdblic_coherence", "v.%04d.vdb", "c.%04d.vdb", "--texture", "speed", "--dt", 1,
                         "--json", "c.json")
        while "done" not in run.stderr.readline():
            self.assertIsNone(run.poll())
        run.terminate()
        out, messages = self.rest(run)
        self.assertEqual((run.returncode, out), (-signal.SIGTERM, ""), messages)
        self.assertEqual(self.files(), before)

    def write_speed(self):
        x, y, z = numpy.meshgrid(*(numpy.arange(n) for n in (64, 32, 32)), indexing="ij")
        grid = vdb.FloatGrid()
        grid.name = "speed"
        grid.copyFromArray(((x * 7 + y * 5 + z * 3) % 11 / 10).astype(numpy.float32), tolerance=-1)
        grid.transform = vdb.read(str(self.folder / "v.0001.vdb"), "velocity").transform
        vdb.write(str(self.folder / "c.0001.vdb"), grid)

    def test_waiting_for_paths_stops_too(self):
        for tool in "vdblic_advect", "vdblic_render":
            run = self.start(tool, "-", "-o", "out.%04d.png" if "render" in tool else "out.%04d.vdb",
                             stdin=subprocess.PIPE)
            self.wait_until(lambda: self.catches(run, signal.SIGINT), "no handler of the signal")
            self.assertIsNone(run.poll())
            run.send_signal(signal.SIGINT)
            run.wait(timeout=120)
            self.assertEqual(run.returncode, -signal.SIGINT)
            self.assertEqual(self.files(), [])

    @staticmethod
    def catches(run, number):
        """Whether a process has a handler of a signal."""
        status = pathlib.Path(f"/proc/{run.pid}/status").read_text(encoding="ascii")
        handled = next(line for line in status.splitlines() if line.startswith("SigCgt"))
        return int(handled.split()[1], 16) >> (number - 1) & 1

    def test_a_closed_pipe_ends_the_run_without_a_message(self):
        run = self.endless_synth("-q")
        run.stdout.readline()
        run.stdout.close()
        messages = run.stderr.read()
        run.wait(timeout=120)
        self.assertEqual(run.returncode, -signal.SIGPIPE)
        self.assertEqual(messages, "")
        self.assert_whole(self.files())
        self.assertFalse([name for name in self.files() if name.startswith(".")])

    def test_a_closed_standard_error_does_not_matter(self):
        self.synth("1-3")
        reader, writer = os.pipe()
        os.close(reader)
        run = self.start("vdblic_advect", "v.%04d.vdb", "-v", "-o", "lic.%04d.vdb", stderr=writer)
        os.close(writer)
        out, _ = run.communicate(timeout=60)
        self.assertEqual((run.returncode, len(out.split())), (0, 3))

    def test_standard_output_that_cannot_be_written(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            run = self.start("vdblic_synth", "abc", "-o", "v.vdb", "--size", 8, 8, 8, "--frames", 1, stdout=full)
            self.assertIn("standard output", run.communicate(timeout=30)[1])
        self.assertEqual(run.returncode, 4)

    def test_kills_leave_no_litter(self):
        choice = random.Random(7)
        for frames in range(often(4, 15)):
            for path in self.folder.iterdir():
                path.unlink()
            self.kill_synth(frames % 4, choice)
            for path in self.folder.iterdir():
                self.assertFalse(path.name.startswith("."), path)
        self.outputs("vdblic_noise", "--verify", "--like", max(self.files()), "-o", "checked.vdb")

    def test_what_kills_leave_of_replaced_files_goes_with_the_next_run(self):
        """A file that is replaced has a second name for the moment of the renaming."""
        choice = random.Random(8)
        for frames in range(1, 4):
            self.kill_synth(frames, choice)
        last = max(int(re.search(r"v\.(\d+)\.vdb", path.name)[1]) for path in self.folder.iterdir())
        # As if the last kill had come at that moment.
        (self.folder / f".v.{last:06}.vdb.{os.uname().nodename}-0.part").write_bytes(b"dead")
        self.outputs("vdblic_synth", "abc", "-o", "v.%06d.vdb", "--size", 8, 8, 8, "--frames", f"1-{last}")
        self.assertEqual(sorted(path.name for path in self.folder.iterdir() if path.name.startswith(".")), [])

    def limited(self, size):
        return {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)), "restore_signals": False}

    def test_files_that_may_not_grow(self):
        self.synth("1-2", (32, 32, 32))
        noise, = self.outputs("vdblic_noise", "--like", "v.0001.vdb", "-o", "noise.vdb")
        numpy.save(self.folder / "v.npy", numpy.random.default_rng(1).random((16, 16, 16, 3)))
        before = self.files()
        for tool, *arguments in (("vdblic_advect", "v.%04d.vdb", "-o", "out.%04d.vdb", "--preroll", 0),
                                 ("vdblic_import", "v.npy", "--layout", "xyzc", "-o", "out.vdb"),
                                 ("vdblic_export", "v.0001.vdb", "-o", "out.vti"),
                                 ("vdblic_noise", "--like", "v.0001.vdb", "-o", "out.vdb"),
                                 ("vdblic_diff", "v.0001.vdb", "v.0002.vdb", "-o", "out.vdb"),
                                 ("vdblic_coherence", "v.0001.vdb", noise, "--texture", "noise", "--json", "out.json")):
            message = self.fails(4, tool, *arguments, **self.limited(500))
            self.assertIn("out.", message)
            self.assertIn("too large", message)
            self.assertEqual(self.files(), before)

    @unittest.skipUnless(ROOT, "only root may mount a small file system")
    def test_a_full_disk(self):
        small = self.folder / "small"
        small.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "none", small], check=False).returncode:
            self.skipTest("mounting is not allowed here")
        self.addCleanup(lambda: subprocess.run(["umount", small], check=True))
        self.synth("1-4", (32, 32, 32))
        numpy.save(self.folder / "v.npy", numpy.random.default_rng(1).random((4, 32, 32, 32, 3), numpy.float32))
        for command in (("vdblic_advect", "v.%04d.vdb", "-o", "small/lic.%04d.vdb", "--preroll", 0),
                        ("vdblic_import", "v.npy", "--layout", "txyzc", "-o", "small/i.%04d.vdb")):
            done = self.run_tool(*command)
            self.assertEqual(done.returncode, 4, done.stderr)
            self.assertIn("No space left on device", done.stderr)
            finished = [pathlib.Path(line).name for line in done.stdout.split()]
            self.assertLess(len(finished), 4)
            self.assertEqual(sorted(path.name for path in small.iterdir()), finished)
            for name in finished:
                (small / name).unlink()

    def test_a_folder_that_may_not_be_written_to(self):
        self.synth("1")
        self.folder.chmod(0o555 if not ROOT else 0o755)
        self.addCleanup(lambda: self.folder.chmod(0o755))
        nobody = {"preexec_fn": lambda: os.setuid(65534)} if ROOT else {}
        before = self.files()
        for command in (("vdblic_advect", "v.0001.vdb", "-o", "out.vdb"), ("vdblic_noise", "--size", 4, 4, 4, "-o", "n.vdb")):
            self.assertIn("Permission denied", self.fails(4, *command, **nobody))
        self.assertEqual(self.files(), before)

    def test_outputs_do_not_replace_inputs(self):
        self.synth("1-2")
        self.outputs("vdblic_noise", "--like", "v.0001.vdb", "-o", "noise.vdb")
        numpy.save(self.folder / "v.npy", numpy.ones((8, 8, 8, 3)))
        for ending in ".vdb", ".png":
            os.symlink("noise.vdb", self.folder / f"link{ending}")
        os.symlink("v.0002.vdb", self.folder / "other.0001.vdb")  # the input of another frame
        (self.folder / "t.json").write_text('{"range": [0, 1]}', encoding="utf-8")
        (self.folder / "c.json").write_text('{"keys": [{"frame": 1, "fov": 30}]}', encoding="utf-8")
        os.link(self.folder / "noise.vdb", self.folder / "noise.json")
        before = {name: self.contents(name) for name in self.files()}
        render = ("vdblic_render", "noise.vdb", "--texture", "noise", "--size", 8, 8, "-o", "image.png")
        streaks = ("vdblic_advect", "v.0001.vdb", "--method", "streaks", "--refine", 1, "-o", "noise.vdb")
        for command in (("vdblic_advect", "v.%04d.vdb", "-o", "v.%04d.vdb"),
                        ("vdblic_advect", "v.%04d.vdb", "-o", "other.%04d.vdb"),
                        (*streaks, "--emit", "link.vdb"), (*streaks, "--source", "air=link.vdb:noise"),
                        (*streaks[:-1], "new.vdb", "--emit", "noise.vdb:noise", "--json", "noise.json"),
                        ("vdblic_info", "v.%04d.vdb", "--json", "./v.0002.vdb"),
                        ("vdblic_info", "noise.vdb", "v.%04d.vdb", "--json", "other.0001.vdb"),
                        ("vdblic_diff", "v.%04d.vdb", "v.%04d.vdb", "-o", "other.%04d.vdb"),
                        ("vdblic_coherence", "v.%04d.vdb", "v.%04d.vdb", "--json", "other.0001.vdb"),
                        (*render, "--transfer", "t.json", "--histogram", "t.json"),
                        (*render, "--transfer", "t.json", "--transfer-out", "./t.json"),
                        (*render, "--camera", "c.json", "--histogram", "c.json"),
                        (*render, "--roi", "noise.vdb:noise", "--histogram", "noise.json"),
                        (*render[:-1], "link.png", "--solid", "v.0001.vdb:velocity"),
                        ("vdblic_advect", "v.####.vdb", "-o", "./v.$F4.vdb"),
                        ("vdblic_advect", "v.0001.vdb", "-o", "link.vdb", "--noise", "noise.vdb"),
                        ("vdblic_advect", "v.0001.vdb", "-o", "noise.vdb", "--mask", "link.vdb"),
                        ("vdblic_noise", "--like", "noise.vdb", "-o", "link.vdb"),
                        ("vdblic_import", "v.npy", "--layout", "xyzc", "-o", "link.vdb", "--like", "noise.vdb"),
                        ("vdblic_diff", "v.0001.vdb", "v.0002.vdb", "-o", "v.0002.vdb"),
                        ("vdblic_diff", "v.0001.vdb", "v.0002.vdb", "--json", "v.0002.vdb"),
                        ("vdblic_info", "v.0001.vdb", "--json", "v.0001.vdb"),
                        ("vdblic_render", "noise.vdb", "--texture", "noise", "--transfer-out", "noise.vdb")):
            self.assertIn("replace an input", self.fails(2, *command))
        piped = self.run_tool("vdblic_advect", "-", "-o", "v.%04d.vdb", stdin="v.0001.vdb\n")
        self.assertEqual(piped.returncode, 2, piped.stderr)
        self.assertEqual({name: self.contents(name) for name in self.files()}, before)

    def writers(self):
        """Every option of every tool that writes: command without the output, option, ending."""
        self.synth("1-2")
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--preroll", 0)
        advect = ("vdblic_advect", "v.0001.vdb", "--preroll", 0)
        render = ("vdblic_render", "lic.0001.vdb", "--size", 8, 8)
        compared = ("vdblic_diff", "lic.0001.vdb", "lic.0001.vdb")
        coherence = ("vdblic_coherence", "v.0001.vdb", "lic.0001.vdb")
        numpy.save(self.folder / "v.npy", numpy.ones((8, 8, 8, 3)))
        files = [(("vdblic_synth", "abc", "--size", 8, 8, 8, "--frames", 1), "-o", ".vdb"),
                 (("vdblic_import", "v.npy", "--layout", "xyzc"), "-o", ".vdb"), (("vdblic_export", "lic.0001.vdb"), "-o", ".vti"),
                 (("vdblic_noise", "--size", 8, 8, 8), "-o", ".vdb"), (advect, "-o", ".vdb"), (render, "-o", ".png"),
                 (compared, "-o", ".vdb")]
        reports = [((*advect, "-o", "again.vdb"), "--json", ".json"), (render, "--histogram", ".json"),
                   (render, "--transfer-out", ".json"), (("vdblic_info", "v.0001.vdb"), "--json", ".json"),
                   (compared, "--json", ".json"), (coherence, "--json", ".json")]
        return files, reports

    def test_nothing_but_files_is_replaced(self):
        files, reports = self.writers()
        os.mkfifo(self.folder / "fifo")
        (self.folder / "folder").mkdir()
        for ending in ".vdb", ".vti", ".png", ".json":
            for name, target in ("pipe", "fifo"), ("full", "/dev/full"), ("within", "folder"):
                (self.folder / f"{name}{ending}").symlink_to(target)
        before = self.files()
        for command, option, ending in files:
            for name in "pipe", "full", "within":
                self.assertRegex(self.fails(2, *command, option, f"{name}{ending}"),
                                 f"'{name}{ending}'.* is a (folder|device or a pipe)")
        for command, option, ending in reports:
            self.assertIn("is a folder", self.fails(2, *command, option, f"within{ending}"))
        self.assertEqual(self.files(), before)
        self.assertTrue((self.folder / "fifo").is_fifo())

    def test_links_are_followed(self):
        files, reports = self.writers()
        (self.folder / "target").mkdir()
        for command, option, ending in files + reports:
            target, link = self.folder / "target" / f"t{ending}", self.folder / f"link{ending}"
            link.symlink_to(f"target/t{ending}")
            for _ in "new", "replaced":
                self.outputs(*command, option, link.name)
                self.assertTrue(link.is_symlink(), command)
                self.assertGreater(target.stat().st_size, 0, command)
            self.assertEqual([path.name for path in (self.folder / "target").iterdir()], [target.name])
            link.unlink()
            target.unlink()

    def test_reports_go_through_pipes_and_devices(self):
        _, reports = self.writers()
        os.symlink("/dev/full", self.folder / "full.json")
        os.symlink("/dev/stdout", self.folder / "out.json")
        for command, option, _ in reports:
            run = self.run_tool(*command, option, "full.json")
            self.assertEqual(run.returncode, 4, run.stderr)
            self.assertIn("full.json: cannot be written: No space left on device", run.stderr)
            run = self.run_tool(*command, option, "out.json")
            self.assertIn(run.returncode, (0, 1), run.stderr)
            self.assertTrue(run.stdout.removeprefix("again.vdb\n").startswith("{"), run.stdout)
            self.assertTrue(run.stdout.endswith("}\n"), "the name of a stream is not printed")
        self.assertTrue(os.path.samefile("/dev/full", self.folder / "full.json"))
        with open(self.folder / "redirected", "w", encoding="utf-8") as redirected:
            run = subprocess.run([BIN / "vdblic_diff", "v.0001.vdb", "v.0001.vdb", "--json", "/dev/stdout"], check=True,
                                 cwd=self.folder, stdout=redirected, stderr=subprocess.PIPE)
        self.assertTrue((self.folder / "redirected").read_text(encoding="utf-8").startswith("{"))

    def test_outputs_are_checked_before_any_work(self):
        files, reports = self.writers()
        before = self.files()
        for command, option, ending in files + reports:
            message = self.fails(4, *command, option, f"nowhere/x{ending}")
            self.assertIn("the folder nowhere does not exist; make it first", message)
        self.assertEqual(self.files(), before)
        message = self.fails(4, "vdblic_render", "lic.%04d.vdb", "-o", "image.%04d.png", "--histogram", "nowhere/x.png")
        self.assertIn("make it first", message)
        (self.folder / "lic2.0002.vdb").mkdir()
        self.fails(2, "vdblic_advect", "v.%04d.vdb", "-o", "lic2.%04d.vdb")
        self.assertNotIn("lic2.0001.vdb", self.files())

    def test_help_that_cannot_be_printed(self):
        for tool in (["vdblic_advect", "--help"], ["vdblic_render", "--version"], ["vdblic_synth", "--list"],
                     ["vdblic_import", "--help"]):
            with open("/dev/full", "w", encoding="utf-8") as full:
                run = self.start(*tool, stdout=full)
                self.assertIn("standard output: cannot be written: No space left", run.communicate(timeout=30)[1])
            self.assertEqual(run.returncode, 4)

    def test_verify_names_damaged_files_before_any_work(self):
        self.synth("1-4")
        whole = self.run_tool("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--verify")
        self.assertEqual(whole.returncode, 0)
        self.assertIn("4 files are in order, 4 of them by their checksums", whole.stderr)
        for frame in 2, 4:
            data = bytearray(self.contents(f"v.{frame:04}.vdb"))
            data[-20] ^= 4
            (self.folder / f"v.{frame:04}.vdb").write_bytes(data)
        for path in self.folder.glob("lic.*"):
            path.unlink()
        before = self.files()
        for command in (("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb"), ("vdblic_diff", "v.%04d.vdb", "v.%04d.vdb"),
                        ("vdblic_render", "v.%04d.vdb", "-o", "i.%04d.png")):
            message = self.fails(3, *command, "--verify")
            for frame in 2, 4:
                self.assertIn(f"v.000{frame}.vdb: cannot be read as a .vdb file: grid 'velocity' is damaged", message)
            self.assertEqual(self.files(), before)
        # Without --verify a tool fails at the damaged frame.
        self.assertIn("grid 'velocity' is damaged", self.fails(3, "vdblic_noise", "--like", "v.0002.vdb", "-o", "n.vdb"))

    def test_sizes_are_checked_before_anything_is_allocated(self):
        huge = vdb.Vec3SGrid()
        huge.name = "velocity"
        huge.fill((0, 0, 0), (4095, 4095, 4095), (1, 0, 0))
        texture = vdb.FloatGrid()
        texture.name = "density"
        texture.fill((0, 0, 0), (4095, 4095, 4095), 0.5)
        vdb.write(str(self.folder / "huge.vdb"), [huge, texture])
        components = []
        for axis in "xyz":
            grid = vdb.FloatGrid()
            grid.name = f"v.{axis}"
            grid.fill((0, 0, 0), (4095, 4095, 4095), 1)
            components.append(grid)
        vdb.write(str(self.folder / "joined.vdb"), components)
        for command in (("vdblic_advect", "huge.vdb", "-o", "out.vdb"), ("vdblic_advect", "joined.vdb", "-o", "out.vdb"),
                        ("vdblic_render", "huge.vdb", "-o", "out.png"), ("vdblic_coherence", "huge.vdb", "huge.vdb")):
            run = self.start(*command)
            messages = run.stderr.read()
            _, status, usage = os.wait4(run.pid, 0)
            run.returncode = os.waitstatus_to_exitcode(status)
            self.assertEqual(run.returncode, 3, messages)
            self.assertRegex(messages, r"(huge|joined)\.vdb: .*voxels would take .* of memory or more")
            if not SANITIZED:
                self.assertLess(usage.ru_maxrss, 500 << 10)  # KiB; the voxels are hundreds of GiB
        # The part inside --bbox is small, and comparing does not expand tiles.
        self.outputs("vdblic_advect", "huge.vdb", "-o", "out.vdb", "--bbox", 0, 0, 0, 15, 15, 15)
        self.assertEqual(self.run_tool("vdblic_diff", "huge.vdb", "huge.vdb").returncode, 0)

    @unittest.skipIf(SANITIZED, "sanitizers hold more memory than there is")
    def test_the_budget_is_kept(self):
        self.synth("1-2", (200, 200, 200))
        for command in (("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb"), ("vdblic_noise", "--like", "v.0001.vdb", "-o", "n.vdb"),
                        ("vdblic_diff", "v.0001.vdb", "v.0002.vdb")):
            run = self.start(*command, "--max-memory", "150M", "--threads", 1)
            messages = run.stderr.read()
            _, status, usage = os.wait4(run.pid, 0)
            run.returncode = os.waitstatus_to_exitcode(status)
            expected = {"vdblic_advect": (0,), "vdblic_noise": (0, 3), "vdblic_diff": (1,)}[command[0]]
            self.assertIn(run.returncode, expected, messages)
            self.assertLess(usage.ru_maxrss, (150 + 40) << 10)  # 40 MiB for code: it is no data where nothing is paged
            if run.returncode == 3:
                self.assertIn("--max-memory", messages)

    def test_memory_sizes(self):
        for size in "1K", "0", "-1", "nan", "1e308", "", "8 apples", "99999999999999G":
            self.fails(2, "vdblic_noise", "--size", 4, 4, 4, "-o", "n.vdb", "--max-memory", size)
        if not SANITIZED:
            for size in "300M", "1G", "400000000":
                self.outputs("vdblic_noise", "--size", 4, 4, 4, "-o", "n.vdb", "--max-memory", size)


if __name__ == "__main__":
    unittest.main()
