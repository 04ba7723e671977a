"""What each option of a look does to a picture: known values of pixels.

The volumes are seen along x by parallel rays, a pixel a voxel. Where y is 8 or more, in the picture's left half, the
driver is three quarters of its range, elsewhere a quarter.
"""

import json
import unittest

import numpy
import pyopenvdb as vdb

from support import RenderTest

SHAPE = 20, 16, 12
X, Y, Z = numpy.meshgrid(*map(numpy.arange, SHAPE), indexing="ij")
DRIVER = numpy.where(Y < 8, 0.25, 0.75)
TEXTURES = {"ramp": X / 19, "bars": 0.5 + 0.5 * numpy.sin(1.5 * Z),
            "rods": 0.5 + 0.25 * (numpy.sin(0.9 * X) + numpy.sin(0.9 * Y))}
VIEW = ("--eye", -50, 0.75, 0.55, "--target", 0, 0.75, 0.55, "--projection", "orthographic", "--view-height", 1.2,
        "--size", 16, 12, "--samples", 1, "--precision", "float")
# The driver's grey, opacity 0.2 a voxel, and nothing else.
PLAIN = {"--range": (0, 1), "--colormap": "gray", "--opacity": "0:0.2", "--modulate": 0, "--limb-darkening": 0,
         "--shading": "none", "--halo": 0, "--depth-cue": 0, "--exposure": 0, "--step": 0.5}
OPAQUE = 1 - 0.8 ** SHAPE[0]
GREY = numpy.where(numpy.arange(16) < 8, 0.75, 0.25)
GREY = ((GREY + 0.055) / 1.055) ** 2.4  # linear, by the picture's column


