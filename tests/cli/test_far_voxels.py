"""Volumes whose voxels are as far apart as indices can be: every tool refuses them, or tells their true size."""

import sys
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, ToolTest

MODULE = BIN.parent / "python"
LAST = 2**31 - 1
SMALL = ("--size", 24, 16)


class FarVoxels(ToolTest):
    def setUp(self):
        super().setUp()
        for name, kind, value in ("flow", vdb.Vec3SGrid, (1, 2, 3)), ("fog", vdb.FloatGrid, 1):
            self.write(name, kind(), lambda grid, value=value: grid.fill((0, 0, 0), (20, 20, 20), value))
            for far, corners in ("all", (-LAST - 1, LAST)), ("half", (0, LAST)), ("edge", (LAST,)):
                self.write(f"{name}_{far}", kind(), lambda grid, value=value, corners=corners: [
                    grid.getAccessor().setValueOn((corner,) * 3, value) for corner in corners])

    def write(self, name, grid, fill):
        grid.name = "velocity" if name.startswith("flow") else "density"
        grid["dt"] = 1.0
        fill(grid)
        vdb.write(str(self.folder / f"{name}.vdb"), grids=[grid])

    def test_every_tool(self):
        for far in "all", "half", "edge":
            flow, fog = f"flow_{far}.vdb", f"fog_{far}.vdb"
            for command in (
                    ("vdblic_advect", flow, "-o", "out.vdb"),
                    ("vdblic_advect", flow, "-o", "out.vdb", "--method", "streaks"),
                    ("vdblic_advect", "flow.vdb", "-o", "out.vdb", "--mask", fog),
                    ("vdblic_advect", "flow.vdb", "-o", "out.vdb", "--noise", fog),
                    ("vdblic_render", fog, "-o", "out.png", *SMALL),
                    ("vdblic_render", "fog.vdb", "-o", "out.png", "--solid", fog, *SMALL),
                    ("vdblic_film", flow, "-o", "out.mp4"), ("vdblic_film", flow, "-o", "out.png", "--preview"),
                    ("vdblic_noise", "-o", "out.vdb", "--like", fog),
                    ("vdblic_diff", fog, "fog.vdb"), ("vdblic_diff", fog, fog, "-o", "out.vdb"),
                    ("vdblic_coherence", flow, "fog.vdb"), ("vdblic_coherence", "flow.vdb", fog),
                    ("vdblic_info", flow, "--values"),
                    ("vdblic_export", fog, "-o", "out.npz"), ("vdblic_export", flow, "-o", "out.vti"),
                    ("vdblic_export", fog, "-o", "out.vdb", "--levels", 2)):
                before = self.files()
                with self.subTest(far=far, command=command):
                    message = self.fails(3, *command)
                    self.assertEqual(message.count("error: "), 1, message)
                    self.assertRegex(message, "fog_|flow_")
                    self.assertNotRegex(message, r"\bnan\b|\binf\b| -[0-9]+ x")
                    self.assertEqual(self.files(), before)

    def test_what_info_tells(self):
        done = self.run_tool("vdblic_info", "flow_all.vdb", "--spacing", 2)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"2 voxels in [{-LAST - 1} {-LAST - 1} {-LAST - 1}] to [{LAST} {LAST} {LAST}]", done.stderr)
        self.assertNotRegex(done.stderr, r"\bnan\b|\binf\b| -[\d.]+ (B|KiB|MiB|s)\b")

    def test_the_module(self):
        sys.path.insert(0, str(MODULE))
        import vdblic

        for name in "fog_all", "fog_half", "flow_edge":
            with self.subTest(name), self.assertRaisesRegex(ValueError, f"{name}.vdb: grid '.*': active voxels reach"):
                vdblic.read(self.folder / f"{name}.vdb")
        volume = vdblic.read(self.folder / "fog.vdb")
        numpy.testing.assert_equal(volume["density"].values.shape, (21, 21, 21))


if __name__ == "__main__":
    unittest.main()
