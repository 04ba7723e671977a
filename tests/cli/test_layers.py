"""A steady flow in a single layer of voxels, and one frame: from the advice of vdblic_info to the picture."""

import json
import re
import subprocess
import unittest

import numpy
import pyopenvdb as vdb

from support import RenderTest


class Layers(RenderTest):
    def write(self, across):
        """A uniform flow in a layer of 24 x 24 voxels, along the first of its two axes."""
        self.along, self.beside = (axis for axis in range(3) if axis != across)
        size = [24, 24, 24]
        size[across] = 1
        values = numpy.zeros((*size, 3), numpy.float32)
        values[..., self.along] = 1e-3
        grid = vdb.Vec3SGrid()
        grid.name = "velocity"
        grid.copyFromArray(values, tolerance=(-1, -1, -1))
        grid.transform = vdb.createLinearTransform(0.01)
        vdb.write(str(self.folder / "v.vdb"), grids=[grid])

    def advice(self):
        done = self.run_tool("vdblic_info", "v.vdb", "--values", "--json", "-")
        self.assertEqual(done.returncode, 0, done.stderr)
        return " ".join(json.loads(done.stdout)["sequences"][0]["advice"])

    def test_advice_texture_and_picture(self):
        for across in range(3):
            self.write(across)
            advice = self.advice()
            self.assertNotIn("stretch", advice)
            refine = re.search("--refine ([0-9 ]+) gives", advice)[1].split()
            self.assertEqual([factor == "1" for factor in refine], [axis == across for axis in range(3)])
            voxels = re.search("--voxels-per-frame ([^ ]+) for quick motion", advice)[1]
            done = self.run_tool("vdblic_advect", "v.vdb", "-o", "lic.vdb", "--voxels-per-frame", voxels, "--refine", *refine)
            self.assertEqual((done.returncode, "warning" in done.stderr), (0, False), done.stderr)

            density = vdb.read(str(self.folder / "lic.vdb"), "density")
            low, high = density.evalActiveVoxelBoundingBox()
            self.assertEqual(high[across], low[across])
            size = numpy.array(high) - low + 1
            texture = numpy.zeros(size, numpy.float32)
            density.copyToArray(texture, ijk=low)
            steps = [numpy.abs(numpy.diff(texture, axis=axis)).mean() for axis in (self.along, self.beside)]
            self.assertLess(steps[0], 0.5 * steps[1])  # streaks

            picture, = self.renders("lic.vdb", "-o", "i.exr", "--size", 120, 120)
            alpha = self.alpha(picture)
            seen = numpy.argwhere(alpha > 0.02)
            extent = (seen.max(axis=0) - seen.min(axis=0) + 1) / 120
            self.assertGreater(extent.max(), 0.85)  # fills the picture
            self.assertGreater(extent.min(), 0.3)  # is not seen from its edge
            self.assertGreater(alpha[alpha > 0.02].mean(), 0.3)
            self.assertNotIn("warning", self.run_tool("vdblic_render", "lic.vdb", "-o", "a.png", "--annotate",
                                                      "box,axes,colorbar,time").stderr)

    def alpha(self, name):
        """The alpha channel of a picture, by OpenImageIO."""
        def oiiotool(*arguments):
            return subprocess.run(["oiiotool", *arguments], cwd=self.folder, text=True, capture_output=True,
                                  check=True).stdout

        oiiotool(name, "--ch", "A", "-d", "float", "-o", "channel.exr")
        text = oiiotool("--dumpdata", "channel.exr")
        found = re.findall(r"Pixel \((\d+), (\d+)\): (\S+)", text)
        return numpy.array([float(value) for _, _, value in found]).reshape(int(found[-1][1]) + 1, -1)


if __name__ == "__main__":
    unittest.main()
