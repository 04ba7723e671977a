"""Streaks on a globe are as dense everywhere: at the poles, at the date line and in all directions of the voxels."""

import itertools
import unittest

import numpy

import python_module  # finds vdblic
from support import ToolTest

import vdblic

VOXEL, LAYERS = 0.15, 5  # of the flow `rossby`


class Density(ToolTest):
    def setUp(self):
        super().setUp()
        self.outputs("vdblic_synth", "rossby", "-o", "v.%04d.vdb", "--frames", "1-4", "--voxel-size", VOXEL)
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "l.%04d.vdb", "--method", "streaks", "--draw", "lines",
                     "--spacing", 1, "--tail", 1, "--emit", "v.0001.vdb:rim")

    def directions(self, frame):
        """Of the heads of streaks within the shell."""
        lines = vdblic.read(self.folder / f"l.{frame:04}.vdb").lines
        heads = lines.points[numpy.cumsum(lines.counts) - 1].astype(float)
        radius = numpy.linalg.norm(heads, axis=1)
        inside = (radius > 6.371 + VOXEL / 2) & (radius < 6.371 + (LAYERS - 0.5) * VOXEL)
        return heads[inside] / radius[inside, None]

    def test_density(self):
        signs = numpy.array(list(itertools.product((-1, 0, 1), repeat=3)))
        for frame in 1, 4:
            heads = self.directions(frame)
            self.assertGreater(len(heads), 50_000)
            longitude = numpy.degrees(numpy.arctan2(heads[:, 1], heads[:, 0]))
            parts = {
                "date line": (abs(longitude) > 160, 40 / 360),
                "north": (heads[:, 2] > 0.9, 0.05),
                "south": (heads[:, 2] < -0.9, 0.05),
                "equator": (abs(heads[:, 2]) < 0.2, 0.2),
            }
            for axes, name in (1, "faces of voxels"), (2, "edges of voxels"), (3, "corners of voxels"):
                towards = signs[abs(signs).sum(axis=1) == axes] / axes**0.5
                near = numpy.cos(numpy.radians(18))  # no two of these caps meet
                parts[name] = (heads @ towards.T > near).any(axis=1), len(towards) * (1 - near) / 2
            for name, (chosen, area) in parts.items():
                with self.subTest(frame=frame, part=name):
                    chance = 3 / chosen.sum() ** 0.5
                    self.assertAlmostEqual(chosen.sum() / len(heads) / area, 1, delta=0.03 + chance)


if __name__ == "__main__":
    unittest.main()