class RenderLook(RenderTest):
    def setUp(self):
        super().setUp()
        for name, texture in TEXTURES.items():
            self.write(name, density=texture, magnitude=DRIVER)

    def write(self, name, **grids):
        made = []
        for grid, values in grids.items():
            made.append(vdb.FloatGrid())
            made[-1].name = grid
            made[-1].copyFromArray(values.astype(numpy.float32), tolerance=-1)
            made[-1].transform = vdb.createLinearTransform(voxelSize=0.1)
        vdb.write(str(self.folder / f"{name}.vdb"), grids=made)

    def seen(self, name, *more, **options):
        """Red and alpha of a volume's picture; options by their names with _ for -, those of PLAIN unless given."""
        given = PLAIN | {f"--{key.replace('_', '-')}": value for key, value in options.items()}
        words = []
        for option, value in given.items():
            words += [option, *(value if isinstance(value, tuple) else (value,))]
        self.renders(f"{name}.vdb", "-o", "seen.exr", *VIEW, *words, *more)
        return self.pixels("seen.exr", "R", "A")

    def assert_near(self, found, expected, tolerance=2e-3):
        numpy.testing.assert_allclose(found, numpy.broadcast_to(expected, found.shape), atol=tolerance)

    def same_pictures(self, first, second):
        """Two lists of arguments make the same .png."""
        for name, words in ("a.png", first), ("b.png", second):
            self.renders(*words, "-o", name, *VIEW)
        self.assertEqual(self.contents("a.png"), self.contents("b.png"))

    def test_a_picture_without_light_has_the_colours_of_the_transfer_function(self):
        red, alpha = self.seen("ramp")
        self.assert_near(alpha, OPAQUE)
        self.assert_near(red, GREY * OPAQUE)

    def test_modulate_makes_dark_texture_transparent(self):
        _, alpha = self.seen("bars", modulate=1)
        rows = alpha.mean(1)[::-1]  # from below, as z
        stretched = numpy.interp(TEXTURES["bars"][0, 0], *zip((0.01, 0), (0.99, 1)))
        self.assert_near(rows[stretched == 0], 0)
        self.assert_near(rows[stretched > 0.98], OPAQUE, 0.01)
        order = rows[numpy.argsort(stretched)]
        self.assertTrue((numpy.diff(order) > -1e-3).all(), order)
        _, half = self.seen("bars", modulate=0.5)
        self.assert_near(half.mean(1)[::-1][stretched == 0], 1 - 0.9 ** SHAPE[0], 5e-3)

    def test_limb_darkening_darkens_where_the_texture_is_dark(self):
        full, alpha = self.seen("bars", limb_darkening=1)
        half, _ = self.seen("bars", limb_darkening=0.5)
        self.assert_near(alpha, OPAQUE)
        share = (full / (GREY * OPAQUE)).mean(1)[::-1]
        order = share[numpy.argsort(TEXTURES["bars"][0, 0])]
        self.assertTrue((numpy.diff(order) > -1e-3).all(), order)
        self.assertLess(order[0], 0.35)
        self.assertAlmostEqual(order[-1], 1, delta=5e-3)
        self.assert_near(half, (full + GREY * OPAQUE) / 2)

    def test_lights_of_surfaces(self):
        # A ramp's normals face the eye. How far they are a surface follows from a picture with ambient light alone.
        smoke = dict(shading="phong", look="smoke")  # ambient 0.25, diffuse 0.55, no highlights
        behind = "--light", 1, 0, 0
        plain, _ = self.seen("ramp")
        dark, _ = self.seen("ramp", *behind, head_light=0, **smoke)
        surface = (1 - (dark / plain).mean()) / 0.75
        self.assertAlmostEqual(surface, 0.47, delta=0.02)  # 1/19 a voxel, of the texture's range; against 0.08
        for lit, head_light, *lights in (
                (0.8, 1, *behind),
                (0.525, 0.5, *behind),
                (0.8, 0, "--light", -1, 0, 0),
                (0.8 + 0.55 * 0.5 ** 0.5, 0, "--light", -1, 0, 0, "--light", -2, 0, 2)):
            red, alpha = self.seen("ramp", *lights, head_light=head_light, **smoke)
            self.assert_near(red / plain, 1 + surface * (lit - 1), 5e-3)
            self.assert_near(alpha, OPAQUE)

    def test_highlights(self):
        # The normals halve the angle between eye and light at the eye: white light is added at its full strength.
        red, _ = self.seen("ramp", shading="phong", look="flow")  # ambient 0.55, diffuse 0.9, specular 0.2
        surface = 0.47
        self.assert_near(red - GREY * OPAQUE * (1 + surface * 0.45), 0.2 * surface * OPAQUE, 5e-3)
        # Away from the mirror's direction there is less.
        values = [self.seen("ramp", "--light", -1, 0, aside, shading="phong", look="flow", head_light=0)[0].mean()
                  for aside in (0, 0.5, 1)]
        self.assertEqual(values, sorted(values, reverse=True))

    def test_lights_of_lines(self):
        # Rods along z: light along them is not reflected, light across them is.
        plain, _ = self.seen("rods")

        def reflected(head_light, *light):
            red, _ = self.seen("rods", "--light", *light, shading="lines", look="smoke", head_light=head_light)
            return (red / plain - 0.25) / 0.55  # its ambient and diffuse light

        self.assert_near(reflected(1, 0, 0, 1), 1)
        self.assert_near(reflected(0, 0, 0, 1), 0)
        across, slant = reflected(0, 0, 1, 0), reflected(0, 0, 1, 1)
        self.assertGreater(across.min(), 0.85)
        self.assert_near(slant / across, 0.25)  # the fourth power of the sine

    def test_depth_cue_fades_linearly_into_the_background(self):
        extinction = -numpy.log(0.8) * SHAPE[0]
        near = 1 - OPAQUE / extinction  # the mean of what is left of the colour
        for background in 0, 1:
            red, _ = self.seen("ramp", depth_cue=1, background=(background,) * 3)
            self.assert_near(red, GREY * near + background * (1 - near))
        half, _ = self.seen("ramp", depth_cue=0.5, background=(0, 0, 0))
        self.assert_near(half, GREY * (near + OPAQUE) / 2)

    def test_halos_and_distance_fade_to_what_is_behind_them(self):
        # The background's red rises from the bottom, 0, to the top, 1, as displayed; what has faded has its colours.
        options = dict(background=(0, 0, 0), background_top=(1, 1, 1), exposure=0.5)
        rows = (12 - numpy.arange(12) - 0.5)[:, None] / 12
        rows = numpy.where(rows <= 0.04045, rows / 12.92, ((rows + 0.055) / 1.055) ** 2.4)
        _, alpha = self.seen("ramp", "--clip-box", 50, 50, 50, 60, 60, 60, **options)
        red, _ = self.seen("ramp", "--clip-box", 50, 50, 50, 60, 60, 60, **options)
        self.assert_near(red, numpy.broadcast_to(rows, red.shape))
        self.assert_near(alpha, 1)
        # A picture is linear in what is behind it.
        dark, _ = self.seen("bars", modulate=1, halo=1, depth_cue=0.8, background=(0, 0, 0), exposure=0.5)
        light, _ = self.seen("bars", modulate=1, halo=1, depth_cue=0.8, background=(1, 1, 1), exposure=0.5)
        both, _ = self.seen("bars", modulate=1, halo=1, depth_cue=0.8, **options)
        self.assertGreater((light - dark).min(), 0.05)
        self.assert_near(both, dark + (light - dark) * rows)

    def test_halos_hide_what_is_behind_flanks(self):
        # Of the background's colour, here black; a picture without colour tells what they hide.
        pictures = [self.seen("bars", modulate=1, opacity="0:0.02", halo=halo, background=(0, 0, 0), background_alpha=0)
                    for halo in (0, 1, 4)]
        rows = [(red.mean(1), alpha.mean(1)) for red, alpha in pictures]
        for (red, alpha), (less, more) in zip(rows, rows[1:]):
            self.assertTrue((less <= red + 1e-6).all() and (more >= alpha - 1e-6).all())
        (red, alpha), (less, more) = rows[0], rows[2]
        crest, flank, dark = alpha > 0.33, (alpha > 0.01) & (alpha < 0.2), alpha == 0
        self.assertEqual((crest.sum(), flank.sum()), (2, 2))
        self.assert_near(less[crest], red[crest])
        self.assertTrue((less[flank] < 0.7 * red[flank]).all() and (more[flank] > 0.6).all())
        self.assertEqual((less[dark].max()), 0)

    def test_exposure_multiplies_light_but_not_the_background(self):
        for exposure in 1, -2:
            for halo, cue, background in (0, 0, 0.0), (0, 1, 0.6), (1, 0.5, 1.0):
                options = dict(modulate=1, halo=halo, depth_cue=cue, background=(background,) * 3, background_alpha=1)
                plain, _ = self.seen("bars", **options)
                more, _ = self.seen("bars", **options, exposure=exposure)
                # Of light alone, without a background, the factor is known.
                light, alpha = self.seen("bars", **(options | {"background": (0, 0, 0)}))
                self.assert_near(more - plain, light * (2 ** exposure - 1), 5e-3)
                self.assert_near(alpha, 1)

    def test_the_automatic_exposure_makes_up_for_light_and_not_for_data(self):
        def chosen(*options):
            self.renders("rods.vdb", "-o", "a.exr", *VIEW, *options)
            return float(self.run_peer("exrheader", "a.exr").split("exposure (type float): ")[1].split()[0])

        plain = ("--limb-darkening", 0, "--shading", "none")
        self.assertEqual(chosen(*plain), 0)
        self.assertAlmostEqual(chosen(*plain, "--shadows", 1), -numpy.log2(0.35), delta=0.06)
        # Ambient 0.25, diffuse 0.55 of one light of 0.8, on seven tenths.
        self.assertAlmostEqual(chosen("--look", "smoke", "--limb-darkening", 0, "--modulate", 1, "--head-light", 0),
                               -numpy.log2(1 + 0.7 * (0.25 + 0.55 * 0.5 * 0.8 - 1)), delta=0.06)
        self.assertEqual(chosen("--exposure", -0.75), -0.75)
        # Cameras, backgrounds and colours have no part in it.
        usual = chosen()
        self.assertGreater(usual, 0)
        self.assertEqual(chosen("--background", 1, 1, 1, "--colormap", "gray", "--orbit", 0.5, "--orbit-frames", 4), usual)

    def test_cuts(self):
        # The plane cuts at a voxel's middle, in the middle between two pixels; of the rays along x 10.5 voxels are left.
        _, alpha = self.seen("ramp", "--clip-plane", 0, 0.75, 0, 0, 1, 0)
        self.assert_near(alpha[:, :8], OPAQUE)
        self.assert_near(alpha[:, 8:], 0)
        _, alpha = self.seen("ramp", "--clip-plane", 0, 0.75, 0, 0, 1, 0, "--clip-plane", 1, 0, 0, -1, 0, 0)
        self.assert_near(alpha[:, :8], 1 - 0.8 ** 10.5)
        self.assert_near(alpha[:, 8:], 0)
        _, alpha = self.seen("ramp", clip_box=(0.25, 0.35, 0.25, 0.75, 0.95, 0.85))
        expected = numpy.zeros((12, 16))
        expected[3:9, 6:12] = 1 - 0.8 ** 5
        self.assert_near(alpha, expected)

    def test_a_transfer_file_is_its_options(self):
        (self.folder / "function.json").write_text(
            json.dumps({"range": [0.1, 0.9], "colormap": "viridis", "opacity": [[0, 0.1], [1, 0.3]]}), encoding="utf-8")
        self.same_pictures(["ramp.vdb", "--transfer", "function.json"],
                           ["ramp.vdb", "--range", 0.1, 0.9, "--colormap", "viridis", "--opacity", "0:0.1,1:0.3"])

    def test_details_tell_who_chose_what(self):
        (self.folder / "function.json").write_text(json.dumps({"opacity": [[0, 0.1], [1, 0.3]]}), encoding="utf-8")
        told = self.run_tool("vdblic_render", "rods.vdb", "-o", "a.png", *VIEW[:-2], "-v", "--look", "smoke", "--halo", 0.5,
                             "--transfer", "function.json").stderr
        for line in ("--look smoke (given)", "--halo 0.5 (given)", "--size 16 12 (given)", "--modulate 0.97 (by the look smoke)",
                     "--opacity 0:0.1,1:0.3 (by function.json)"):
            self.assertIn(f"plan: {line}\n", told)

    def test_by_names_the_driver(self):
        self.write("by", density=TEXTURES["rods"], magnitude=1 - DRIVER, q=DRIVER)
        self.same_pictures(["by.vdb", "--by", "q"], ["rods.vdb"])
        self.same_pictures(["by.vdb", "--by", "density"], ["by.vdb", "--color-by", "density", "--opacity-by", "density"])

    def test_looks_are_their_options(self):
        for look, *options in (
                ("flow", "--halo", 0.3, "--depth-cue", 0.25, "--colormap", "ember"),
                ("xray", "--colormap", "ice", "--shading", "none", "--limb-darkening", 0.5, "--halo", 0, "--depth-cue", 0)):
            self.same_pictures(["rods.vdb", "--opacity", "0:0.1", "--look", look], ["rods.vdb", "--opacity", "0:0.1", *options])
        # Smoke is as good as grey, and lit from one side.
        self.renders("rods.vdb", "-o", "smoke.exr", *VIEW, "--look", "smoke")
        red, blue = self.pixels("smoke.exr", "R", "B")
        self.assertGreater(red.max(), 0.05)
        self.assertTrue((abs(red - blue) < 0.15 * red.max()).all())


if __name__ == "__main__":
    unittest.main()
