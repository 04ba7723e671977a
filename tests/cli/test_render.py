"""vdblic_render as a user runs it: volumes by pyopenvdb, images read by OpenImageIO and exrheader."""

import os
import pathlib
import resource
import subprocess
import tempfile
import unittest

import numpy
import pyopenvdb as vdb

BIN = pathlib.Path(os.environ["VDBLIC_BIN"])


def grid(name, values, voxel_size=0.1):
    result = vdb.FloatGrid()
    result.name = name
    result.fill((0, 0, 0), tuple(s - 1 for s in values.shape), 0.0, True)
    result.copyFromArray(values.astype(numpy.float32))
    result.fill((0, 0, 0), (0, 0, 0), float(values[0, 0, 0]), True)
    result.transform = vdb.createLinearTransform(voxelSize=voxel_size)
    return result


class Render(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="vdblic-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        random = numpy.random.default_rng(5)
        for frame in (3, 4):
            shape = (20, 16, 12)
            grids = [grid("density", random.random(shape)), grid("magnitude", random.random(shape))]
            vdb.write(str(self.folder / f"lic.{frame:04}.vdb"), grids=grids)

    def run_tool(self, *arguments, **options):
        return subprocess.run(
            [str(BIN / "vdblic_render"), *map(str, arguments)],
            text=True, capture_output=True, cwd=self.folder, timeout=60, **options)

    def renders(self, *arguments, **options):
        done = self.run_tool(*arguments, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.splitlines()

    def fails(self, status, *arguments, **options):
        before = sorted(self.folder.iterdir())
        done = self.run_tool(*arguments, **options)
        self.assertEqual(done.returncode, status, f"{arguments} {done.stderr}")
        self.assertEqual(done.stdout, "")
        self.assertEqual(sorted(self.folder.iterdir()), before)
        return done.stderr

    def test_exr(self):
        self.assertEqual(self.renders("lic.%04d.vdb", "-o", "image.####.exr", "--size", 64, 48),
                         ["image.0003.exr", "image.0004.exr"])
        header = subprocess.run(["exrheader", self.folder / "image.0004.exr"], text=True, capture_output=True).stdout
        for line in ("R, 16-bit floating-point", "A, 16-bit floating-point", "compression (type compression): zip",
                     "dataWindow (type box2i): (0 0) - (63 47)", 'creator (type string): "VDBLIC',
                     "frame (type int): 4", 'colorMap (type string): "turbo"', "worldToCamera (type m44f)",
                     "worldToNDC (type m44f)", 'source (type string): "lic.0004.vdb"'):
            self.assertIn(line, header)

    def test_png_is_the_exr_over_the_background(self):
        for ending in ("exr", "png"):
            self.renders("lic.0003.vdb", "-o", f"a.{ending}", "--size", 40, 30, "--background", 0.2, 0.4, 0.6)
        run = lambda *command: subprocess.run(command, cwd=self.folder, text=True, capture_output=True)
        run("oiiotool", "a.exr", "--ch", "R,G,B", "--colorconvert", "linear", "sRGB", "-d", "uint8", "-o", "b.png")
        same = run("idiff", "-fail", str(1.1 / 255), "-warn", str(1.1 / 255), "a.png", "b.png")
        self.assertEqual(same.returncode, 0, same.stdout)
        # The volume is seen, and beside it the background.
        stats = run("oiiotool", "a.png", "--printstats").stdout
        spread = next(line for line in stats.splitlines() if "Stats StdDev" in line).split()[2:5]
        self.assertGreater(max(map(float, spread)), 5)
        first = run("oiiotool", "--dumpdata", "a.png").stdout.splitlines()[1]
        self.assertIn("Pixel (0, 0): 51 102 153", first)

    def test_known_opacity(self):
        values = numpy.full((32, 8, 8), 0.5)
        vdb.write(str(self.folder / "slab.vdb"), grids=[grid("fog", values), grid("magnitude", values)])
        self.renders("slab.vdb", "--texture", "fog", "-o", "slab.exr", "--size", 9, 9, "--opacity", "0:0.05,1:0.05",
                     "--modulate", 0, "--range", 0, 1, "--colormap", "gray", "--step", 0.05, "--fov", 0.01,
                     "--eye", -1000, 0.35, 0.35, "--target", 1.55, 0.35, 0.35)
        shown = subprocess.run(["oiiotool", self.folder / "slab.exr", "--ch", "A", "--printstats"],
                               text=True, capture_output=True, check=True).stdout
        average = float(next(line for line in shown.splitlines() if "Stats Avg" in line).split()[2])
        self.assertAlmostEqual(average, 1 - 0.95 ** 32, delta=2e-3)

    def test_threads(self):
        images = []
        for threads in (1, 2, 7):
            (path,) = self.renders("lic.0003.vdb", "-o", f"t{threads}.png", "--size", 70, 50, "--threads", threads)
            images.append((self.folder / path).read_bytes())
        self.assertEqual(images[0], images[1])
        self.assertEqual(images[0], images[2])

    def test_standard_input(self):
        self.assertEqual(self.renders("-", "-o", "image.%04d.png", "--size", 20, 20, input="lic.0004.vdb\nlic.0003.vdb\n"),
                         ["image.0004.png", "image.0003.png"])

    def test_usage(self):
        good = ["lic.0003.vdb", "-o", "a.png"]
        for bad in (["--size", 0, 10], ["--size", 10], ["--fov", "nan"], ["--fov", "inf"], ["--step", 0], ["--step", "x"],
                    ["--range", 2, 1], ["--range", "nan", 1], ["--opacity", "0:2"], ["--opacity", "half"],
                    ["--colormap", "rainbow"], ["--modulate", 2], ["--eye", 1, 2], ["--up", 0, 0, 0],
                    ["--background", 0, 0, 7], ["--threads", 0], ["--frames", "1-3"], ["--unknown"]):
            self.fails(2, *good, *bad)
        self.fails(2, "lic.0003.vdb")
        self.fails(2, "lic.0003.vdb", "-o", "a.jpg")
        self.fails(2, "lic.%04d.vdb", "-o", "a.png")

    def test_bad_input(self):
        self.assertIn("nothing.vdb", self.fails(3, "nothing.vdb", "-o", "a.png"))
        self.assertIn("density", self.fails(3, "lic.0003.vdb", "-o", "a.png", "--texture", "smoke"))
        (self.folder / "broken.vdb").write_bytes((self.folder / "lic.0003.vdb").read_bytes()[:300])
        self.fails(3, "broken.vdb", "-o", "a.png")
        self.fails(3, "-", "-o", "a.png", input="")

    def test_output_cannot_be_written(self):
        self.fails(4, "lic.0003.vdb", "-o", "missing/a.png")
        for ending in ("exr", "png"):
            # As on a full disk, the file cannot grow to its size.
            self.fails(4, "lic.0003.vdb", "-o", f"a.{ending}", restore_signals=False,
                       preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)))


if __name__ == "__main__":
    unittest.main()
