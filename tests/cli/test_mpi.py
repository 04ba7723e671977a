"""vdblic_advect_mpi: several ranks under mpirun write what one process writes."""

import fcntl
import os
import pathlib
import re
import shutil
import signal
import subprocess
import unittest

import pyopenvdb as vdb

from support import BIN, MPI_ENVIRONMENT, WAKE, ToolTest, often, skip

if not (BIN / "vdblic_advect_mpi").exists():
    skip("built without MPI")
if not shutil.which("mpirun"):
    skip("mpirun is not installed")

DATA = os.environ.get("VDBLIC_DATA")
SUPPORT = os.environ["VDBLIC_TEST_SUPPORT"]
not_sanitized = unittest.skipIf(os.environ.get("VDBLIC_SANITIZED") == "1", "a sanitizer wants to be loaded first")


class Ranks(ToolTest):
    def command(self, ranks, tool, *arguments):
        return ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), str(BIN / tool), *map(str, arguments)]

    def run_ranks(self, ranks, tool, *arguments, stdin=""):
        return subprocess.run(self.command(ranks, tool, *arguments), input=stdin, text=True, capture_output=True,
                              cwd=self.folder, env=MPI_ENVIRONMENT, timeout=300, check=False)

    def by_ranks(self, ranks, *arguments, stdin=""):
        return self.run_ranks(ranks, "vdblic_advect_mpi", "--threads", 1, *arguments, stdin=stdin)

    def render(self, ranks, *arguments):
        return self.run_ranks(ranks, "vdblic_render_mpi", *arguments)

    def one_process(self, *arguments):
        self.outputs("vdblic_advect", *arguments, "-o", "one.%04d.vdb", "--threads", 2)

    def assert_same(self, name):
        """The files of this name and those of one process have the same bytes."""
        numbers = [path.name.split(".")[1] for path in self.folder.glob("one.*.vdb")]
        self.assertTrue(numbers)
        for number in numbers:
            self.assertEqual(self.contents(f"{name}.{number}.vdb"), self.contents(f"one.{number}.vdb"), number)

    def compare(self, ranks, *arguments):
        self.one_process(*arguments)
        for number in ranks:
            run = self.by_ranks(number, *arguments, "-o", f"by{number}.%04d.vdb", "-q")
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assert_same(f"by{number}")
            self.assertEqual(len(run.stdout.splitlines()), len(list(self.folder.glob("one.*.vdb"))))  # by rank 0 alone

    def test_a_refined_wake(self):
        self.compare([1, 2, 7], WAKE, "--frames", "1-2", "--refine", 2, "--with", "vorticity,q,hits", "--preroll", 2)

    def test_a_periodic_box(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 32, 32, 32, "--frames", "1-3")
        for axes, ranks, *options in (
                ("x,y,z", (2, 3, 7), "--with", "vorticity"),
                ("x", (5,), "--refine", 2, "--interpolation", "cubic"),
                ("x,y,z", (3,), "--method", "streaks", "--spacing", 4),
                ("x,z", (3,), "--method", "streaks", "--draw", "lines", "--spacing", 4, "--with", "vorticity"),
                ("y,z", (3,), "--method", "ibfv", "--substeps", 2)):
            self.compare(ranks, "v.%04d.vdb", "--periodic", axes, *options)

    def test_streaks(self):
        self.compare([1, 3, 5], WAKE, "--frames", "1-3", "--method", "streaks", "--refine", 4, "--substeps", 2,
                     "--with", "vorticity", "--source", f"low={self.low_half()}")

    def test_streaks_as_lines(self):
        """The values at a line's points are at the ranks that have their voxels, carried ones at rank 0."""
        self.outputs("vdblic_advect", WAKE, "--frames", "1-3", "--preroll", 0, "--with", "velocity,q", "-o", "v.%04d.vdb")
        lines = "v.%04d.vdb", "--method", "streaks", "--draw", "lines", "--spacing", 3
        for ranks, *options in (
                ((1, 2, 5), "--with", "vorticity,q", "--substeps", 2, "--source", f"low={self.low_half()}"),
                ((3,), "--carry", "q", "--substeps", 2, "--emit-box", 0, -0.05, 0, 0.1, 0, 0.05)):
            self.compare(ranks, *lines, *options)

    def test_looking_back(self):
        """Refined, so that the domain is cut, with substeps and a run that goes on with other ranks."""
        for method, ranks in ("ibfv", (1, 3, 5)), ("lea", (3,)), ("ufac", (5,)):
            arguments = (WAKE, "--method", method, "--refine", 2, "--substeps", 2)
            self.compare(ranks, *arguments, "--frames", "1-2")
            for number, frames in (3, "1"), (5, "1-2"):
                run = self.by_ranks(number, *arguments, "--frames", frames, "-o", f"{method}.%04d.vdb", "--resume",
                                    "--keep-checkpoint")
                self.assertEqual(run.returncode, 0, run.stderr)
            self.assert_same(method)

    def test_streaks_go_on_with_other_ranks(self):
        for draw, *options in ("voxels", "--refine", 4), ("lines", "--with", "q"):
            arguments = (WAKE, "--method", "streaks", "--draw", draw, *options)
            self.one_process(*arguments, "--frames", "1-4")
            for ranks, frames in (3, "1-2"), (5, "1-4"):
                run = self.by_ranks(ranks, *arguments, "--frames", frames, "-o", f"{draw}.%04d.vdb", "--resume",
                                    "--keep-checkpoint")
                self.assertEqual(run.returncode, 0, run.stderr)
            self.assertIn("textures are done", run.stderr)
            self.assert_same(draw)

    def low_half(self):
        """A mask of the lower half of space, as a file."""
        grid = vdb.BoolGrid()
        grid.name = "mask"
        grid.fill((-100, -100, -100), (200, 24, 200), True)
        grid.transform = vdb.createLinearTransform(0.0025)
        vdb.write(str(self.folder / "low.vdb"), grid)
        return "low.vdb"

    def test_a_steady_field_in_slow_motion(self):
        self.compare([3], str(WAKE) % 2, "--steady-frames", 3, "--voxels-per-frame", 1, "--preroll", 0)

    def test_observers(self):
        """Each rank reads the part of a frame that its part of the observer's voxels passes."""
        moving = WAKE, "--frames", "2-4", "--lead-in", 0, "--preroll", 1
        self.compare([2, 5], *moving, "--frame-velocity", "mean", "--refine", "2,1,1", "--with", "vorticity")
        self.compare([3], *moving, "--frame-velocity", 0.3, 0, 0, "--frame-rotation", 20, "--frame-axis", 0, 1, 3,
                     "--method", "streaks", "--bbox-world", 0, 0, 0, 0.2, 0.1, 0.1, "--dt", 0.05)
        self.compare([2], *moving, "--frame-velocity", 0.3, 0, 0, "--carry", "velocity", "--stay")
        self.compare([2], *moving, "--frame-velocity", 0.3, 0, 0, "--method", "streaks", "--draw", "lines", "--with", "q")

    def test_carried_grids(self):
        self.compare([3], WAKE, "--frames", "1-2", "--refine", "2,1,1", "--carry", "velocity", "--preroll", 0)

    def test_pictures(self):
        self.outputs("vdblic_advect", WAKE, "--frames", "1-3", "--preroll", 0, "-o", "t.%04d.vdb")
        looks = "t.%04d.vdb", "--size", 96, 64, "--look", "smoke", "--threads", 1
        self.outputs("vdblic_render", *looks, "-o", "one.%04d.exr")
        for ranks in 2, 4:  # the fourth has no frame
            run = self.render(ranks, *looks, "-o", f"by{ranks}.%04d.exr")
            self.assertEqual(run.returncode, 0, run.stderr)
            names = [f"by{ranks}.{frame:04}.exr" for frame in (1, 2, 3)]
            self.assertEqual(sorted(run.stdout.split()), names)
            for frame, name in enumerate(names, 1):
                self.assertEqual(self.contents(name), self.contents(f"one.{frame:04}.exr"))
        (self.folder / "t.0002.vdb").write_bytes(self.contents("t.0002.vdb")[:9000])
        run = self.render(2, *looks, "-o", "bad.%04d.exr")
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertEqual(len([line for line in run.stderr.splitlines() if "error: " in line]), 1, run.stderr)
        self.assertIn("t.0002.vdb", run.stderr)
        run = self.render(2, *looks, "--film", "x.mp4")
        self.assertEqual(run.returncode, 2, run.stderr)

    def assert_failed(self, run, status, *words):
        """The run ended with this status and one message that has these words."""
        own = [line for line in run.stderr.splitlines() if "error: " in line]
        self.assertEqual(run.returncode, status, run.stderr)
        self.assertEqual(len(own), 1, run.stderr)
        for word in words:
            self.assertIn(word, own[0])

    def test_a_picture_by_several_ranks(self):
        self.outputs("vdblic_advect", WAKE, "--frames", 1, "--preroll", 0, "--with", "vorticity,q", "--refine", 2,
                     "-o", "t.%04d.vdb")
        for ranks, suffix, *options in (
                (1, "exr"),
                (2, "exr", "--aov", "all", "--look", "vortex", "--shadows", 0.7, "--samples", 2),
                (3, "png", "--look", "flow", "--annotate", "box,axes,colorbar,time", "--solid", "domain"),
                (3, "exr", "--look", "vortex", "--solid", "domain", "--ground", "below", "--aperture", 0.01,
                 "--samples", 3, "--aov", "depth,normal", "--clip-plane", 0.08, 0, 0.03, 0, 1, 0.1),
                (4, "exr", "--look", "smoke", "--eye", 0.08, 0.01, 0.03, "--target", 0.2, 0, 0.03),
                (5, "exr", "--look", "ink", "--by", "vorticity", "--clip-plane", 0.08, 0, 0.03, 1, 0.3, 0.1),
                (6, "exr", "--shading", "lines", "--halo", 1, "--projection", "orthographic", "--stretch", 1, 1, 3),
                (7, "png", "--look", "xray", "--opacity-by", "q", "--roi-box", 0.02, -0.05, 0, 0.1, 0.05, 0.05)):
            with self.subTest(ranks=ranks, options=options):
                arguments = "t.0001.vdb", "--size", 200, 130, "--threads", 1, *options
                self.outputs("vdblic_render", *arguments, "-o", f"one.{suffix}")
                run = self.render(ranks, *arguments, "-o", f"many.{suffix}")
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertEqual(run.stdout.split(), [f"many.{suffix}"])
                self.assertEqual(self.contents(f"many.{suffix}"), self.contents(f"one.{suffix}"))

    def test_lines_in_a_texture_by_several_ranks(self):
        self.outputs("vdblic_advect", WAKE, "--frames", 1, "--preroll", 0, "-o", "t.%04d.vdb")
        self.outputs("vdblic_advect", WAKE, "--frames", 1, "--method", "streaks", "--draw", "lines", "--spacing", 3, "--with", "q", "-o",
                     "l.%04d.vdb")
        arguments = ("t.%04d.vdb", "--lines", "l.%04d.vdb", "--size", 200, 130, "--threads", 1, "--look", "vortex", "--opacity-by", "magnitude",
                     "--ground", "below", "--solid", "domain", "--aov", "depth,normal")
        self.outputs("vdblic_render", *arguments, "-o", "one.%04d.exr")
        run = self.render(3, *arguments, "-o", "many.%04d.exr")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(self.contents("many.0001.exr"), self.contents("one.0001.exr"))
        (self.folder / "l.0001.vdb").unlink()
        self.assert_failed(self.render(3, *arguments, "-o", "bad.%04d.exr"), 3, "l.0001.vdb", "missing")

    def test_pictures_of_lines(self):
        """At frames and between them; a picture of fewer than the ranks is cut."""
        self.outputs("vdblic_advect", WAKE, "--frames", "1-3", "--method", "streaks", "--draw", "lines", "--spacing", 3, "--with", "q",
                     "-o", "l.%04d.vdb")
        for ranks, numbers, *options in (
                (2, (1, 2, 3)),
                (3, (1, 2, 3, 4, 5), "--substeps", 2, "--opacity-by", "q"),
                (2, (2, 4, 6, 7), "--substeps", 4, "--frames", "2,4,6-7"),
                (3, (6,), "--substeps", 4, "--frames", 6, "--ground", "below", "--solid", "domain", "--aov", "depth")):
            with self.subTest(options):
                arguments = "l.%04d.vdb", "--size", 120, 80, "--threads", 1, *options
                self.outputs("vdblic_render", *arguments, "-o", "one.%04d.exr")
                run = self.render(ranks, *arguments, "-o", "many.%04d.exr")
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertEqual(sorted(run.stdout.split()), [f"many.{number:04}.exr" for number in numbers])
                for number in numbers:
                    self.assertEqual(self.contents(f"many.{number:04}.exr"), self.contents(f"one.{number:04}.exr"))
        (self.folder / "l.0002.vdb").write_bytes(self.contents("l.0002.vdb")[:9000])
        self.assert_failed(self.render(3, "l.%04d.vdb", "--substeps", 2, "-o", "bad.%04d.exr"), 3, "l.0002.vdb")

    def test_a_frame_larger_than_the_memory_of_a_rank(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 208, 208, 208, "--frames", "1-2")
        self.outputs("vdblic_advect", "v.%04d.vdb", "--frames", 1, "--preroll", 0, "-o", "t.%04d.vdb")
        shutil.copy(self.folder / "t.0001.vdb", self.folder / "t.0002.vdb")
        arguments = "t.%04d.vdb", "--size", 64, 48, "--look", "flow"
        self.outputs("vdblic_render", *arguments, "-o", "one.%04d.exr")
        little = *arguments, "--max-memory", "320M", "--threads", 1
        run = self.render(2, *little, "-o", "many.%04d.exr")  # as many frames as ranks
        self.assertEqual(run.returncode, 0, run.stderr)
        for frame in 1, 2:
            self.assertEqual(self.contents(f"many.{frame:04}.exr"), self.contents(f"one.{frame:04}.exr"))

    def test_errors_in_a_shared_picture(self):
        self.outputs("vdblic_advect", WAKE, "--frames", "1-2", "--preroll", 0, "-o", "t.%04d.vdb")
        arguments = "t.%04d.vdb", "--size", 96, 64, "--threads", 1
        self.outputs("vdblic_render", *arguments, "-o", "one.%04d.exr")
        whole = self.contents("t.0002.vdb")
        (self.folder / "t.0002.vdb").write_bytes(whole[:len(whole) // 2])
        run = self.render(3, *arguments, "-o", "bad.%04d.exr")
        self.assert_failed(run, 3, "t.0002.vdb")
        (self.folder / "t.0002.vdb").write_bytes(whole[:9000] + b"damaged" + whole[9007:])
        run = self.render(3, *arguments, "--keep-going", "-o", "bad.%04d.exr")
        self.assertEqual(run.returncode, 3, run.stderr)
        self.assertIn("the frame is left out", run.stderr)
        self.assertEqual(run.stdout.split(), ["bad.0001.exr"])
        (self.folder / "t.0002.vdb").write_bytes(whole)
        self.assert_failed(self.render(3, *arguments, "-o", "absent/x.%04d.exr"), 4, "absent")
        run = self.render(3, *arguments, "--by", "nothing", "-o", "x.%04d.exr")
        self.assert_failed(run, 3, "'nothing'", "t.0001.vdb")
        (self.folder / "half.0001.exr").write_bytes(self.contents("one.0001.exr"))
        run = self.render(3, *arguments, "--skip-existing", "-o", "half.%04d.exr")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(run.stdout.split(), ["half.0001.exr", "half.0002.exr"])
        self.assertEqual(self.contents("half.0002.exr"), self.contents("one.0002.exr"))

    def test_a_shared_picture_on_a_full_disk(self):
        self.outputs("vdblic_advect", WAKE, "--frames", 1, "--preroll", 0, "-o", "t.%04d.vdb")
        small = self.folder / "small"
        small.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", small], check=False).returncode:
            self.skipTest("cannot mount a small disk")
        self.addCleanup(subprocess.run, ["umount", small], check=True)
        run = self.render(3, "t.0001.vdb", "--size", 900, 700, "--precision", "float", "-o", "small/x.exr")
        self.assert_failed(run, 4, "No space left on device")
        self.assertEqual(list(small.iterdir()), [])

    def by_two(self, tool, *arguments, one, other):
        """Two ranks with options of their own each."""
        command = self.command(1, tool, *arguments, *one) + [":"] + self.command(1, tool, *arguments, *other)[4:]
        return subprocess.run(command, text=True, capture_output=True, cwd=self.folder, env=MPI_ENVIRONMENT, timeout=300,
                              check=False)

    def test_ranks_have_the_same_options(self):
        for one, other, words in ((("--seed", 1), ("--seed", 2), "--seed is '2' at rank 1 and '1' at rank 0"),
                                  (("--life", 8), (), "--life is '4' at rank 1 and '8' at rank 0"),
                                  ((), ("-o", "x.%04d.vdb"), "--output is 'x.%04d.vdb' at rank 1 and"),
                                  ((), ("--life", -1), "--life cannot be -1")):
            own = [options if "-o" in options else (*options, "-o", "s.%04d.vdb") for options in (one, other)]
            run = self.by_two("vdblic_advect_mpi", WAKE, "--frames", 1, one=own[0], other=own[1])
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertIn(words, run.stderr)
            self.assertEqual(run.stderr.count("vdblic_advect_mpi: error: "), 1)
            self.assertEqual(self.files(), [])
        run = self.by_two("vdblic_advect_mpi", WAKE, "--frames", 1, "-o", "s.%04d.vdb", one=("-q",),
                          other=("--threads", 2))  # of these each may have its own
        self.assertEqual((run.returncode, self.files()), (0, ["s.0001.vdb"]), run.stderr)
        self.outputs("vdblic_advect", WAKE, "--frames", 1, "-o", "one.%04d.vdb")
        self.assert_same("s")

    def test_each_option_at_one_rank(self):
        advect = ("vdblic_advect_mpi", WAKE, "-o", "s.%04d.vdb"), (
            ("--frames", "1-2"), ("--refine", 2), ("--method", "lic"), ("--with", "vorticity"), ("--mask", "n.vdb"),
            ("--noise", "n.vdb"), ("--dt", 3), ("--bbox", 0, 0, 0, 5, 5, 5), ("--resume",), ("--keep-checkpoint",),
            ("--checkpoint-every", 1), ("--json", "r.json"), ("--precision", "float"), ("--carry", "velocity"),
            ("--nonfinite", "zero"), ("--voxels-per-frame", 2), ("--steady-frames", 3), ("--preroll", 0))
        render = ("vdblic_render_mpi", "t.%04d.vdb", "-o", "t.%04d.png"), (
            ("--look", "ink"), ("--samples", 2), ("--size", 20, 10), ("--shadows", 0.3), ("--solid", "domain"),
            ("--aov", "depth"), ("--keep-going",), ("--skip-existing",), ("--range", 0, 1), ("--transfer", "t.json"))
        for command, each in advect, render:
            for options in each[::often(9, 1)]:
                with self.subTest(options):
                    run = self.by_two(*command, one=(), other=options)
                    self.assert_failed(run, 2, f"{options[0]} is '", "' at rank 1 and '", "give all ranks the same options")
                    self.assertEqual(self.files(), [])

    def test_a_mistake_at_one_rank(self):
        """No rank waits for one that has ended."""
        own = WAKE, "--frames", 1, "-o", "s.%04d.vdb"
        cases = ((("--nonsense",), "rank 1: .*--nonsense"), (("--version",), "rank 1: it was asked for"),
                 (("--help",), "rank 1: it was asked for help"), (("--threads", 0), "rank 1: --threads"),
                 (("--scratch", "none"), "--scratch none: no such folder"), (("--parameters",), "rank 1: it was asked for"),
                 (("--max-memory", "1K"), "--max-memory .* is too little"), (("--life", "x"), "--life cannot be x"),
                 (("--scratch", "."), "--scratch is of a single process"))
        for options, words in cases[::often(2, 1)]:
            with self.subTest(options):
                run = self.by_two("vdblic_advect_mpi", *own, one=(), other=options)
                self.assertRegex(run.stderr, f"vdblic_advect_mpi: error: {words}")
                self.assert_failed(run, 2)
                self.assertEqual(self.files(), [])
        for options in (("--nonsense",), ("--threads", 0)):  # at rank 0, or at both
            for other in (), options:
                run = self.by_two("vdblic_render_mpi", "t.vdb", "-o", "t.png", one=options, other=other)
                self.assertEqual(run.returncode, 2, run.stderr)
                self.assertEqual(run.stderr.count("--help lists the options"), 1, run.stderr)

    def in_folders(self, lacking, what, tool, *arguments):
        """Three ranks with folders of their own, whose files are those of self.folder; one rank's lacks some."""
        command = ["mpirun", "--oversubscribe", "--bind-to", "none"]
        for rank in range(3):
            own = self.folder / f"rank{rank}"
            shutil.rmtree(own, ignore_errors=True)
            own.mkdir()
            for path in self.folder.glob("*.vdb"):
                shutil.copy2(path, own)
            (own / "out").mkdir()
            if rank == lacking:
                what(own)
            command += [*([":"] if rank else []), "-n", "1", "-wdir", own, BIN / tool, "--threads", 1, *arguments]
        return subprocess.run(list(map(str, command)), text=True, capture_output=True, cwd=self.folder, env=MPI_ENVIRONMENT,
                              timeout=120, check=False)

    def test_what_one_rank_does_not_see(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 10, 10, 10, "--frames", "1-3")
        self.outputs("vdblic_noise", "--like", "v.0001.vdb", "-o", "n.vdb")
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "t.%04d.vdb")
        advect, render = ("vdblic_advect_mpi", "v.%04d.vdb", "-o", "out/o.%04d.vdb"), ("vdblic_render_mpi", "--size", 24, 16)
        without = lambda name: (lambda folder: (folder / name).unlink())
        half = lambda name: (lambda folder: os.truncate(folder / name, 3000))
        cases = ((without("v.0001.vdb"), advect, "the ranks do not see the same frames"),
                 (without("v.0003.vdb"), advect, "the ranks do not see the same frames"),
                 (half("v.0002.vdb"), advect, "v.0002.vdb: .*truncated"),
                 (without("n.vdb"), (*advect, "--mask", "n.vdb"), "n.vdb: no such file"),
                 (without("n.vdb"), (*advect, "--noise", "n.vdb"), "n.vdb: no such file"),
                 (without("t.0002.vdb"), (*render, "t.%04d.vdb", "-o", "out/p.%04d.png"), "frame 2: of the ranks 0 and [12] one"),
                 (half("t.0001.vdb"), (*render, "t.0001.vdb", "-o", "out/p.png"), "t.0001.vdb: .*truncated"))
        for rank in often((1,), (0, 1, 2)):
            for what, command, words in cases:
                with self.subTest(rank=rank, command=command, words=words):
                    run = self.in_folders(rank, what, *command)
                    self.assertRegex(run.stderr, words)
                    self.assert_failed(run, 3)
            for command in (*advect, "--frames", "1-2"), (*render, "t.%04d.vdb", "-o", "out/p.%04d.png"):
                run = self.in_folders(rank, lambda folder: (folder / "out").rmdir(), *command)
                self.assert_failed(run, 4, "out")

    def test_two_runs_do_not_mix(self):
        lock = self.folder / ".checkpoint.in.lock"
        lock.write_bytes(b"")
        with open(lock, "rb") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            run = self.by_ranks(2, WAKE, "--frames", 1, "-o", "in.%04d.vdb")
            self.assert_failed(run, 2, "another run is writing these outputs")
        self.assertEqual(self.by_ranks(2, WAKE, "--frames", 1, "-o", "in.%04d.vdb").returncode, 0)
        self.assertFalse(lock.exists())

    def test_paths_on_standard_input(self):
        paths = "".join(f"{str(WAKE) % number}\n" for number in (1, 2))
        self.outputs("vdblic_advect", "-", "-o", "one.%04d.vdb", "--preroll", 1, stdin=paths)
        run = self.by_ranks(3, "-", "-o", "in.%04d.vdb", "--preroll", 1, stdin=paths)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assert_same("in")

    @unittest.skipUnless(DATA, "VDBLIC_DATA does not name the folder of the large data sets")
    def test_real_sequences(self):
        for pattern, *options in (("era5_west_europe/era5.%04d.vdb", "--frames", "1-3", "--substeps", 2),
                                  ("mantaflow_drift/fluid_data_%04d.vdb", "--frames", "20-22", "--carry", "density",
                                   "--texture-name", "texture")):
            with self.subTest(pattern):
                for path in self.folder.glob("*.vdb"):
                    path.unlink()
                self.compare([3], pathlib.Path(DATA) / pattern, *options)

    def test_one_message_and_the_documented_status(self):
        for status, words, arguments in (
                (2, "--refine cannot be 17; it is 1 to 3 whole", (WAKE, "-o", "x.%04d.vdb", "--refine", 17)),
                (2, "--scratch is of a single process", (WAKE, "-o", "x.%04d.vdb", "--scratch", ".")),
                (2, "--fps cannot be -1", (WAKE, "-o", "x.%04d.vdb", "--fps", "-1")),
                (3, "none.%04d.vdb", ("none.%04d.vdb", "-o", "x.%04d.vdb", "--frames", 1)),
                (4, "absent", (WAKE, "-o", "absent/x.%04d.vdb"))):
            with self.subTest(words):
                run = self.by_ranks(3, *arguments)
                own = [line for line in run.stderr.splitlines() if "vdblic_advect_mpi: " in line]
                self.assertEqual(run.returncode, status, run.stderr)
                self.assertEqual(len(own), 1, run.stderr)
                self.assertIn(words, own[0])
                self.assertEqual(self.files(), [])

    def test_a_full_disk(self):
        small = self.folder / "small"
        small.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "none", small], check=False).returncode:
            self.skipTest("cannot mount a small disk")
        self.addCleanup(subprocess.run, ["umount", small], check=True)
        run = self.by_ranks(3, WAKE, "--frames", "1-3", "-o", "small/x.%04d.vdb", "--checkpoint-every", 1)
        self.assertEqual(run.returncode, 4, run.stderr)
        self.assertIn("No space left on device", run.stderr)
        self.assertTrue(all(path.suffix == ".vdb" for path in small.iterdir()))
        parts = {path.name.split(".")[2] for path in small.glob("checkpoint.x.s*.p*.vdb")}
        self.assertLessEqual(len(parts), 1)  # those of the last checkpoint, if one was complete
        self.assertEqual(len(parts), len(list(small.glob("checkpoint.x.vdb"))))

    FRAMES = WAKE, "--frames", "1-3", "--refine", 2

    def start(self, ranks, rank, call, name, by=signal.SIGKILL):
        """Start or resume a run of FRAMES. One of its ranks gets a signal at a call, as tests/support/kill_at_call.cpp has it."""
        *mpirun, _, _, tool = self.command(ranks, "vdblic_advect_mpi")
        program = list(map(str, (tool, "--threads", 1, *self.FRAMES, "-o", f"{name}.%04d.vdb", "--checkpoint-every", 1,
                                 "--resume")))
        signalled = ["env", f"LD_PRELOAD={SUPPORT}/libkill_at_call.so", f"VDBLIC_KILL_AT={call}",
                     f"VDBLIC_KILL_BY={int(by)}", *program]
        parts = [[":", "-n", str(count), *part] for count, part in
                 ((rank, program), (1, signalled), (ranks - rank - 1, program)) if count > 0]
        run = subprocess.Popen(mpirun + sum(parts, [])[1:], cwd=self.folder, env=MPI_ENVIRONMENT, text=True,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(run.stderr.close)
        self.addCleanup(lambda: run.poll() is None and run.kill())
        return run

    @staticmethod
    def told(process, name):
        """What the kernel tells of a process."""
        return re.search(name + r":\s+(\w+)", pathlib.Path(f"/proc/{process}/status").read_text(encoding="utf-8"))[1]

    def start_held(self, ranks, name):
        """Start or resume a run whose rank 0 stops before it names a first file. @return the run and its ranks' processes"""
        run = self.start(ranks, 0, "linkat 1", name, by=signal.SIGSTOP)
        children = pathlib.Path(f"/proc/{run.pid}/task/{run.pid}/children")
        processes = lambda: [int(child) for child in children.read_text(encoding="ascii").split()]
        self.wait_until(lambda: len(processes()) == ranks and self.told(processes()[0], "State") == "T",
                        "rank 0 does not stop")
        return run, processes()

    def assert_goes_on(self, name):
        """What was written is that of an uninterrupted run, which an interrupted one ends as; no checkpoint is left."""
        self.one_process(*self.FRAMES)
        for path in self.folder.glob(f"{name}.*.vdb"):
            self.assertEqual(path.read_bytes(), self.contents(path.name.replace(name, "one")))
        again = self.by_ranks(2, *self.FRAMES, "-o", f"{name}.%04d.vdb", "--resume")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assert_same(name)
        self.assertFalse([name for name in self.files() if "checkpoint" in name])

    @not_sanitized
    def test_a_request_to_stop(self):
        run, ranks = self.start_held(3, "stop")
        os.kill(run.pid, signal.SIGUSR1)
        self.wait_until(lambda: int(self.told(ranks[0], "ShdPnd"), 16) >> signal.SIGUSR1 - 1 & 1, "no request arrives")
        os.kill(ranks[0], signal.SIGCONT)
        messages = run.stderr.read()
        self.assertEqual(run.wait(timeout=120), 128 + signal.SIGUSR1, messages)
        self.assertIn("checkpoint.stop.vdb", self.files())
        self.assert_goes_on("stop")

    @not_sanitized
    def test_a_killed_rank(self):
        """The others do not wait for ever."""
        for number in 3, 5:
            run, ranks = self.start_held(number, "kill")
            os.kill(ranks[-1], signal.SIGKILL)
            os.kill(ranks[0], signal.SIGCONT)
            messages = run.stderr.read()
            self.assertNotEqual(run.wait(timeout=120), 0, messages)
        self.assert_goes_on("kill")

    @not_sanitized
    def test_ranks_killed_while_they_write(self):
        """At calls of the system that bring an output or a checkpoint to the disk."""
        for rank, call in (0, "linkat 1"), (0, "rename 1"), (2, "fsync 1"), (1, "fsync 2"):
            run = self.start(3, rank, call, "kill")
            messages = run.stderr.read()
            self.assertNotEqual(run.wait(timeout=120), 0, call)
            self.assertIn("signal 9", messages)
        self.assert_goes_on("kill")


if __name__ == "__main__":
    unittest.main()
