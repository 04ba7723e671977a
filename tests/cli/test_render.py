"""vdblic_render on the command line: volumes by pyopenvdb, images read by OpenImageIO and exrheader."""

import json
import os
import re
import resource
import subprocess
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, RenderTest


def grid(name, values, transform=None):
    result = vdb.FloatGrid()
    result.name = name
    result.fill((0, 0, 0), tuple(s - 1 for s in values.shape), 0.0, True)
    result.copyFromArray(values.astype(numpy.float32))
    result.fill((0, 0, 0), (0, 0, 0), float(values[0, 0, 0]), True)
    result.transform = transform or vdb.createLinearTransform(voxelSize=0.1)
    return result


class Render(RenderTest):
    def setUp(self):
        super().setUp()
        random = numpy.random.default_rng(5)
        for frame in (3, 4):
            shape = (20, 16, 12)
            grids = [grid("density", random.random(shape)), grid("magnitude", random.random(shape))]
            vdb.write(str(self.folder / f"lic.{frame:04}.vdb"), grids=grids)

    def header(self, name):
        return self.run_peer("exrheader", name)

    def matrix(self, header, name):
        rows = re.search(name + r" \(type m44f\):\s*\(([^()]*)", header).group(1)
        return numpy.array([float(x) for x in rows.split()]).reshape(4, 4)

    def test_exr(self):
        self.assertEqual(self.renders("lic.%04d.vdb", "-o", "image.####.exr", "--size", 64, 48),
                         ["image.0003.exr", "image.0004.exr"])
        header = self.header("image.0004.exr")
        for line in ("R, 16-bit floating-point", "A, 16-bit floating-point", "compression (type compression): zip",
                     "dataWindow (type box2i): (0 0) - (63 47)", 'creator (type string): "VDBLIC',
                     "frame (type int): 4", 'colorMap (type string): "ember"', "worldToCamera (type m44f)",
                     "worldToNDC (type m44f)", 'source (type string): "lic.0004.vdb"',
                     'projection (type string): "perspective"', "chromaticities (type chromaticities)"):
            self.assertIn(line, header)
        self.assertNotIn("Z, ", header)

    def test_size_and_samples(self):
        self.renders("lic.0003.vdb", "-o", "a.exr", "--size", 31, 20, "--samples", 4)
        header = self.header("a.exr")
        self.assertIn("dataWindow (type box2i): (0 0) - (30 19)", header)
        self.assertIn("samples (type int): 4", header)

    def test_exr_variants(self):
        base = ("lic.0003.vdb", "--size", 40, 30, "--halo", 0)  # a pixel of halo alone has no texture
        self.renders(*base, "-o", "half.exr")
        self.renders(*base, "-o", "float.exr", "--precision", "float")
        header = self.header("float.exr")
        self.assertIn("R, 32-bit floating-point", header)
        self.run_peer("idiff", "-fail", 5e-4, "-warn", 5e-4, "half.exr", "float.exr")

    def test_aovs(self):
        base = ("lic.0003.vdb", "--size", 40, 30, "--halo", 0)  # a pixel of halo alone has no texture
        self.renders(*base, "-o", "plain.exr")
        self.renders(*base, "-o", "aov.exr", "--aov", "all")
        header = self.header("aov.exr")
        for line in ("Z, 32-bit floating-point", "N.X, 32-bit floating-point", "magnitude, 32-bit floating-point",
                     "texture, 32-bit floating-point", "samples, 32-bit floating-point"):
            self.assertIn(line, header)
        self.run_peer("oiiotool", "aov.exr", "--ch", "R,G,B,A", "-o", "colour.exr")
        self.run_peer("idiff", "-fail", 0, "-warn", 0, "plain.exr", "colour.exr")
        alpha, depth, samples = self.pixels("aov.exr", "A", "Z", "samples")
        seen = alpha > 0.01
        self.assertTrue(seen.any() and not seen.all())
        self.assertTrue(numpy.isinf(depth[alpha == 0]).all())
        # Depths are between those of the box's nearest and farthest corners.
        camera = self.matrix(header, "worldToCamera")
        corners = numpy.array([[x, y, z, 1] for x in (-0.05, 1.95) for y in (-0.05, 1.55) for z in (-0.05, 1.15)])
        z = (corners @ camera)[:, 2]
        self.assertGreater(depth[seen].min(), z.min())
        self.assertLess(depth[seen].max(), z.max())
        # Textures go on past the rim along straight lines: at most by half of a step between two voxels.
        for values, most in zip(self.pixels("aov.exr", "magnitude", "texture"), (1, 1.5)):
            self.assertTrue((values[seen] > 0).all() and (values[seen] < most).all())
        self.assertGreater(samples[seen].min(), 0)
        self.renders("-o", "one.exr", "--aov", "depth,samples", *base)  # the option does not swallow the input
        self.assertNotIn("texture,", self.header("one.exr"))
        self.refuses(2, *base, "-o", "a.png", "--aov", "depth")

    def test_a_voxel_is_at_the_position_by_the_header(self):
        # Rotated, per-axis scaled, mirrored; one voxel off the middle of the image.
        matrix = [[0.0, 0.5, 0.0, 0.0], [-1.5, 0.0, 0.0, 0.0], [0.0, 0.0, -0.25, 0.0], [7.0, -3.0, 11.0, 1.0]]
        lonely = vdb.FloatGrid()
        lonely.name = "density"
        lonely.transform = vdb.createLinearTransform(matrix)
        lonely.fill((-4, 6, 9), (-4, 6, 9), 0.5)
        vdb.write(str(self.folder / "voxel.vdb"), grids=[lonely])
        for stretch, *projection in ((1, 1, 1), "perspective", "--fov", 3), ((1, 1, 1), "orthographic", "--view-height", 5), \
                ((1, 0.5, 2), "perspective", "--fov", 3):
            centre = numpy.array(lonely.transform.indexToWorld((-4, 6, 9))) * stretch
            self.renders("voxel.vdb", "-o", "voxel.exr", "--size", 120, 100, "--precision", "float", "--modulate", 0,
                         "--opacity", "0:0.05", "--stretch", *stretch, "--projection", *projection,
                         "--target", *(centre + (0.5, 0.2, -0.4)), "--eye", *(centre + (40, -60, 30)))
            depth = -numpy.log1p(-self.pixels("voxel.exr", "A")[0])
            y, x = numpy.mgrid[0:100, 0:120] + 0.5
            found = numpy.array([(depth * x).sum(), (depth * y).sum()]) / depth.sum()
            ndc = numpy.append(centre, 1) @ self.matrix(self.header("voxel.exr"), "worldToNDC")
            expected = ndc[:2] / ndc[3] * (120, 100)
            numpy.testing.assert_allclose(found, expected, atol=0.3)

    def test_two_scalars(self):
        random = numpy.random.default_rng(7)
        shape = (20, 16, 12)
        grids = [grid(name, random.random(shape)) for name in ("density", "magnitude", "vorticity")]
        vdb.write(str(self.folder / "two.vdb"), grids=grids)
        base = ("two.vdb", "--size", 40, 30, "--precision", "float", "--aov", "magnitude", "--opacity", "0:0,1:0.2",
                "--eye", 4, -3, 3)
        red, alpha = {}, {}
        for name, options in {"one": [], "by": ["--by", "vorticity"], "color": ["--color-by", "vorticity"],
                              "opacity": ["--opacity-by", "vorticity"],
                              "both": ["--color-by", "vorticity", "--opacity-by", "vorticity"],
                              "vortex": ["--look", "vortex", "--shadows", 0, "--occlusion", 0], "range": ["--opacity-range", 0.5, 2]}.items():
            self.renders(*base, "-o", f"{name}.exr", *options)
            red[name], alpha[name] = self.pixels(f"{name}.exr", "R", "A")
        self.assertTrue((red["by"] == red["both"]).all())
        self.assertTrue((red["vortex"] == red["opacity"]).all())
        # Without a scalar of its own, opacity is by the one that colours.
        self.assertTrue((red["color"] == red["by"]).all())
        self.assertTrue((alpha["opacity"] == alpha["by"]).all())
        self.assertGreater(abs(red["opacity"] - red["by"]).max(), 0.02)
        self.assertGreater(abs(alpha["by"] - alpha["one"]).max(), 0.02)
        self.assertTrue((alpha["range"] <= alpha["one"] + 1e-6).all())
        self.assertLess(alpha["range"].mean(), 0.7 * alpha["one"].mean())
        header = self.header("vortex.exr")
        self.assertIn('colorBy (type string): "magnitude"', header)
        self.assertIn('opacityBy (type string): "vorticity"', header)  # there is no q
        self.renders("two.vdb", "--look", "vortex", "--histogram", "h.json")
        histogram = json.loads(self.contents("h.json"))
        self.assertEqual((histogram["color"]["grid"], histogram["opacity"]["grid"]), ("magnitude", "vorticity"))
        self.assertEqual(sum(histogram["opacity"]["counts"]) + histogram["opacity"]["above"], 20 * 16 * 12)

    def test_a_missing_scalar(self):
        good = ("lic.%04d.vdb", "-o", "a.%04d.png", "--size", 20, 20)
        message = self.refuses(3, *good, "--look", "vortex")
        self.assertIn("no float grid 'q' or 'vorticity'", message)
        self.assertIn("vdblic_advect --with q", message)
        self.assertIn("--with vorticity", self.refuses(3, *good, "--by", "vorticity"))
        message = self.refuses(3, *good, "--color-by", "smoke", "--opacity-by", "density")
        self.assertIn("--color-by", message)
        self.assertNotIn("--with", message)

    def test_a_logarithmic_scale_needs_positive_values(self):
        good = ("lic.0003.vdb", "-o", "a.png", "--size", 20, 20)
        for option in "color", "opacity":
            of = "" if option == "color" else "opacity-"
            message = self.refuses(2, *good, f"--{option}-scale", "log", f"--{of}range", 0, 1)
            self.assertIn(f"--{option}-scale", message)
            self.assertIn("0 to 1", message)
            (self.folder / "log.json").write_text(
                json.dumps({of.replace("-", "_") + "range": [-1, 1], f"{option}_scale": "log"}), encoding="utf-8")
            self.assertIn("log.json", self.refuses(3, *good, "--transfer", "log.json"))
        self.assertIn("one of linear, log", self.refuses(2, *good, "--color-scale", "square"))

    def test_options_of_numbers_do_not_swallow_the_input(self):
        for options in (["--background", 0, 0, 0], ["--clip-plane", 1, 0, 0, 1, 0, 0], ["--light", 0, 0, 1],
                        ["--clip-box", 0, 0, 0, 1, 1, 1], ["--roi-box", 0, 0, 0, 1, 1, 1], ["--range", 0, 1], ["--stretch", 1, 2, 1],
                        ["--eye", 9, 9, 9], ["--opacity", "0:1"]):
            self.renders("-o", "a.png", "--size", 20, 20, *options, "lic.0003.vdb")

    def test_region(self):
        region = vdb.BoolGrid()
        region.name = "region"
        region.fill((0, 0, 0), (9, 15, 11), True, True)
        region.transform = vdb.createLinearTransform(voxelSize=0.1)
        vdb.write(str(self.folder / "region.vdb"), grids=[region])
        view = ["--eye", 0.95, -50, 0.55, "--target", 0.95, 0, 0.55, "--fov", 3, "--size", 40, 40, "--opacity", "0:0.9",
                "--modulate", 0]
        self.renders("lic.0003.vdb", "-o", "a.exr", *view, "--roi", "region.vdb:region")
        # The same region as a box: voxels 0 to 9 along x have their centres up to 0.9.
        self.renders("lic.0003.vdb", "-o", "b.exr", *view, "--roi-box", -1, -1, -1, 0.91, 1.51, 1.11)
        self.run_peer("idiff", "-fail", 0, "a.exr", "b.exr")
        message = self.refuses(3, "lic.0003.vdb", "-o", "c.exr", *view, "--roi-box", 5, 5, 5, 6, 6, 6)
        self.assertIn("--roi-box", message)
        self.assertIn("corner", self.refuses(2, "lic.0003.vdb", "-o", "c.exr", "--roi-box", 0, 0, 0, 1, 0, 1))
        shown = subprocess.run(["oiiotool", self.folder / "a.exr", "--ch", "A", "--cut", "20x1+0+20", "--printstats"],
                               text=True, capture_output=True, check=True).stdout
        left = float(next(line for line in shown.splitlines() if "Stats Avg" in line).split()[2])
        shown = subprocess.run(["oiiotool", self.folder / "a.exr", "--ch", "A", "--cut", "20x1+20+20", "--printstats"],
                               text=True, capture_output=True, check=True).stdout
        right = float(next(line for line in shown.splitlines() if "Stats Avg" in line).split()[2])
        self.assertGreater(left, 0.2)
        self.assertEqual(right, 0)

    def test_png_is_the_exr_over_the_background(self):
        # Nothing is so bright that the tone curve would change it.
        for ending in ("exr", "png"):
            self.renders("lic.0003.vdb", "-o", f"a.{ending}", "--size", 40, 30, "--background", 0.2, 0.4, 0.6,
                         "--exposure", -1)
        self.run_peer("oiiotool", "a.exr", "--ch", "R,G,B", "--colorconvert", "linear", "sRGB", "-d", "uint8", "-o",
                      "b.png")
        self.run_peer("idiff", "-fail", 1.1 / 255, "-warn", 1.1 / 255, "a.png", "b.png")
        # The image shows the volume and the background.
        stats = self.run_peer("oiiotool", "a.png", "--printstats")
        spread = next(line for line in stats.splitlines() if "Stats StdDev" in line).split()[2:5]
        self.assertGreater(max(map(float, spread)), 5)
        first = self.run_peer("oiiotool", "--dumpdata", "a.png").splitlines()[1]
        self.assertIn("Pixel (0, 0): 51 102 153", first)

    def test_known_opacity(self):
        values = numpy.full((32, 8, 8), 0.5)
        vdb.write(str(self.folder / "slab.vdb"), grids=[grid("fog", values), grid("magnitude", values)])
        self.renders("slab.vdb", "--texture", "fog", "-o", "slab.exr", "--size", 9, 9, "--opacity", "0:0.05,1:0.05",
                     "--modulate", 0, "--range", 0, 1, "--colormap", "gray", "--step", 0.05, "--fov", 0.01,
                     "--eye", -1000, 0.35, 0.35, "--target", 1.55, 0.35, 0.35)
        self.assertAlmostEqual(self.pixels("slab.exr", "A")[0].mean(), 1 - 0.95 ** 32, delta=2e-3)

    def test_threads(self):
        images = []
        for threads in (1, 2, 7):
            names = self.renders("lic.%04d.vdb", "-o", f"t{threads}.%04d.exr", "--size", 70, 50, "--threads", threads,
                                 "--aov", "all")
            images.append([self.contents(name) for name in names])
        self.assertEqual(images[0], images[1])
        self.assertEqual(images[0], images[2])

    def test_a_farm_makes_the_same_animation(self):
        move = ("--size", 40, 30, "--orbit", 0.5)
        whole = self.renders("lic.%04d.vdb", "-o", "whole.%04d.png", *move)
        for frame in (4, 3):
            (name,) = self.renders("lic.%04d.vdb", "-o", "part.%04d.png", "--frames", frame, *move)
            self.assertEqual(self.contents(name), self.contents(whole[frame - 3]))
        self.assertNotEqual(self.contents(whole[0]), self.contents(whole[1]))

    def test_camera_key_frames(self):
        keys = {"keys": [{"frame": 3, "eye": [9, 0, 0.5]}, {"frame": 4, "eye": [0, -9, 0.5], "fov": 50}]}
        (self.folder / "keys.json").write_text(json.dumps(keys))
        self.renders("lic.%04d.vdb", "-o", "k.%04d.exr", "--size", 20, 20, "--camera", "keys.json")
        self.assertIn("eye (type v3f): (9 0 0.5)", self.header("k.0003.exr"))
        self.assertIn("eye (type v3f): (0 -9 0.5)", self.header("k.0004.exr"))
        self.assertIn('cameraKeys (type string): "keys.json"', self.header("k.0004.exr"))
        good = ("lic.%04d.vdb", "-o", "a.%04d.png", "--size", 20, 20)
        for option in ("--view", "top"), ("--angles", 30, 40), ("--eye", 9, 9, 9), ("--fov", 40):
            self.assertIn(f"keys.json: its key frames stand against --{option[0][2:]}",
                          self.refuses(2, *good, "--camera", "keys.json", *option))
        self.renders("lic.%04d.vdb", "-o", "u.%04d.exr", "--size", 20, 20, "--camera", "keys.json", "--up", 0, 1, 0)
        self.assertIn("none.json", self.refuses(3, *good, "--camera", "none.json"))
        (self.folder / "keys.json").write_text('{"keys": [{"frame": 3, "eyes": [9, 0, 1]}]}')
        self.assertIn("eyes", self.refuses(3, *good, "--camera", "keys.json"))

    def test_standard_input(self):
        self.assertEqual(
            self.renders("-", "-o", "image.%04d.png", "--size", 20, 20, stdin="lic.0004.vdb\nlic.0003.vdb\n"),
            ["image.0004.png", "image.0003.png"])
        # A second file of the same frame must not silently overwrite the first's image.
        done = self.run_tool("vdblic_render", "-", "-o", "b.%04d.png", "--size", 20, 20,
                             stdin="lic.0003.vdb\n./lic.0003.vdb\n")
        self.assertEqual(done.returncode, 3)
        self.assertEqual(done.stdout, "b.0003.png\n")
        self.assertIn("frame 3 comes twice", done.stderr)

    def test_an_image_appears_before_the_next_path_arrives(self):
        for threads in (1, 2):
            tool = subprocess.Popen([BIN / "vdblic_render", "-", "-o", f"w{threads}.%04d.png", "--size", "20", "20",
                                     "--threads", str(threads)],
                                    stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=self.folder)
            for frame in (3, 4):
                tool.stdin.write(f"lic.{frame:04}.vdb\n")
                tool.stdin.flush()
                self.assertEqual(tool.stdout.readline(), f"w{threads}.{frame:04}.png\n")
            tool.stdin.close()
            self.assertEqual(tool.wait(60), 0)
            tool.stdout.close()

    def test_skip_existing(self):
        arguments = ("lic.%04d.vdb", "-o", "s.%04d.png", "--size", 20, 20)
        names = self.renders(*arguments)
        first, second = map(self.contents, names)
        (self.folder / names[0]).write_bytes(second)  # a picture, if another one
        (self.folder / names[1]).unlink()
        self.assertEqual(self.renders(*arguments, "--skip-existing"), names)
        self.assertEqual([self.contents(name) for name in names], [second, second])
        (self.folder / names[0]).write_bytes(first)

    def test_damaged_images_are_made_again(self):
        for ending in "png", "exr":
            arguments = ("lic.%04d.vdb", "-o", f"s.%04d.{ending}", "--size", 20, 20)
            name = self.renders(*arguments)[0]
            whole = self.contents(name)
            turned = bytearray(whole)
            turned[len(whole) // 2] ^= 255
            for damaged in b"", b"finished", whole[:-len(whole) // 3], whole[:30], bytes(turned) if ending == "png" else b"":
                (self.folder / name).write_bytes(damaged)
                done = self.run_tool("vdblic_render", *arguments, "--skip-existing")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn(f"{name}: was there, but cannot be read as an image; it was made again", done.stderr)
                self.assertIn("1 of 2 images were there already", done.stderr)
                self.assertEqual(self.contents(name), whole)

    def test_histogram(self):
        self.assertEqual(self.renders("lic.%04d.vdb", "--histogram", "h.json"), ["h.json"])
        histogram = json.loads(self.contents("h.json"))
        self.assertEqual(histogram["voxels"], 2 * 20 * 16 * 12)
        values = numpy.concatenate([self.values(f"lic.{k:04}.vdb", "magnitude") for k in (3, 4)])
        magnitude = histogram["color"]
        counts = numpy.histogram(values, 256, (magnitude["low"], magnitude["high"]))[0]
        self.assertLess(numpy.abs(counts - magnitude["counts"]).sum(), 8)  # tolerance for values on the bins' edges
        self.assertEqual(self.renders("lic.0003.vdb", "-o", "a.png", "--size", 20, 20, "--histogram", "h.png"),
                         ["a.png", "h.png"])
        self.assertIn("1240 x  460, 3 channel, uint8 png", self.run_peer("oiiotool", "--info", "h.png"))
        self.refuses(2, "lic.0003.vdb", "--histogram", "h.svg")

    def values(self, path, name):
        read = vdb.read(str(self.folder / path), name)
        array = numpy.zeros((20, 16, 12), numpy.float32)
        read.copyToArray(array)
        return array.ravel()

    def test_usage(self):
        good = ["lic.0003.vdb", "-o", "a.png"]
        for bad in (["--size", 0, 10], ["--size", 10], ["--fov", "nan"], ["--fov", "inf"], ["--step", 0], ["--step", "x"],
                    ["--range", 2, 1], ["--range", "nan", 1], ["--opacity", "0:2"], ["--opacity", "half"],
                    ["--colormap", "rainbow"], ["--modulate", 2], ["--eye", 1, 2], ["--up", 0, 0, 0],
                    ["--background", 0, 0, 7], ["--background-alpha", 2], ["--look", "sepia"], ["--halo", -1],
                    ["--shading", "toon"], ["--depth-cue", 2], ["--clip-plane", 0, 0, 0, 0, 0, 0], ["--light", 0, 0, 0],
                    ["--clip-box", 1, 1, 1, 0, 0, 0], ["--clip-plane", 0, 0, 1], ["--threads", 0], ["--frames", "1-3"], ["--unknown"],
                    ["--projection", "fisheye"], ["--view-height", 2], ["--orbit", "nan"], ["--orbit", 1],
                    ["--orbit-frames", 10], ["--samples", 0],
                    ["--stretch", 1, 1, 0], ["--stretch", 1, 1, "nan"], ["--stretch", 1, 1], ["--stretch", "", "", ""],
                    ["--orbit", ""], ["--view-height", ""], ["--modulate", ""], ["--eye", "", "", ""], ["--orbit", 1, "--orbit-frames", 0], ["--eye", 1e308, 0, 0],
                    ["--precision", "double"], ["--aov", "albedo"], ["--aov", ""],
                    ["--projection", "orthographic", "--view-height", 0], ["--orbit", 1e308, "--orbit-frames", 2]):
            with self.subTest(bad=bad):
                self.refuses(2, *good, *bad)
        self.refuses(2, "lic.0003.vdb")
        self.refuses(2, "lic.0003.vdb", "-o", "a.jpg")
        self.refuses(2, "lic.%04d.vdb", "-o", "a.png")
        self.refuses(2, "-", "-o", "a.%04d.png", "--orbit", 1)

    @unittest.skipIf(os.environ.get("VDBLIC_SANITIZED") == "1", "sanitizers hold more memory than there is")
    def test_a_picture_larger_than_memory(self):
        good = ("lic.0003.vdb", "-o", "a.png")
        for size in (["--size", 200000, 200000], ["--size", 1, 10**9]):
            self.assertIn("pixels a side", self.refuses(2, *good, *size))
        self.assertIn("with --size", self.refuses(3, *good, "--size", 8000, 8000, "--max-memory", "500M"))
        self.renders(*good, "--size", 80, 80, "--max-memory", "500M")

    def test_two_outputs_of_one_name(self):
        message = self.refuses(2, "lic.%04d.vdb", "-o", "a.%04d.png", "--histogram", "./a.0004.png")
        self.assertIn("./a.0004.png", message)

    def test_bad_input(self):
        self.assertIn("nothing.vdb", self.refuses(3, "nothing.vdb", "-o", "a.png"))
        self.assertIn("density", self.refuses(3, "lic.0003.vdb", "-o", "a.png", "--texture", "smoke"))
        (self.folder / "broken.vdb").write_bytes(self.contents("lic.0003.vdb")[:300])
        self.refuses(3, "broken.vdb", "-o", "a.png")
        self.refuses(3, "-", "-o", "a.png", stdin="")

    def test_output_cannot_be_written(self):
        self.refuses(4, "lic.0003.vdb", "-o", "missing/a.png")
        # The file size limit acts like a full disk.
        limit = {"restore_signals": False, "preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))}
        for ending in ("exr", "png"):
            self.refuses(4, "lic.0003.vdb", "-o", f"a.{ending}", **limit)
        # What ffmpeg says then is "Error initializing output stream".
        self.assertIn("a.mp4: ffmpeg cannot write the film: File too large",
                      self.refuses(4, "lic.%04d.vdb", "--film", "a.mp4", "--size", 64, 64, **limit))


if __name__ == "__main__":
    unittest.main()
