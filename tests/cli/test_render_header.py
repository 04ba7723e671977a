"""The header of an image holds all parameters: each option in vdblic_render's --help changes the header.

A new option fails this test until it has a value here and an attribute in the header.
"""

import functools
import json
import re
import subprocess
import unittest

import pyopenvdb as vdb

from support import ToolTest

# Options of input, output and execution, which do not affect the picture.
NOT_OF_THE_PICTURE = {"--help", "--version", "--threads", "--max-memory", "--scratch", "--quiet", "--verbose",
                      "--verify", "--frames", "--clamp-frames", "--substeps", "--renumber", "--skip-existing", "--keep-going",
                      "--output", "--histogram", "--transfer-out", "--film", "--fps", "--parameters"}
ORTHOGRAPHIC = ["--projection", "orthographic"]
# For each option: the options that it needs, and a value other than its default.
VALUES = {
    "--texture": ([], "magnitude"),
    "--lines": ([], "lines.%04d.vdb"),
    "--size": ([], 30, 20),
    "--stretch": ([], 1, 1, 2),
    "--samples": ([], 2),
    "--view": ([], "top"),
    "--angles": ([], 30, 60),
    "--view-from": ([], 20, 30),
    "--eye": ([], 9, 9, 9),
    "--target": ([], 0, 0, 0),
    "--up": ([], 0, 1, 0),
    "--projection": ([], "orthographic"),
    "--fov": ([], 50),
    "--view-height": (ORTHOGRAPHIC, 5),
    "--aperture": ([], 0.1),
    "--orbit": ([], 1),
    "--orbit-frames": (["--orbit", 0.25], 10),
    "--camera": ([], "keys.json"),
    "--step": ([], 0.25),
    "--interpolation": ([], "cubic"),
    "--look": ([], "smoke"),
    "--transfer": ([], "function.json"),
    "--colormap": ([], "viridis"),
    "--colors": ([], "0:#102030"),
    "--opacity": ([], "0:0.5"),
    "--range": ([], 0, 1),
    "--color-scale": ([], "log"),
    "--opacity-scale": ([], "log"),
    "--modulate": ([], 0.5),
    "--limb-darkening": ([], 0.5),
    "--shading": ([], "none"),
    "--head-light": ([], 0.1),
    "--light": ([], 1, 2, 3),
    "--halo": ([], 1),
    "--depth-cue": ([], 0.5),
    "--exposure": ([], 2.5),
    "--clip-plane": ([], 0.5, 0, 0, 1, 0, 0),
    "--clip-box": ([], 0, 0, 0, 0.5, 0.5, 0.5),
    "--background": ([], 1, 1, 1),
    "--background-top": ([], 1, 1, 1),
    "--background-alpha": ([], 0.5),
    "--by": ([], "density"),
    "--color-by": ([], "density"),
    "--opacity-by": ([], "density"),
    "--opacity-range": ([], 0, 2),
    "--solid": ([], "domain"),
    "--solid-color": (["--solid", "domain"], 1, 0, 0),
    "--earth": (["--solid", "domain"],),
    "--ground": ([], "below"),
    "--shadows": ([], 0.5),
    "--occlusion": ([], 0.5),
    "--annotate": ([], "box"),
    "--roi": ([], "lic.0001.vdb:magnitude"),
    "--roi-box": ([], 0, 0, 0, 0.5, 0.5, 0.5),
    "--aov": ([], "depth"),
    "--precision": ([], "float"),
}


class Header(ToolTest):
    def setUp(self):
        super().setUp()
        grids = []
        for name in "density", "magnitude":
            grid = vdb.FloatGrid()
            grid.name = name
            grid.transform = vdb.createLinearTransform(voxelSize=0.1)
            for i in range(12):
                grid.fill((i, 0, 0), (i, 9, 9), i / 12, True)
            grids.append(grid)
        vdb.write(str(self.folder / "lic.0001.vdb"), grids=grids)
        flow = vdb.Vec3SGrid()
        flow.name = "velocity"
        flow.fill((0, 0, 0), (9, 9, 9), (1, 0, 0), True)
        vdb.write(str(self.folder / "v.0001.vdb"), grids=[flow])
        self.outputs("vdblic_advect", "v.0001.vdb", "--dt", 1, "--method", "streaks", "--draw", "lines", "--spacing", 3, "-o",
                     "lines.%04d.vdb")
        (self.folder / "keys.json").write_text(json.dumps({"keys": [{"frame": 1, "eye": [9, 0, 9]}]}))
        (self.folder / "function.json").write_text('{"colors": [[0, 1, 0, 0], [1, 0, 0, 1]]}')

    def header(self, *options):
        (image,) = self.outputs("vdblic_render", "lic.%04d.vdb", "-o", "a.%04d.exr", *options)
        return subprocess.run(["exrheader", image], text=True, capture_output=True, check=True).stdout

    def test_every_option_of_the_picture_is_in_the_header(self):
        names = re.findall(r"^  (-[\w,-]+)", self.run_tool("vdblic_render", "--help").stdout, re.MULTILINE)
        options = {max(name.split(","), key=len) for name in names} - NOT_OF_THE_PICTURE
        self.assertEqual(options, set(VALUES))
        small = ["--size", 12, 10]
        plain = functools.cache(self.header)
        for option, (needs, *values) in VALUES.items():
            others = needs if option == "--size" else [*small, *needs]
            with self.subTest(option=option):
                self.assertNotEqual(self.header(*others, option, *values), plain(*others))

    def test_what_it_says(self):
        header = self.header("--size", 12, 10, "--clip-plane", 0.5, 0, 0, 1, 0, 0, "--clip-plane", 0, 1, 0, 0, -1, 0,
                             "--clip-box", 0, 0, 0, 1, 2, 0.5, "--light", 1, 2, 3, "--transfer", "function.json",
                             "--stretch", 1, 1, 2, "--roi", "lic.0001.vdb:magnitude")
        for line in ('clipPlanes (type string): "0.5 0 0 1 0 0, 0 1 0 0 -1 0"', 'clipBox (type string): "0 0 0 1 2 0.5"',
                     'lights (type string): "1 2 3 1"', 'colors (type string): "0:#ff0000,1:#0000ff"',
                     "stretch (type v3f): (1 1 2)", 'region (type string): "lic.0001.vdb:magnitude"',
                     'shading (type string): "phong"', "frame (type int): 1"):
            self.assertIn(line, header)

    def test_wide_voxels_are_interpolated_by_cubics(self):
        # Of 12 voxels each covers a pixel or two, then many; whatever else is asked for.
        self.assertIn('interpolation (type string): "linear"', self.header("--size", 16, 16))
        self.assertIn('interpolation (type string): "cubic"', self.header("--size", 160, 160))
        self.assertIn('interpolation (type string): "linear"',
                      self.header("--size", 160, 160, "--interpolation", "linear"))


if __name__ == "__main__":
    unittest.main()
