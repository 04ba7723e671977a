"""vdblic_render on the command line: the Earth below a flow, seen from above a place."""

import unittest

import numpy

from support import RenderTest

SAHARA, PACIFIC, FAR_FROM_SAHARA = (22.5, 22.5), (-157.5, 7.5), (-157.5, -22.5)  # between the lines of the graticule
SIDE = 96


class Earth(RenderTest):
    def setUp(self):
        super().setUp()
        self.outputs("vdblic_synth", "rossby", "-o", "v.%04d.vdb", "--frames", 1, "--voxel-size", 0.4)
        self.outputs("vdblic_advect", "v.0001.vdb", "-o", "lic.vdb", "--method", "lic")

    def seen(self, *options, name="a.png"):
        """The file of a picture of the Earth alone."""
        self.renders("lic.vdb", "-o", name, "--size", SIDE, SIDE, "--samples", 1, "--opacity", "0:0,1:0", "--exposure", 0,
                     "--solid", "v.0001.vdb:solid", "--target", 0, 0, 0, *options)
        return self.contents(name)

    def middle(self, *options, half=2):
        """The mean colour of the pixels in the middle."""
        self.seen(*options, name="a.exr")
        part = slice(SIDE // 2 - half, SIDE // 2 + half)
        return numpy.array([channel[part, part].mean() for channel in self.pixels("a.exr", "R", "G", "B")])

    def test_view_from(self):
        self.assertEqual(self.seen("--earth", "--view-from", 13, 52), self.seen("--earth", "--angles", 52, 103))
        for options in ("--angles", 1, 2), ("--view", "top"), ("--eye", 9, 9, 9):
            self.assertIn("--view-from", self.refuses(2, "lic.vdb", "-o", "a.png", "--view-from", 13, 52, *options))

    def test_continents(self):
        land = self.middle("--earth", "--view-from", *SAHARA)
        self.assertTrue((abs(self.middle("--view-from", *SAHARA) - land) < 0.02 * land).all())
        self.assertTrue((self.middle("--earth", "--view-from", *PACIFIC) < 0.6 * self.middle("--view-from", *PACIFIC)).all())

    def test_earth_without_a_solid(self):
        self.assertIn("--earth is drawn on a --solid", self.refuses(2, "lic.vdb", "-o", "a.png", "--earth"))

    def test_place(self):
        """A dot in the middle, a name beside it; nothing on the far side."""
        plain = self.seen("--earth", "--view-from", *SAHARA)
        named = "--annotate", "place={} {} Sahara".format(*SAHARA)
        self.assertNotEqual(self.seen("--earth", "--view-from", *SAHARA, *named), plain)
        far = self.seen("--earth", "--view-from", *FAR_FROM_SAHARA)
        self.assertEqual(self.seen("--earth", "--view-from", *FAR_FROM_SAHARA, *named), far)
        for bad in "place=", "place=20 Sahara", "place=20 22", "place=20 99 Sahara", "place=nan 0 Sahara":
            self.assertIn("place=", self.refuses(2, "lic.vdb", "-o", "a.png", "--annotate", bad))


if __name__ == "__main__":
    unittest.main()
