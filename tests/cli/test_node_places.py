"""Volumes whose nodes do not lie where their parents have them: no tool works on them, though OpenVDB reads them."""

import struct
import subprocess
import sys
import unittest

import pyopenvdb as vdb

from support import BIN, MODULE, ToolTest

HAS_CONVERTERS = (BIN / "vdblic_export").exists()
SMALL = ("--size", 24, 16)
LAST = 2**31 - 1
KEY = (4096, -4096, 8192)  # of a child of the root, in the file as it is
FLOW, FOG = ("velocity", "vec3s", 3), ("density", "float", 1)


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def old_file(grid, origins):
    """A file in format 221, whose leaves tell their origins: eight leaves of 1 in a cube."""
    name, kind, components = grid
    offsets = [x << 8 | y << 4 | z for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    mask = lambda bits, size: sum(1 << bit for bit in bits).to_bytes(size // 8, "little")
    number = struct.pack("<f", 1) * components
    metadata = struct.pack("<I", 1) + text("name") + text("string") + text(name)
    place = text("UniformScaleMap") + struct.pack("<15d", *[1] * 12, *[0.5] * 3)
    topology = struct.pack("<i", 1) + bytes(len(number)) + struct.pack("<II3i", 0, 1, 0, 0, 0)
    for children, size in ([0], 32768), (offsets, 4096):
        topology += mask(children, size) + bytes(size // 8) + bytes(len(number) * (size - len(children)))
    topology += b"\xff" * 64 * len(offsets)
    leaves = b"".join(b"\xff" * 64 + struct.pack("<3ib", *origin, 1) + number * 512 for origin in origins)
    head = struct.pack("<qIII", 0x56444220, 221, 10, 0) + b"\1\0" + b"00000000-0000-4000-8000-000000000000"
    head += struct.pack("<Ii", 0, 1) + text(name) + text(f"Tree_{kind}_5_4_3") + text("")
    begin = len(head) + 24
    blocks = begin + len(metadata + place + topology)
    return head + struct.pack("<3q", begin, blocks, blocks + len(leaves)) + metadata + place + topology + leaves


class NodePlaces(ToolTest):
    def setUp(self):
        super().setUp()
        for (name, *_), grid, value in (FOG, vdb.FloatGrid(), 0.5), (FLOW, vdb.Vec3SGrid(), (1, 2, 3)):
            grid.fill((0, 0, 0), (15, 15, 15), value)
            grid.fill(KEY, tuple(at + 15 for at in KEY), value)
            grid.name = name
            vdb.write(str(self.folder / f"{name}.vdb"), grids=[grid])

    def commands(self):
        flow, fog = "velocity.bad.vdb", "density.bad.vdb"
        for method in "auflic", "auflic-2004", "uflic", "lic", "streaks", "ibfv", "lea", "ufac":
            yield "vdblic_advect", flow, "-o", "out.vdb", "--method", method
        advect = ("vdblic_advect", "velocity.vdb", "-o", "out.vdb")
        yield from (("vdblic_film", flow, "-o", "out.png"), ("vdblic_noise", "--like", fog, "-o", "out.vdb"),
                    (*advect, "--mask", fog), (*advect, "--noise", f"{fog}:density"),
                    (*advect, "--method", "streaks", "--emit", fog),
                    ("vdblic_render", fog, "-o", "out.png", *SMALL),
                    ("vdblic_render", "density.vdb", "-o", "out.png", "--solid", fog, *SMALL),
                    ("vdblic_diff", fog, "density.vdb", "-o", "out.vdb"), ("vdblic_diff", "density.vdb", fog),
                    ("vdblic_coherence", flow, "density.vdb"), ("vdblic_coherence", "velocity.vdb", fog))
        if HAS_CONVERTERS:
            yield from (("vdblic_export", fog, "-o", "out.npz"), ("vdblic_export", flow, "-o", "out.vti"),
                        ("vdblic_export", fog, "-o", "out.vdb", "--levels", 1))

    @staticmethod
    def few():
        return (("vdblic_noise", "--like", "density.bad.vdb", "-o", "out.vdb"),
                ("vdblic_advect", "velocity.bad.vdb", "-o", "out.vdb"))

    def refused(self, make, commands):
        """None of the commands takes files whose bytes are make(grid)."""
        for grid in FOG, FLOW:
            (self.folder / f"{grid[0]}.bad.vdb").write_bytes(make(grid))
        before = self.files()
        for command in commands:
            with self.subTest(command=command):
                message = self.fails(3, *command)
                self.assertEqual(message.count("error: "), 1, message)
                self.assertRegex(message, r"\.bad\.vdb: cannot be read as a \.vdb file: nodes of grid '\w+' do not lie in "
                                          "their places")
                self.assertEqual(self.files(), before)
        told = self.run_tool("vdblic_info", "density.bad.vdb", "velocity.bad.vdb", "--values")
        self.assertEqual(told.returncode, 3, told.stderr)

    def test_keys_of_roots(self):
        """Two nodes at one place, and one that lies not where it is looked for."""
        for key, commands in ((1, 0, 0), self.commands()), ((4097, 0, 0), self.few()), ((LAST,) * 3, self.few()):
            with self.subTest(key=key):
                self.refused(lambda grid, key=key: self.with_key(grid[0], key), commands)

    def with_key(self, name, key):
        data = self.contents(f"{name}.vdb")
        self.assertEqual(data.count(struct.pack("<3i", *KEY)), 1)
        return data.replace(struct.pack("<3i", *KEY), struct.pack("<3i", *key))

    def test_origins_of_leaves(self):
        """All at one place, between the places, in each other's, and so far away that boxes are inside out."""
        cube = [(x, y, z) for x in (0, 8) for y in (0, 8) for z in (0, 8)]
        for move in (lambda x, y, z: (0, 0, 0), lambda x, y, z: (x + 3, y, z), lambda x, y, z: (8 - x, y, z),
                     lambda x, y, z: (LAST - 3, y, z), lambda x, y, z: (-LAST - 1,) * 3):
            origins = [move(*corner) for corner in cube]
            with self.subTest(origins=origins):
                self.refused(lambda grid, origins=origins: old_file(grid, origins), self.few())
        (self.folder / "old.vdb").write_bytes(old_file(FOG, cube))
        self.assertEqual(self.run_tool("vdblic_info", "old.vdb").returncode, 0)
        self.assertEqual(vdb.read(str(self.folder / "old.vdb"), "density").activeVoxelCount(), 4096)

    def test_the_module(self):
        if not list(MODULE.glob("vdblic/_core*.so")):
            self.skipTest("the module is not built")
        self.refused_by_the_module(self.with_key("density", (1, 0, 0)))
        self.refused_by_the_module(old_file(FOG, [(0, 0, 0)] * 8))

    def refused_by_the_module(self, data):
        (self.folder / "bad.vdb").write_bytes(data)
        read = "import sys; sys.path.insert(0, sys.argv[1]); import vdblic; vdblic.read(sys.argv[2])"
        done = subprocess.run([sys.executable, "-c", read, MODULE, self.folder / "bad.vdb"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, "InputError: .*bad.vdb: .*do not lie in their places")


if __name__ == "__main__":
    unittest.main()
