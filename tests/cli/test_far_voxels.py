"""Volumes whose voxels are as far apart as indices can be: every tool refuses them, or tells their true size."""

import itertools
import struct
import sys
import unittest

import numpy
import pyopenvdb as vdb

import far_files
import vdb_bytes
from support import BIN, MODULE, ToolTest, often

HAS_CONVERTERS = (BIN / "vdblic_export").exists()
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

    def check(self, path, commands):
        """Each ends soon with status 0, or with 3 and one message that names the file."""
        for command in commands:
            before = self.files()
            with self.subTest(path, command=command):
                done = self.run_tool(*command, timeout=60)
                said = done.stdout + done.stderr
                self.assertIn(done.returncode, (0, 3), said)
                self.assertNotRegex(said, r"\bnan\b|\binf\b| -[0-9]+ x| -[\d.]+ (B|KiB|MiB)\b|Traceback")
                if done.returncode == 0:
                    for name in set(self.files()) - set(before):
                        (self.folder / name).unlink()
                    continue
                self.assertEqual(said.count("error: "), 1, said)
                self.assertRegex(said, f"{path}|check the grid, --roi")
                self.assertEqual(self.files(), before)

    def test_other_types_of_grids(self):
        """At the last indices, and at the farthest that are taken."""
        for number, (kind, corners) in enumerate(itertools.product(far_files.TYPES, ((-LAST - 1, LAST), (-10**9, 10**9)))):
            name = "velocity" if kind.startswith("vec") else "density"
            far = f"{kind}_{number}.vdb"
            (self.folder / far).write_bytes(far_files.far_file(kind, name, [(corner,) * 3 for corner in corners]))
            commands = [
                ("vdblic_advect", "flow.vdb", "-o", "out.vdb", "--mask", far),
                ("vdblic_render", far, "-o", "out.png", *SMALL), ("vdblic_info", far, "--values"),
                ("vdblic_render", "fog.vdb", "-o", "out.png", "--solid", far, *SMALL),
                ("vdblic_advect", "flow.vdb", "-o", "out.vdb", "--method", "streaks", "--emit", far),
                ("vdblic_advect", "flow.vdb", "-o", "out.vdb", "--method", "streaks", "--source", f"it={far}"),
                ("vdblic_render", "fog.vdb", "-o", "out.png", "--roi", far, *SMALL), ("vdblic_info", far, "--json", "-"),
                ("vdblic_noise", "-o", "out.vdb", "--like", far), ("vdblic_diff", far, far, "-o", "out.vdb"),
                ("vdblic_coherence", "flow.vdb", far), ("vdblic_advect", "flow.vdb", "-o", "out.vdb", "--noise", far)]
            if name == "velocity":
                methods = "auflic", "uflic", "lic", "streaks", "ibfv", "lea", "ufac"
                commands = [("vdblic_advect", far, "-o", "out.vdb", "--method", method) for method in methods]
                commands += [("vdblic_film", far, "-o", "out.png", "--preview"), ("vdblic_coherence", far, "fog.vdb"),
                             ("vdblic_noise", "-o", "out.vdb", "--like", far), ("vdblic_diff", far, far),
                             ("vdblic_info", far, "--values")]
            if HAS_CONVERTERS:
                commands += [("vdblic_export", far, "-o", f"out{suffix}") for suffix in (".npz", ".vti", ".usda", ".vtp")]
            step = often(6, 1)
            self.check(far, commands[number % step::step])
            (self.folder / far).unlink()

    def test_points(self):
        self.outputs("vdblic_advect", "flow.vdb", "-o", "lines.vdb", "--method", "streaks", "--draw", "lines")
        data = self.contents("lines.vdb")
        walk = vdb_bytes.Walk(data)
        begin, end = walk.grids[walk.kinds.index("Tree_ptdataidx32_5_4_3")]
        places = [at for what, at, _ in walk.fields if what == "place of a child" and begin <= at < end]
        for corner in -LAST - 1, LAST - 4095, -10**9 & ~4095:
            far = bytearray(data)
            for at in places:
                struct.pack_into("<i", far, at, corner)
            (self.folder / "points.vdb").write_bytes(vdb_bytes.sealed(bytes(far)))
            commands = [("vdblic_render", "points.vdb", "-o", "out.png", *SMALL), ("vdblic_info", "points.vdb", "--values"),
                        ("vdblic_diff", "points.vdb", "points.vdb"), ("vdblic_noise", "-o", "out.vdb", "--like", "points.vdb")]
            if HAS_CONVERTERS:
                commands += [("vdblic_export", "points.vdb", "-o", f"out{suffix}") for suffix in (".vtp", ".usda", ".npz")]
            self.check("points.vdb", commands)

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
