"""vdblic_render on the command line: solids, shadows, annotations and films."""

import os
import resource
import signal
import subprocess
import unittest

import pyopenvdb as vdb

from support import BIN, RenderTest

CUBE = "".join(f"v {x} {y} {z}\n" for x in (0.4, 0.8) for y in (0.4, 0.8) for z in (0.4, 0.8)) + \
    "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"


def box(name, low, high, value=1.0, grid=None):
    grid = grid or vdb.FloatGrid()
    grid.name = name
    grid.transform = vdb.createLinearTransform(voxelSize=0.1)
    grid.fill(low, high, value, True)
    return grid


class RenderScene(RenderTest):
    def setUp(self):
        super().setUp()
        for frame in (1, 2, 3):
            grids = []
            for name in "density", "magnitude":
                grid = box(name, (0, 0, 0), (11, 11, 11))
                for x in range(12):
                    grid.fill((x, 0, 0), (x, 11, 11), (x + frame) / 15, True)
                grid.fill((4, 4, 4), (7, 7, 7), 0, False)
                grid.prune()
                grids.append(grid)
            vdb.write(str(self.folder / f"lic.{frame:04}.vdb"), grids=grids, metadata={"time": frame / 24})
        (self.folder / "cube.obj").write_text(CUBE)
        vdb.write(str(self.folder / "mask.vdb"), grids=[box("mask", (4, 4, 4), (7, 7, 7))])

    def alpha(self, name):
        done = subprocess.run(["oiiotool", name, "--ch", "A", "--printstats"], cwd=self.folder, text=True,
                              capture_output=True, check=True)
        return float(next(line for line in done.stdout.splitlines() if "Stats Avg" in line).split()[2])

    thin = ("lic.%04d.vdb", "--frames", 1, "--size", 60, 40, "--opacity", "0:0.001")

    def test_solids(self):
        self.renders(*self.thin, "-o", "none.%04d.exr")
        for k, source in enumerate(["domain", "mask.vdb", "mask.vdb:mask", "cube.obj"]):
            self.renders(*self.thin, "-o", f"{k}.%04d.exr", "--solid", source)
            self.assertGreater(self.alpha(f"{k}.0001.exr"), self.alpha("none.0001.exr") + 0.02, source)
        vdb.write(str(self.folder / "body.0001.vdb"), grids=[box("body", (4, 4, 4), (7, 7, 7))])
        self.renders(*self.thin, "-o", "s.%04d.exr", "--solid", "body.%04d.vdb")
        message = self.refuses(3, "lic.%04d.vdb", "--frames", 2, "-o", "t.%04d.exr", "--solid", "body.%04d.vdb")
        self.assertIn("body.0002.vdb", message)

    def test_bad_solids(self):
        (self.folder / "broken.stl").write_bytes(b"solid x\n facet")
        (self.folder / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        (self.folder / "vast.obj").write_text(CUBE.replace("0.8", "1e30"))
        (self.folder / "big.obj").write_text(CUBE.replace("0.8", "1e5"))
        (self.folder / "point.ply").write_text("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                               "property float y\nproperty float z\nend_header\n0 0 0\n")
        vdb.write(str(self.folder / "vector.vdb"), grids=[vdb.Vec3SGrid()])
        for bad in ("none.vdb", "none.obj", "broken.stl", "open.obj", "vast.obj", "big.obj", "point.ply", "vector.vdb",
                    "mask.vdb:other"):
            message = self.refuses(3, *self.thin, "-o", "a.%04d.exr", "--solid", bad)
            self.assertIn(bad.split(":")[0], message)
        self.refuses(2, *self.thin, "-o", "a.%04d.exr", "--shadows", 1.5)

    def test_annotations_leave_the_picture_as_it_is(self):
        self.renders(*self.thin, "-o", "a.%04d.exr", "--eye", 4, -5, 3)
        self.renders(*self.thin, "-o", "b.%04d.exr", "--eye", 4, -5, 3, "--annotate", "box,axes,colorbar,time,title=T")
        channels = subprocess.run(["exrheader", "b.0001.exr"], cwd=self.folder, text=True, capture_output=True).stdout
        self.assertIn("annotation.A", channels)
        self.assertIn('annotations (type string): "box,axes,colorbar,time,title=T"', channels)
        for name in "a", "b":
            subprocess.run(["oiiotool", f"{name}.0001.exr", "--ch", "R,G,B,A", "-o", f"{name}.exr"], cwd=self.folder,
                           check=True)
        subprocess.run(["idiff", "-fail", "0", "-warn", "0", "a.exr", "b.exr"], cwd=self.folder, check=True)
        self.assertIn("colorbar", self.refuses(2, *self.thin, "-o", "a.%04d.png", "--annotate", "box,legend"))

    def test_threads(self):
        for threads in (1, 5):
            self.renders("lic.%04d.vdb", "-o", f"t{threads}.%04d.png", "--size", 90, 70, "--threads", threads, "--solid",
                         "domain", "--shadows", 0.7, "--annotate", "box,axes,colorbar,time", "--film", f"t{threads}.mp4")
        for name in ("0001.png", "0003.png", "mp4"):
            self.assertEqual(self.contents(f"t1.{name}"), self.contents(f"t5.{name}"))
        for threads in (1, 2, 5):
            self.renders("lic.%04d.vdb", "-o", f"g{threads}.%04d.exr", "--size", 90, 70, "--threads", threads,
                         "--ground", "below", "--aperture", 0.1, "--samples", 3, "--solid", "domain", "--orbit", 0.2,
                         "--aov", "depth")
        for threads in (2, 5):
            self.assertEqual(self.contents("g1.0003.exr"), self.contents(f"g{threads}.0003.exr"))

    def test_ground(self):
        view = *self.thin, "--eye", 4, -5, 3
        self.renders(*view, "-o", "none.%04d.exr", "--ground", "none")
        self.renders(*view, "-o", "plain.%04d.exr")
        self.assertEqual(self.contents("none.0001.exr"), self.contents("plain.0001.exr"))
        for side in "below", "low-z", "high-y", "low-x":
            self.renders(*view, "-o", f"{side}.%04d.exr", "--ground", side)
            self.assertGreater(self.alpha(f"{side}.0001.exr"), self.alpha("none.0001.exr") + 0.05, side)
        subprocess.run(["idiff", "-fail", "0", "-warn", "0", "below.0001.exr", "low-z.0001.exr"], cwd=self.folder,
                       check=True)
        self.renders(*view, "-o", "away.%04d.exr", "--ground", "low-y")  # between the eye and the domain
        self.assertEqual(self.alpha("away.0001.exr"), self.alpha("none.0001.exr"))
        self.assertIn("low-x", self.refuses(2, *view, "-o", "a.%04d.exr", "--ground", "left"))

    def probe(self, name):
        done = subprocess.run(["ffprobe", "-loglevel", "error", "-count_frames", "-show_entries",
                               "stream=width,height,r_frame_rate,nb_read_frames", "-of", "csv=p=0", name],
                              cwd=self.folder, text=True, capture_output=True, check=True)
        return done.stdout.strip()

    def test_film(self):
        self.assertEqual(self.renders("lic.%04d.vdb", "--film", "f.mp4", "--size", 65, 40, "--fps", 12, "--orbit", 0.2),
                         ["f.mp4"])
        self.assertEqual(self.probe("f.mp4"), "66,40,12/1,3")
        self.assertEqual(self.renders("lic.%04d.vdb", "-o", "i.%04d.png", "--film", "g.mp4", "--size", 64, 40),
                         ["i.0001.png", "i.0002.png", "i.0003.png", "g.mp4"])
        self.assertEqual(self.probe("g.mp4"), "64,40,24/1,3")

    def test_an_interrupted_film_leaves_nothing(self):
        before = self.files()
        tool = subprocess.Popen([BIN / "vdblic_render", "-", "-o", "i.%04d.png", "--film", "f.mp4", "--size", "64", "40"],
                                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                                cwd=self.folder)
        tool.stdin.write("lic.0001.vdb\n")
        tool.stdin.flush()
        self.assertEqual(tool.stdout.readline(), "i.0001.png\n")
        tool.send_signal(signal.SIGINT)
        self.assertEqual(tool.wait(60), -signal.SIGINT)
        tool.stdin.close()
        tool.stdout.close()
        self.assertEqual(sorted(set(self.files()) - set(before)), ["i.0001.png"])

    def test_a_full_box_leaves_out_nothing(self):
        vdb.write(str(self.folder / "full.vdb"), grids=[box("density", (0, 0, 0), (9, 9, 9))])
        for name, options in ("a", []), ("b", ["--solid", "domain"]):
            self.renders("full.vdb", "-o", f"{name}.exr", "--size", 40, 30, "--eye", 3, -4, 2, *options)
            subprocess.run(["oiiotool", f"{name}.exr", "--ch", "R,G,B,A", "-o", f"{name}.exr"], cwd=self.folder, check=True)
        subprocess.run(["idiff", "-fail", "0", "-warn", "0", "a.exr", "b.exr"], cwd=self.folder, check=True)

    def test_bad_films(self):
        good = ("lic.%04d.vdb", "--size", 64, 40)
        for bad in (["--film", "f.avi"], ["--film", "f.mp4", "--fps", 0], ["--film", "f.mp4", "-o", "i.%04d.png",
                    "--skip-existing"], ["--film", "h.png", "--histogram", "h.png"]):
            self.refuses(2, *good, *bad)
        self.refuses(4, *good, "--film", "missing/f.mp4")
        self.assertIn("ffmpeg", self.refuses(4, *good, "--film", "f.mp4", env={**os.environ, "PATH": "/nonexistent"}))
        # A disk that becomes full: ffmpeg says so, but ends as if all were well.
        self.renders(*good, "--film", "whole.mp4")
        size = len(self.contents("whole.mp4"))
        for most in 1000, size // 2, size - 100:
            def fill():
                signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
                resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
            message = self.refuses(4, *good, "--film", "f.mp4", preexec_fn=fill, restore_signals=False)
            self.assertIn("f.mp4", message)
        # A frame that cannot be read: the film would lack it.
        (self.folder / "lic.0003.vdb").write_bytes(b"broken")
        self.refuses(3, *good, "--film", "f.mp4")


if __name__ == "__main__":
    unittest.main()
