"""vdblic_advect --resume: after any interruption the final outputs equal those of an uninterrupted run."""

import os
import pathlib
import random
import re
import resource
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import unittest

import numpy
import pyopenvdb as vdb

import vdb_bytes
from support import BIN, LinePipe, ToolTest, often

SANITIZED = os.environ.get("VDBLIC_SANITIZED") == "1"
SUPPORT = os.environ["VDBLIC_TEST_SUPPORT"]
FRAMES = 40
CHECKPOINT = "checkpoint.lic.vdb"
LOCK = ".checkpoint.lic.lock"
OUTPUTS = "lic.%04d.vdb"


class Resume(ToolTest):
    """All tests share inputs and uninterrupted runs; interrupted runs work in self.folder."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="vdblic-")
        cls.addClassCleanup(folder.cleanup)
        cls.shared = pathlib.Path(folder.name)
        cls.made = {}

    def flow(self):
        """A sequence of FRAMES frames on a box."""
        if not (self.shared / "v.0001.vdb").exists():
            self.tool("vdblic_synth", "tornado", "-o", self.shared / "v.%04d.vdb", "--size", 24, 24, 24, "--frames",
                      f"1-{FRAMES}")
        return self.shared / "v.%04d.vdb"

    def moving_ball(self):
        """A flow on a ball that moves and changes size, with a mask that changes too."""
        x, y, z = numpy.meshgrid(*(numpy.arange(28.0),) * 3, indexing="ij")
        for frame in range(1, FRAMES + 1):
            if (self.shared / f"m.{frame:04}.vdb").exists():
                break
            turn = 0.2 + 0.1 * numpy.sin(frame / 3)
            velocity = numpy.stack([turn * (14 - y), turn * (x - 14), 0.5 * numpy.cos(x / 4 + frame / 5)], -1)
            distance = numpy.sqrt((x - 9 - frame / 5) ** 2 + (y - 14) ** 2 + (z - 14) ** 2)
            velocity[distance > 7 + 2 * numpy.sin(frame / 4)] = 0
            ball = vdb.Vec3SGrid()
            ball.name = "velocity"
            ball.copyFromArray(velocity.astype(numpy.float32))
            vdb.write(str(self.shared / f"b.{frame:04}.vdb"), ball)
            mask = vdb.BoolGrid()
            mask.fill((0, 0, 0), (27, 27, 13 + frame % 5), True)
            mask.name = "mask"
            vdb.write(str(self.shared / f"m.{frame:04}.vdb"), mask)
        return self.shared / "b.%04d.vdb", "--dt", 1, "--mask", self.shared / "m.%04d.vdb"

    def tool(self, *command):
        """Run a tool that must succeed; returns its standard error."""
        done = self.run_tool(*command)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr

    def whole(self, *arguments, frames=f"1-{FRAMES}"):
        """The folder of an uninterrupted run."""
        key = (*map(str, arguments), frames)
        if key not in self.made:
            folder = self.shared / f"run{len(self.made)}"
            folder.mkdir()
            selection = ["--frames", frames] if frames else []
            self.tool("vdblic_advect", *arguments, *selection, "-o", folder / OUTPUTS)
            self.made[key] = folder
        return self.made[key]

    def start(self, *arguments, frames=f"1-{FRAMES}", **options):
        options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
        selection = ["--frames", frames] if frames else []
        command = [BIN / "vdblic_advect", *map(str, arguments), *selection, "-o", OUTPUTS]
        run = subprocess.Popen(command, cwd=self.folder, text=True, **options)
        for stream in run.stdin, run.stdout, run.stderr:
            if stream:
                self.addCleanup(stream.close)
        self.addCleanup(lambda: run.poll() is None and run.kill())
        return run

    def start_held(self, lines, *arguments, **options):
        """Start a run that waits when it has printed so many paths. Returns it and its standard output."""
        paths = LinePipe(lines, OUTPUTS % 1)
        return self.start(*arguments, stdout=paths.writing, **options), paths

    def outputs_there(self):
        return sum(name.startswith("lic.") for name in os.listdir(self.folder))

    def kill_when(self, happens, *arguments, lines=FRAMES - 1, **options):
        """Start or resume a run, which waits when it has printed so many paths, and SIGKILL it when `happens()`."""
        run, paths = self.start_held(lines, *arguments, "--resume", stderr=subprocess.DEVNULL, **options)
        self.wait_until(lambda: run.poll() is not None or happens(), "nothing to kill it for", pause=0.0002)
        run.kill()
        paths.close()
        self.assertEqual(run.wait(), -signal.SIGKILL)

    def finish(self, expected, *arguments, **options):
        """Resume to the end and compare every file and voxel with the uninterrupted run."""
        run = self.start(*arguments, "--resume", **options)
        out, messages = run.communicate(timeout=120)
        self.assertEqual(run.returncode, 0, messages)
        names = sorted(path.name for path in expected.iterdir())
        self.assertEqual(out.split(), names)
        self.assertEqual(self.files(), names)
        self.tool("vdblic_diff", expected / OUTPUTS, OUTPUTS)
        for name in names:
            self.assertEqual(self.contents(name), (expected / name).read_bytes(), name)
        return messages

    def interrupted(self, *arguments, after=6, number=signal.SIGTERM, **options):
        """Start a run and stop it by a signal after some frames; returns its messages."""
        run, paths = self.start_held(after, *arguments, **options)
        self.wait_until(lambda: run.poll() is not None or paths.lines() == after, "no outputs", pause=0.001)
        run.send_signal(number)
        paths.read()
        messages = run.communicate(timeout=60)[1]
        self.assertEqual(run.returncode, -number, messages)
        return messages

    # Kills

    def kill_often(self, kills, choice, *arguments, last=FRAMES):
        """Kill a run repeatedly at random moments, each time after more frames."""
        for _ in range(kills):
            farther, pause = min(self.outputs_there() + choice.randint(0, 2), last - 3), choice.uniform(0, 0.02)
            threads = ("--threads", choice.choice((1, 2, 3)), "--checkpoint-every", choice.choice((1, 2, 3)))

            def moment(farther=farther, pause=pause):
                if self.outputs_there() < farther:
                    return False
                time.sleep(pause)
                return True

            self.kill_when(moment, *arguments, *threads, lines=farther + 2, frames=f"1-{last}")

    def test_kills_at_random_moments(self):
        expected = self.whole(self.flow())
        self.kill_often(often(5, 22), random.Random(1), self.flow())
        self.finish(expected, self.flow(), "--threads", 1)

    @unittest.skipIf(SANITIZED, "a sanitizer wants to be loaded first")
    def test_kills_while_it_writes(self):
        """Killed at calls of the system that bring an output or a checkpoint to the disk."""
        expected, choice = self.whole(self.flow()), random.Random(2)
        calls = {"writev": 40, "fsync": 6, "linkat": 5, "rename": 3}  # with numbers up to these: in some frames
        for name in list(calls) * often(2, 6):
            environment = os.environ | {"LD_PRELOAD": SUPPORT + "/libkill_at_call.so",
                                        "VDBLIC_KILL_AT": f"{name} {choice.randint(1, calls[name])}"}
            run = self.start(self.flow(), "--resume", "--checkpoint-every", 1, env=environment)
            messages = run.communicate(timeout=60)[1]
            self.assertEqual(run.returncode, -signal.SIGKILL, messages)
        self.finish(expected, self.flow())

    def test_kills_with_other_methods_and_parameters(self):
        last = often(8, FRAMES)
        for seed, arguments in enumerate((("--method", "uflic"), ("--method", "lic"), ("--life", 1), ("--life", 9),
                                          ("--method", "auflic-2004", "--with", "vorticity,hits"),
                                          ("--method", "streaks", "--refine", 2), ("--method", "ibfv"),
                                          ("--method", "lea"), ("--method", "ufac"))):
            self.check_kills(often(1, 4), random.Random(seed), self.flow(), *arguments, last=last)

    def test_kills_while_the_domain_changes(self):
        last = often(16, FRAMES)
        for method in ("auflic",), ("uflic",), ("streaks", "--refine", 2), ("ibfv",), ("lea",):
            self.check_kills(often(2, 6), random.Random(5), *self.moving_ball(), "--method", *method, last=last)

    def check_kills(self, kills, choice, *arguments, last):
        expected = self.whole(*arguments, frames=f"1-{last}")
        self.kill_often(kills, choice, *arguments, last=last)
        self.finish(expected, *arguments, frames=f"1-{last}")
        self.clear()

    def test_kills_of_a_run_that_reads_paths(self):
        names = [str(self.flow()) % frame for frame in range(1, FRAMES + 1)]
        (self.folder / "names").write_text("\n".join(names), encoding="utf-8")
        for frames in 3, 9:
            with open(self.folder / "names", encoding="utf-8") as paths:
                self.kill_when(lambda n=frames: self.outputs_there() > n, "-", "--checkpoint-every", 2, frames=None,
                               stdin=paths)
        with open(self.folder / "names", encoding="utf-8") as paths:
            shutil.move(self.folder / "names", self.shared / "names")
            self.finish(self.whole(self.flow()), "-", frames=None, stdin=paths)

    def clear(self):
        for path in self.folder.iterdir():
            path.unlink()

    # Signals

    def test_a_stopped_run_leaves_a_checkpoint_of_the_last_frame(self):
        expected = self.whole(self.flow())
        for number in signal.SIGINT, signal.SIGTERM, signal.SIGHUP:
            messages = self.interrupted(self.flow(), number=number)
            self.assertIn(f"{CHECKPOINT}: to go on from there, run again with --resume", messages)
            done = self.outputs_there()
            self.assertEqual(self.files(), [CHECKPOINT] + [f"lic.{k:04}.vdb" for k in range(1, done + 1)])
            self.assertLess(done, FRAMES)
            messages = self.finish(expected, self.flow())
            self.assertIn(f"{CHECKPOINT}: {done} textures are done", messages)
            self.clear()

    def test_a_kill_during_preroll(self):
        arguments = self.flow(), "--preroll", 200
        expected = self.whole(*arguments, frames="1-3")
        self.kill_when(lambda: CHECKPOINT in self.files(), *arguments, "--checkpoint-every", 5, frames="1-3", lines=1)
        self.assertGreater(vdb.readMetadata(str(self.folder / CHECKPOINT))["steps"], 0)
        self.finish(expected, *arguments, frames="1-3")

    def test_a_large_domain_is_saved_in_parts(self):
        wide = self.shared / "wide.%04d.vdb"  # 65 x 65 leaves; a file has no more than 4096
        self.tool("vdblic_synth", "abc", "-o", wide, "--size", 520, 520, 1, "--frames", "1-8")
        arguments, frames = (wide, "--preroll", 0), "1-8"
        expected = self.whole(*arguments, frames=frames)
        self.interrupted(*arguments, after=2, frames=frames)
        done = self.outputs_there()
        parts = [f"checkpoint.lic.s{done}.p{number}.vdb" for number in range(2)]
        self.assertEqual([name for name in self.files() if "checkpoint" in name], [*parts, CHECKPOINT])
        for part in parts:
            self.assertEqual(vdb.readMetadata(str(self.folder / part))["steps"], done)
            whole = self.contents(part)
            (self.folder / part).unlink()
            self.assertIn(f"{CHECKPOINT}: needs {part}, which is not there: put it back",
                          self.refused(3, *arguments, frames=frames))
            (self.folder / part).write_bytes(whole[:-1000] + bytes(1000))
            self.assertIn(f"{part}: cannot be read as a .vdb file", self.refused(3, *arguments, frames=frames))
            (self.folder / part).write_bytes(whole)
        choice = random.Random(5)
        for _ in range(6):
            farther, pause = min(self.outputs_there() + 1, 7), choice.uniform(0, 0.05)

            def moment(farther=farther, pause=pause):
                if self.outputs_there() < farther:
                    return False
                time.sleep(pause)
                return True

            self.kill_when(moment, *arguments, "--checkpoint-every", 1, frames=frames, lines=7)
        self.finish(expected, *arguments, frames=frames)

    def test_without_checkpoints(self):
        messages = self.interrupted(self.flow(), "--checkpoint-every", 0)
        self.assertNotIn("checkpoint", messages)
        self.assertNotIn(CHECKPOINT, self.files())
        messages = self.finish(self.whole(self.flow()), self.flow(), "--checkpoint-every", 0)
        self.assertIn(f"no {CHECKPOINT}: starting from the beginning", messages)

    # Other ends of a run

    def test_an_input_that_is_repaired(self):
        for frame in range(1, FRAMES + 1):
            shutil.copy2(str(self.flow()) % frame, self.shared / f"w.{frame:04}.vdb")
        broken = self.shared / "w.0009.vdb"
        good = broken.read_bytes()
        broken.write_bytes(good[:-30])
        run = self.start(self.shared / "w.%04d.vdb")
        messages = run.communicate(timeout=60)[1]
        self.assertEqual(run.returncode, 3)
        self.assertIn("w.0009.vdb", messages)
        self.assertEqual(self.files(), [CHECKPOINT] + [f"lic.{k:04}.vdb" for k in range(1, 8)])
        broken.write_bytes(good)
        self.assertIn("7 textures are done", self.finish(self.whole(self.flow()), self.shared / "w.%04d.vdb"))

    def test_a_checkpoint_that_cannot_be_written(self):
        self.interrupted(self.flow(), "--checkpoint-every", 3)
        output, checkpoint = (len(self.contents(name)) for name in ("lic.0001.vdb", CHECKPOINT))
        self.assertLess(1.2 * output, checkpoint)
        before = self.contents(CHECKPOINT)
        limit = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (int(1.2 * output),) * 2),
                 "restore_signals": False}
        run = self.start(self.flow(), "--resume", "--checkpoint-every", 3, **limit)
        messages = run.communicate(timeout=60)[1]
        self.assertEqual(run.returncode, 4, messages)
        self.assertRegex(messages, f"{CHECKPOINT}: cannot be .*File too large; --checkpoint-every 0 does without")
        self.assertEqual(self.contents(CHECKPOINT), before)
        self.finish(self.whole(self.flow()), self.flow())

    # Refused and accepted changes

    def refused(self, status, *arguments, **options):
        """Resuming is refused and changes no file but a lock that a kill left; returns the message."""
        contents = lambda: {name: self.contents(name) for name in self.files() if not name.endswith(".lock")}
        before = contents()
        run = self.start(*arguments, "--resume", **options)
        out, messages = run.communicate(timeout=60)
        self.assertEqual((run.returncode, out), (status, ""), messages)
        self.assertEqual(contents(), before)
        self.assertEqual(len(messages.splitlines()), 1, messages)
        return messages

    def test_finer_textures(self):
        """Refined and with substeps: stopped between frames and inside an interval."""
        for number, options in enumerate((
                ("--refine", 2), ("--substeps", 3), ("--substeps", 4, "--refine", 1, 2, 1, "--method", "uflic"),
                ("--substeps", 2, "--method", "lic"), ("--substeps", 3, "--refine", 2, "--method", "streaks"),
                ("--substeps", 3, "--refine", 2, "--method", "ibfv"), ("--substeps", 2, "--refine", 2, "--method", "lea"),
                ("--substeps", 2, "--method", "ufac"))):
            arguments, frames = (self.flow(), *options), "1-6" if "--substeps" in options else "1-10"
            whole = self.whole(*arguments, frames=frames)
            for after in often((6 + number % 2,), (6, 7)):
                self.interrupted(*arguments, after=after, frames=frames)
                last = self.folder / f"lic.{self.outputs_there():04}.vdb"
                last.rename(self.folder / "kept.vdb")
                self.assertIn(f"{last.name} was finished, but it is not there", self.refused(3, *arguments, frames=frames))
                (self.folder / "kept.vdb").rename(last)
                self.finish(whole, *arguments, frames=frames)
                self.clear()

    def test_motion_and_a_steady_field(self):
        """The factor of the motion is that of the interrupted run, though the first frame is not read again."""
        for arguments, frames in (((self.flow(), "--voxels-per-frame", 2), f"1-{FRAMES}"),
                                  ((str(self.flow()) % 3, "--steady-frames", FRAMES), None)):
            whole = self.whole(*arguments, frames=frames)
            self.interrupted(*arguments, frames=frames)
            self.finish(whole, *arguments, frames=frames)
            self.clear()

    def test_an_input_that_now_ends_inside_an_interval(self):
        """Textures after the last frame are done; without the next frame the run cannot go on from them."""
        done, after = 0, 6
        while done % 4 == 0:  # until it stops between two frames
            self.clear()
            self.interrupted(self.flow(), "--substeps", 4, after=after)
            done, after = self.outputs_there(), after + 1
        last = done // 4 + 1
        message = self.refused(3, self.flow(), "--substeps", 4, frames=f"1-{last}")
        self.assertIn(f"is past frame {last}, but the input ends there: give the frame range of the first run", message)
        self.finish(self.whole(self.flow(), "--substeps", 4), self.flow(), "--substeps", 4)

    def test_changed_parameters(self):
        noise = self.shared / "n.vdb"
        self.tool("vdblic_noise", "--like", str(self.flow()) % 1, "-o", noise)
        mask = self.shared / "mask.vdb"
        self.tool("vdblic_noise", "--size", 24, 24, 24, "-o", mask)
        changes = {
            "--method": "uflic", "--life": 5, "--velocity": "velocity", "--velocity-unit": "voxel/s",
            "--velocity-scale": 2, "--dt": 0.5, "--nonfinite": "zero", "--carry": "velocity", "--with": "q",
            "--mask": mask, "--bbox": (0, 0, 0, 9, 9, 9), "--bbox-world": (0, 0, 0, 9, 9, 9), "--noise": noise,
            "--seed": 2, "--preroll": 3, "--release-window": 0.5, "--sample-spacing": 0.4, "--tolerance": 0.1,
            "--sharpen": 2, "--noise-share": 0.2, "--texture-name": "smoke", "--refine": 2,
            "--precision": "float", "--compression": "none", "--scalars": "texture", "--substeps": 2,
            "--interpolation": "cubic", "--periodic": "x", "--finish": 1, "--motion": 0.5, "--voxels-per-frame": 2,
            "--frame-velocity": "mean", "--frame-rotation": 2}
        free = {"--help", "--version", "--threads", "--max-memory", "--quiet", "--verbose", "--verify", "--resume",
                "--restart", "--keep-checkpoint", "--checkpoint-every", "--json", "--output", "--frames", "--clamp-frames", "--lead-in", "--renumber", "--fps", "--parameters",
                "--steady-frames", "--scratch"}
        of_streaks = {"--spacing": 3, "--tail": 2.5, "--draw": "lines", "--emit": mask, "--emit-box": (0, 0, 0, 9, 9, 9), "--source": f"air={mask}"}
        of_ibfv = {"--alpha": 0.2}
        of_observer = {"--frame-axis": (0, 1, 0), "--frame-point": (1, 0, 0), "--stay": ()}
        listed = set(re.findall(r"^  (?:-\w,)?(--[\w-]+)", self.run_tool("vdblic_advect", "--help").stdout, re.MULTILINE))
        self.assertEqual(listed, set(changes) | set(of_streaks) | set(of_ibfv) | set(of_observer) | free)

        for base, changed in (("--method", "streaks", "--refine", 2), of_streaks), (("--method", "ibfv"), of_ibfv), (("--frame-rotation", 1), of_observer), ((), changes):
            self.interrupted(self.flow(), *base)
            for option, value in changed.items():
                values = value if isinstance(value, tuple) else (value,)
                message = self.refused(2, self.flow(), *base, option, *values)
                shown = " ".join(map(str, values))
                self.assertRegex(message, rf"{CHECKPOINT}: the run that was interrupted had (no )?{option}.*, this one has "
                                          rf"{option} {re.escape(shown)}")
                self.assertIn("give the same, or delete the checkpoint to start from the beginning", message)
            if base:
                self.clear()
        self.assertIn("this one has --dt 0.5", self.refused(2, self.flow(), "--fps", 2))
        self.clear()
        self.interrupted(self.flow(), "--method", "lic")
        self.assertIn("had --method lic, this one has --method auflic", self.refused(2, self.flow()))
        self.finish(self.whole(self.flow(), "--method", "lic"), self.flow(), "--method", "lic")

    def test_parameters_left_out(self):
        self.interrupted(self.flow(), "--bbox", 0, 0, 0, 19, 19, 19)
        self.assertIn("had --bbox 0 0 0 19 19 19, this one has no --bbox", self.refused(2, self.flow()))

    def test_changed_inputs(self):
        inputs = self.shared / "changed"
        inputs.mkdir()
        for frame in range(1, FRAMES + 1):
            shutil.copy2(str(self.flow()) % frame, inputs / f"v.{frame:04}.vdb")
        self.tool("vdblic_noise", "--like", inputs / "v.0001.vdb", "-o", inputs / "n.vdb")
        self.tool("vdblic_noise", "--size", 24, 24, 24, "-o", inputs / "mask.vdb")
        arguments = inputs / "v.%04d.vdb", "--noise", inputs / "n.vdb", "--mask", inputs / "mask.vdb"
        self.interrupted(*arguments)
        done = self.outputs_there()

        for name, status in ((f"v.{done + 1:04}.vdb", 3), ("v.0002.vdb", 3), ("mask.vdb", 3), ("n.vdb", 2)):
            path = inputs / name
            kept, times = path.read_bytes(), (path.stat().st_atime_ns, path.stat().st_mtime_ns)
            path.write_bytes(kept + b" ")
            os.utime(path, ns=times)
            # The noise and the next frame are read before the comparison; their checksums fail first.
            self.assertRegex(self.refused(3, *arguments),
                             f"size {len(kept)}.*size {len(kept) + 1}|{name}: .* its end is damaged")
            path.write_bytes(kept)
            os.utime(path, ns=(times[0], times[1] + 1))
            self.assertRegex(self.refused(status, *arguments), "modified .* UTC.*modified")
            changed = bytearray(kept)
            changed[25] = ord("0") if changed[25] != ord("0") else ord("1")  # in the identity: a change elsewhere would fail the checksum
            path.write_bytes(changed)
            os.utime(path, ns=times)
            self.assertRegex(self.refused(status, *arguments), "identity .*identity")
            path.write_bytes(kept)
            os.utime(path, ns=times)
        missing = inputs / "v.0003.vdb"
        missing.rename(inputs / "w.vdb")
        self.assertIn("frame 3 is missing", self.refused(3, *arguments))
        (inputs / "w.vdb").rename(missing)

        # Frames not read yet may change.
        self.tool("vdblic_synth", "abc", "-o", inputs / "v.%04d.vdb", "--size", 24, 24, 24, "--frames", FRAMES)
        run = self.start(*arguments, "--resume")
        run.communicate(timeout=60)
        self.assertEqual(run.returncode, 0)

    def test_damaged_checkpoints(self):
        self.interrupted(self.flow())
        good = self.contents(CHECKPOINT)
        for damaged in good[:-100] + bytes([good[-100] ^ 1]) + good[-99:], good[: len(good) // 2], b"", b"something else":
            (self.folder / CHECKPOINT).write_bytes(damaged)
            message = self.refused(3, self.flow())
            self.assertRegex(message, rf"{CHECKPOINT}: cannot be read as a \.vdb file: .*(; or delete the checkpoint|"
                                      r"no checkpoint of vdblic_advect: copy it again, or move it away) to start from "
                                      r"the beginning")
        choice = random.Random(3)
        for _ in range(40):
            damaged = bytearray(good)
            for _ in range(choice.randint(1, 3)):
                damaged[choice.randrange(choice.choice((3000, len(good))))] ^= choice.randrange(1, 256)
            (self.folder / CHECKPOINT).write_bytes(damaged)
            self.assertRegex(self.refused(3, self.flow()), "(delete the checkpoint|away) to start from the beginning")
        shutil.copy(str(self.flow()) % 1, self.folder / CHECKPOINT)
        self.assertIn("is no checkpoint of vdblic_advect", self.refused(3, self.flow()))
        (self.folder / CHECKPOINT).unlink()
        self.assertIn("starting from the beginning", self.finish(self.whole(self.flow()), self.flow()))

    def test_forged_checkpoints(self):
        """Their checksums are right, as an attacker's would be: what contradicts itself is refused, and stays as it is."""
        self.tool("vdblic_synth", "abc", "-o", self.shared / "other.%04d.vdb", "--size", 9, 9, 9, "--frames", "1-4")
        self.tool("vdblic_advect", self.shared / "other.%04d.vdb", "-o", "other.%04d.vdb", "--keep-checkpoint")
        other = self.contents("checkpoint.other.vdb")
        self.clear()
        self.interrupted(self.flow())
        good = self.contents(CHECKPOINT)
        own = vdb_bytes.pairs(good)
        whole, real = (lambda number: struct.pack("<q", number)), (lambda number: struct.pack("<d", number))
        said = "tells of a place where no run is"
        cases = [(3, "was written by VDBLIC 0.9.0, this is VDBLIC", {"creator": b"VDBLIC 0.9.0"}),
                 (2, "had --seed 2, this one has --seed 1", {"seed": b"2"}),
                 (2, "had no --life, this one has --life 4", {"life_span": None}),
                 (2, "had no --life, this one has --life 4", {"life_span": ("bool", b"\1")}),
                 (3, "tells that lic.[0-9]+.vdb was finished, but it is not there", {"steps": whole(1000)}),
                 (3, "lists 0 inputs, fewer than it has frames done", {"input 000000": None}),
                 (3, "lists 1 inputs, fewer than it has frames done", {"input 000001": ("hexagon", b"\1" * 7)}),
                 (3, "differs from what the interrupted run read", {"input 000001": own["input 000002"][1]}),
                 *((3, said, {"steps": whole(number)}) for number in (-1, -2**63)),
                 *((3, said, {name: real(number)}) for name in ("interval", "scaled_motion") for number in (
                     0, -1, numpy.nan, numpy.inf, 1e300, 5e-324)),
                 *((3, said, {"time": real(number)}) for number in (numpy.nan, numpy.inf, -1e300)),
                 *((3, said, {"number_spacing": whole(number)}) for number in (-1, -2**63)),
                 *((3, "lists its parts wrongly|needs .*, which is not there|is no checkpoint|does not belong|cannot be read",
                    {"part 000000": ("string", part)}) for part in (
                     b"", b"../x", b"0 0 0 8 8 8 none.vdb", b"0 0 0 8 8 8 ../lic.0001.vdb", b"0 0 0 8 8 8 lic.0001.vdb",
                     b"9 9 9 0 0 0 notes", b"-2147483648 0 0 2147483647 8 8 " + CHECKPOINT.encode()) if part),
                 *((3, "is no checkpoint of vdblic_advect", {name: value}) for name in (
                     "steps", "interval", "time", "number_spacing", "scaled_motion") for value in (
                         None, ("bool", b"\1"), ("string", b"7"), ("hexagon", b"\1" * 7))),
                 (3, "is no checkpoint of vdblic_advect", {"creator": None}),
                 (3, "is no checkpoint of vdblic_advect", {"creator": b"notes"})]
        (self.folder / "notes").write_bytes(b"notes of a year")
        for status, words, values in cases:
            with self.subTest(words, values=values):
                (self.folder / CHECKPOINT).write_bytes(vdb_bytes.changed(good, **values))
                self.assertRegex(self.refused(status, self.flow()), words)
        (self.folder / CHECKPOINT).write_bytes(vdb_bytes.changed(other, **own))  # the state of another domain
        self.assertRegex(self.refused(3, self.flow()), f"{CHECKPOINT}: .*copy it again")
        foreign = vdb_bytes.changed(good, steps=("string", b"of a dance"))
        (self.folder / CHECKPOINT).write_bytes(foreign)
        self.assertIn("move it away", self.fails(2, "vdblic_advect", self.flow(), "-o", OUTPUTS, "--restart"))
        self.assertEqual(self.contents(CHECKPOINT), foreign)
        (self.folder / CHECKPOINT).write_bytes(good)
        (self.folder / "notes").unlink()
        self.finish(self.whole(self.flow()), self.flow())

    def test_missing_outputs(self):
        self.interrupted(self.flow())
        (self.folder / "lic.0002.vdb").rename(self.folder / "kept.vdb")
        message = self.refused(3, self.flow())
        self.assertIn("tells that lic.0002.vdb was finished, but it is not there", message)
        (self.folder / "kept.vdb").rename(self.folder / "lic.0002.vdb")
        self.finish(self.whole(self.flow()), self.flow())

    def test_damaged_outputs(self):
        """What a resumed run prints as finished is what an interrupted one has written."""
        self.interrupted(self.flow())
        whole, other = self.contents("lic.0002.vdb"), self.contents("lic.0001.vdb")
        turned = bytearray(whole)
        turned[len(whole) // 2] ^= 1
        seeded = self.shared / "seeded"
        seeded.mkdir()
        self.tool("vdblic_advect", self.flow(), "-o", seeded / OUTPUTS, "--frames", "1-2", "--seed", 5)
        (self.folder / "lic.0002.vdb").unlink()  # another run may have linked it
        for content, words in ((b"", "is damaged"), (whole[:-1000], "is damaged"), (bytes(turned), "is damaged"),
                               (other, "it is frame 1"), (b"notes", "is damaged"),
                               ((self.shared / "v.0002.vdb").read_bytes(), "it "),
                               ((seeded / "lic.0002.vdb").read_bytes(), "another run, by its metadata 'seed'")):
            (self.folder / "lic.0002.vdb").write_bytes(content)
            message = self.refused(3, self.flow())
            self.assertRegex(message, f"{CHECKPOINT}: tells that lic.0002.vdb was finished, but it .*{words}|{words}.*")
            self.assertIn("put it back, or delete the checkpoint", message)
        (self.folder / "lic.0002.vdb").write_bytes(whole)
        self.finish(self.whole(self.flow()), self.flow())

    # Two runs at a time

    def waiting(self, *options):
        """A run that waits for paths and has its outputs; ended by the test or at its end."""
        run = self.start("-", *options, frames=None, stdin=subprocess.PIPE)
        self.wait_until(lambda: LOCK in self.files() and self.contents(LOCK), "the run claims its outputs")
        return run

    def test_two_runs_do_not_mix(self):
        run = self.waiting("--seed", 1)
        before = self.files()
        for options in (), ("--seed", 2), ("--resume",), ("--restart",), ("--checkpoint-every", 0):
            message = self.fails(2, "vdblic_advect", self.flow(), "-o", OUTPUTS, "--frames", "1-3", *options)
            self.assertRegex(message, rf"lic\.%04d\.vdb: another run is writing these outputs, process {run.pid} on "
                                      rf"\S+: .*vdblic_advect - -o {OUTPUTS}|another run .* process {run.pid} on ")
            self.assertEqual(self.files(), before)
        self.fails(2, "vdblic_advect", self.flow(), "-o", "./lic.####.vdb", "--frames", "1-3")  # the same names
        self.outputs("vdblic_advect", str(self.flow()) % 1, "-o", "other.%04d.vdb")  # beside them
        (self.folder / "other.0001.vdb").unlink()
        out, messages = run.communicate("".join(f"{str(self.flow()) % frame}\n" for frame in (1, 2, 3)), timeout=120)
        self.assertEqual(run.returncode, 0, messages)
        self.assertEqual(out.split(), ["lic.0001.vdb", "lic.0002.vdb", "lic.0003.vdb"])
        self.assertEqual(self.files(), out.split())

    def test_a_killed_run_claims_nothing(self):
        run = self.waiting()
        run.kill()
        run.wait()
        self.assertEqual(self.files(), [LOCK])
        self.outputs("vdblic_advect", str(self.flow()) % 1, "-o", OUTPUTS)
        self.assertEqual(self.files(), ["lic.0001.vdb"])
        (self.folder / LOCK).write_bytes(b"notes of a year")
        self.assertIn(f"{LOCK}: is no lock of a run",
                      self.fails(4, "vdblic_advect", str(self.flow()) % 1, "-o", OUTPUTS))
        self.assertEqual(self.contents(LOCK), b"notes of a year")

    def test_other_frames(self):
        self.interrupted(self.flow(), frames="1-20")
        self.assertIn("the input has only 3 now", self.refused(3, self.flow(), frames="1-3"))
        self.assertIn("then frame 2, now frame 3", self.refused(3, self.flow(), frames="1-20x2"))
        # Further frames at the end do not affect finished ones.
        self.finish(self.whole(self.flow(), frames="1-24"), self.flow(), frames="1-24")

    def test_a_checkpoint_is_not_removed_unasked(self):
        self.interrupted(self.flow())
        before = {name: self.contents(name) for name in self.files()}
        for arguments in (), ("--life", 2):
            run = self.start(self.flow(), *arguments)
            out, messages = run.communicate(timeout=60)
            self.assertEqual((run.returncode, out), (2, ""), messages)
            self.assertIn(f"{CHECKPOINT}: an earlier run left this checkpoint; go on from it with --resume, or remove it "
                          "and start from the beginning with --restart", messages)
            self.assertEqual({name: self.contents(name) for name in self.files()}, before)
        run = self.start(self.flow(), "--life", 2, "--restart")
        messages = run.communicate(timeout=60)[1]
        self.assertEqual(run.returncode, 0, messages)
        self.assertNotIn(CHECKPOINT, self.files())
        self.finish(self.whole(self.flow(), "--life", 2), self.flow(), "--life", 2)

    def test_a_finished_run_is_extended(self):
        last = f"1-{often(12, FRAMES)}"
        for options in (), ("--substeps", 3), ("--method", "lic"), ("--method", "uflic", "--preroll", 0), ("--method", "streaks", "--refine", 2), ("--method", "ibfv"):
            for frames in "1", "1-2", "1-9", last:
                whole = self.whole(self.flow(), *options, frames=frames)
                run = self.start(self.flow(), *options, "--keep-checkpoint", "--resume", frames=frames)
                messages = run.communicate(timeout=60)[1]
                self.assertEqual(run.returncode, 0, messages)
                kept = [] if frames == "1" and options[1:2] in (("lic",), ("uflic",)) else [CHECKPOINT]
                self.assertEqual(self.files(), kept + sorted(path.name for path in whole.iterdir()))
                for path in whole.iterdir():
                    self.assertEqual(self.contents(path.name), path.read_bytes(), (path.name, frames, options))
            self.assertRegex(messages, r"checkpoint.lic.vdb: (8|24) textures are done")
            self.finish(whole, self.flow(), *options, frames=last)
            self.clear()

    def test_a_part_of_a_sequence(self):
        """Stopped in its lead-in and after it; beside the run of another part."""
        self.interrupted(self.flow(), frames="1-20")
        first = self.files()
        for options in ("--lead-in", 3), (), ("--substeps", 3):
            whole = self.whole(self.flow(), *options, frames="21-30")
            for stop_in_the_lead_in in True, False:
                arguments = (self.flow(), *options, "--checkpoint-every", 1)
                if stop_in_the_lead_in:
                    self.kill_when(lambda: "checkpoint.0021.lic.vdb" in self.files(), *arguments, frames="21-30", lines=1)
                else:
                    self.interrupted(*arguments, after=3, frames="21-30")
                self.assertIn("checkpoint.0021.lic.vdb", self.files())
                changed = ("--lead-in", 2, *options[2:]) if options[:1] == ("--lead-in",) else (*options, "--lead-in", 2)
                self.assertIn("--lead-in 2", self.refused(2, self.flow(), *changed, "-q", frames="21-30"))
                messages = self.start(self.flow(), *options, "--resume", frames="21-30").communicate(timeout=60)[1]
                self.assertIn("textures are done", messages)
                self.assertEqual(set(self.files()) - set(first), {path.name for path in whole.iterdir()})
                for path in whole.iterdir():
                    self.assertEqual(self.contents(path.name), path.read_bytes())
                    (self.folder / path.name).unlink()
        self.finish(self.whole(self.flow(), frames="1-20"), self.flow(), frames="1-20")

    # Pipes

    def test_a_closed_pipe_leaves_a_checkpoint(self):
        expected = self.whole(self.flow())
        for lines in 1, 2, 5, FRAMES - 2, FRAMES - 1:
            run, paths = self.start_held(lines, self.flow())
            self.wait_until(lambda: run.poll() is not None or paths.lines() == lines, "no outputs")
            paths.close()
            messages = run.stderr.read()
            self.assertEqual(run.wait(timeout=30), -signal.SIGPIPE, messages)
            self.assertTrue(CHECKPOINT in self.files() or self.outputs_there() == FRAMES, lines)
            self.finish(expected, self.flow())
            self.clear()

    def test_ctrl_c_to_a_pipeline_leaves_a_checkpoint(self):
        """The first stage waits for the path of an input then."""
        expected, inputs = self.whole(self.flow()), [f"{str(self.flow()) % frame}\n" for frame in range(1, FRAMES + 1)]
        command = (f"{BIN}/vdblic_advect - -o {OUTPUTS} --preroll 4 | "
                   f"{BIN}/vdblic_render - -o i.%04d.png --size 16 16")
        for frames in 1, 4, 9:
            run = subprocess.Popen(["sh", "-c", command], cwd=self.folder, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True, start_new_session=True)
            self.addCleanup(run.stderr.close)
            run.stdin.write("".join(inputs[:frames + 1]))
            run.stdin.flush()
            self.wait_until(lambda: run.poll() is not None or self.outputs_there() >= frames, "no outputs")
            os.killpg(run.pid, signal.SIGINT)
            run.communicate(timeout=60)
            self.wait_until(lambda: not self.advects(run.pid), "the run goes on")
            self.assertIn(CHECKPOINT, self.files())
            for path in self.folder.glob("i.*"):
                path.unlink()
            with open(self.shared / "inputs", "w+", encoding="utf-8") as paths:
                paths.writelines(inputs)
                paths.seek(0)
                self.finish(expected, "-", frames=None, stdin=paths)
            self.clear()

    @staticmethod
    def advects(group):
        """Whether a process group has a run that is not over."""
        listed = subprocess.run(["ps", "-eo", "pgid=,args="], capture_output=True, text=True, check=True).stdout
        return any(int(line.split()[0]) == group and "/vdblic_advect" in line for line in listed.splitlines())

    def test_the_checkpoint_is_no_input(self):
        shutil.copy(str(self.flow()) % 1, self.folder / CHECKPOINT)
        self.assertIn("is no checkpoint of vdblic_advect, and one would replace it",
                      self.fails(2, "vdblic_advect", CHECKPOINT, "-o", OUTPUTS, "--restart"))
        self.tool("vdblic_noise", "--like", CHECKPOINT, "-o", "other.vdb")
        (self.folder / "other.vdb").rename(self.folder / CHECKPOINT)
        for option in "--mask", "--noise":
            self.assertIn("is no checkpoint", self.fails(2, "vdblic_advect", str(self.flow()) % 1, option,
                                                         f"{CHECKPOINT}:noise", "-o", OUTPUTS, "--restart"))
        self.assertEqual(self.files(), [CHECKPOINT])

    def test_what_is_no_checkpoint_stays(self):
        """Notes, a velocity or a link under the name of a checkpoint, or of a part of one, outlive every run."""
        notes, part = b"notes of a year\n", "checkpoint.lic.s3.p0.vdb"
        velocity = (self.shared / "v.0001.vdb").read_bytes() if self.flow() else b""
        for content in notes, velocity:
            (self.folder / CHECKPOINT).write_bytes(content)
            for options, status in ((), 2), (("--restart",), 2), (("--checkpoint-every", 0), 2), (("--resume",), 3):
                message = self.fails(status, "vdblic_advect", self.flow(), "-o", OUTPUTS, "--frames", "1-3", *options)
                self.assertRegex(message, f"{CHECKPOINT}: .*no checkpoint of vdblic_advect.*move it away")
                self.assertEqual(self.files(), [CHECKPOINT])
                self.assertEqual(self.contents(CHECKPOINT), content)
            (self.folder / CHECKPOINT).unlink()
            (self.folder / part).write_bytes(content)
            self.outputs("vdblic_advect", self.flow(), "-o", OUTPUTS, "--frames", "1-6", "--checkpoint-every", 1)
            self.assertEqual(self.contents(part), content)
            self.clear()

    def test_no_output_replaces_a_checkpoint(self):
        self.interrupted(self.flow())
        before = self.contents(CHECKPOINT)
        one = str(self.flow()) % 1
        for command in (("vdblic_advect", one, "-o"), ("vdblic_synth", "abc", "--size", 8, 8, 8, "--frames", 1, "-o"),
                        ("vdblic_noise", "--size", 8, 8, 8, "-o"), ("vdblic_diff", one, one, "-o"),
                        ("vdblic_info", one, "--json")):
            message = self.fails(2, *command, CHECKPOINT)
            self.assertIn(f"output '{CHECKPOINT}' would replace a checkpoint of vdblic_advect", message)
            self.assertEqual(self.contents(CHECKPOINT), before)
        self.finish(self.whole(self.flow()), self.flow())

    def test_the_checkpoint_is_a_vdb_that_others_can_read(self):
        self.interrupted(self.flow())
        shown = self.printed(CHECKPOINT)
        for part in "life_span: 4", "Name: noise", "Name: particles", "ptdataidx32":
            self.assertIn(part, shown)
        grid = vdb.read(str(self.folder / CHECKPOINT), "noise")
        self.assertEqual(grid.transform, vdb.read(str(self.flow()) % 1, "velocity").transform)
        self.assertEqual(grid.activeVoxelCount(), 24 ** 3)


if __name__ == "__main__":
    unittest.main()
