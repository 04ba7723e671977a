"""Names of grids and texts in files reach a terminal, XML, USD, JSON, NumPy and Python in the form that each can take."""

import json
import os
import pathlib
import sys
import unittest
import xml.etree.ElementTree

import numpy
import pyopenvdb as vdb

from support import HAS_MODULE, MODULE, ToolTest

# Ten bytes each: a title for the terminal, a forged message, one byte of a terminal's control, no UTF-8, markup, words.
NAMES = (b"\x1b]0;title\x07"[:10], b"a\nerror: b", b"\xc2\x9b31mred..", b"\xff\xfe no utf8", b"<a&b'\">\\{}"[:10],
         "größe 速".encode()[:10], b"tab\tand\rcr", b"\xe2\x80\xaegpj.exe")
PLACE = b"PLACEHOLDE"


def shown(name):
    """A name as a terminal gets it."""
    special = {0x1b: "\\x1b", 0x7: "\\x07", 0xa: "\\n", 0x9: "\\t", 0xd: "\\r", 0x9b: "\\u009b", 0x202e: "\\u202e"}
    text = name.decode("utf-8", "surrogateescape")
    return "".join(special.get(ord(c), f"\\x{ord(c) - 0xdc00:02x}" if 0xdc80 <= ord(c) < 0xdd00 else c) for c in text)


class ForeignTexts(ToolTest):
    def write(self, name):
        """A texture, a velocity and a text whose names and values are these bytes."""
        fog, flow = vdb.FloatGrid(), vdb.Vec3SGrid()
        fog.fill((0, 0, 0), (7, 7, 7), 0.5)
        flow.fill((0, 0, 0), (7, 7, 7), (1, 0, 0))
        for grid in fog, flow:
            grid.name = PLACE.decode()
            grid["note"] = PLACE.decode()
        for path, grid in ("fog", fog), ("flow", flow):
            vdb.write(str(self.folder / f"{path}.vdb"), grids=[grid], metadata={"note": PLACE.decode(), "time": "noon"})
            data = self.contents(f"{path}.vdb")
            self.assertIn(PLACE, data)
            (self.folder / f"{path}.vdb").write_bytes(data.replace(PLACE, name))

    def says(self, *command, status=0):
        """What a tool prints as bytes: lines of its own, each of characters alone."""
        done = self.run_tool(*command, errors="surrogateescape")
        self.assertEqual(done.returncode, status, done.stderr)
        for line in done.stderr.splitlines():
            self.assertTrue(line.startswith(command[0] + ": "), done.stderr)
        for stream in done.stdout, done.stderr:
            stream.encode()  # no lone byte
            self.assertFalse([c for c in stream if c != "\n" and (ord(c) < 32 or 0x7f <= ord(c) < 0xa0 or c == "\u202e")],
                             repr(stream))
        return done.stderr

    def test_terminal(self):
        for name in NAMES:
            self.assertEqual(len(name), len(PLACE), name)
            self.write(name)
            with self.subTest(name):
                self.assertIn(f"grid {shown(name)} (", self.says("vdblic_info", "fog.vdb", "flow.vdb"))
                self.assertIn(shown(name), self.says("vdblic_advect", "flow.vdb", "-o", "l.vdb", "--velocity", "x", status=3))
                self.says("vdblic_diff", "fog.vdb", "flow.vdb", status=1)
                self.says("vdblic_render", "fog.vdb", "-o", "p.png", "--texture", "no", "--size", 8, 8, status=3)
                self.says("vdblic_info", "no\x1b[2J.vdb", status=3)

    def test_json(self):
        for name in NAMES:
            self.write(name)
            text = name.decode("utf-8", "replace")
            with self.subTest(name):
                self.says("vdblic_info", "fog.vdb", "--json", "i.json")
                self.assertEqual(json.loads(self.contents("i.json"))["sequences"][0]["grids"][0]["name"], text)
                self.says("vdblic_diff", "fog.vdb", "fog.vdb", "--json", "d.json")
                self.assertIn(text, self.texts_in(json.loads(self.contents("d.json"))))
                self.says("vdblic_render", "fog.vdb", "-o", "p.png", "--size", 8, 8, "--texture", os.fsdecode(name),
                          "--opacity-by", os.fsdecode(name), "--histogram", "h.json")
                json.loads(self.contents("h.json"))

    def texts_in(self, value):
        """All texts in a value of JSON."""
        if isinstance(value, dict):
            return [text for pair in value.items() for part in pair for text in self.texts_in(part)]
        if isinstance(value, list):
            return [text for part in value for text in self.texts_in(part)]
        return [value] if isinstance(value, str) else []

    @unittest.skipUnless(HAS_MODULE, "the module is not built, or a sanitized one")
    def test_export(self):
        from vtkmodules.vtkIOXML import vtkXMLImageDataReader

        for name in NAMES:
            self.write(name)
            with self.subTest(name):
                self.says("vdblic_export", "fog.vdb", "-o", "f.vti")
                head = self.contents("f.vti").partition(b"<AppendedData")[0] + b"</VTKFile>"
                root = xml.etree.ElementTree.fromstring(head)
                self.assertEqual(len([a for a in root.iter("DataArray") if shown_like(a.get("Name"), name)]), 1,
                                 [a.get("Name") for a in root.iter("DataArray")])
                reader = vtkXMLImageDataReader()
                reader.SetFileName(str(self.folder / "f.vti"))
                reader.Update()
                self.assertEqual(reader.GetOutput().GetPointData().GetNumberOfArrays(), 3)
                self.says("vdblic_export", "flow.vdb", "-o", "f.usda")
                layer = self.contents("f.usda")
                layer.decode()
                self.assertFalse([b for b in layer if b < 32 and b != 10], layer)
                self.assertEqual(layer.count(b"token fieldName"), 1)
                plain = name.decode("utf-8", "surrogateescape").isprintable()
                self.says("vdblic_export", "fog.vdb", "-o", "f.npz", status=0 if plain else 3)
                if plain:
                    with numpy.load(self.folder / "f.npz") as arrays:
                        self.assertIn(name.decode(), arrays.files)
                self.says("vdblic_export", "fog.vdb", "-o", "c.vdb", "--levels", 1)

    @unittest.skipUnless(HAS_MODULE, "the module is not built, or a sanitized one")
    def test_names_that_are_taken(self):
        for name in "active", "matrix", "file", "self", "vtkGhostType":
            grid = vdb.FloatGrid()
            grid.fill((0, 0, 0), (3, 3, 3), 0.5)
            grid.name = name
            vdb.write(str(self.folder / "f.vdb"), grids=[grid])
            for kind, taken in ("npz", ("active", "matrix")), ("vti", ("active", "vtkGhostType")):
                with self.subTest(name, kind=kind):
                    message = self.says("vdblic_export", "f.vdb", "-o", f"f.{kind}", status=3 if name in taken else 0)
                    self.assertEqual(f"grid '{name}': an array of .{kind} files cannot" in message, name in taken)

    @unittest.skipUnless(HAS_MODULE, "the module is not built, or a sanitized one")
    def test_module(self):
        sys.path.insert(0, str(MODULE))
        import vdblic

        for name in NAMES:
            self.write(name)
            with self.subTest(name):
                volume = vdblic.read(self.folder / "fog.vdb")
                text = name.decode("utf-8", "surrogateescape")
                self.assertEqual([grid.name for grid in volume.grids], [text])
                self.assertEqual(volume.metadata["note"], text)
                vdblic.write(self.folder / "again.vdb", volume)
                again = vdblic.read(self.folder / "again.vdb")
                self.assertEqual(([grid.name for grid in again.grids], again.metadata["note"]), ([text], text))
                with self.assertRaises(ValueError) as raised:
                    vdblic.diff(self.folder / "fog.vdb", pathlib.Path("missing\x1b.vdb"))
                self.assertNotIn("\x1b", str(raised.exception))

    @unittest.skipUnless(HAS_MODULE, "the module is not built, or a sanitized one")
    def test_what_the_module_refuses(self):
        sys.path.insert(0, str(MODULE))
        import vdblic

        values = numpy.ones((4, 4, 4), numpy.float32)
        for words, grid, metadata in (
                ("a name has 1 to", {}, {"": 1}), ("a name has 1 to", {}, {"x" * 5000: 1}),
                ("surrogates", {}, {"note": "\ud800"}), ("surrogates", {}, {"\ud800": 1}),
                ("surrogates", {"name": "\ud800"}, {}), ("`name` has", {"name": "a\x1eb"}, {}),
                ("`name` has", {"name": "x" * 5000}, {}),
                *(("`transform` (flattens|cannot be used)", {"transform": matrix}, {}) for matrix in (
                    numpy.eye(4) * numpy.nan, numpy.diag([1e200] * 3 + [1]), numpy.diag([1, 1, 0, 1.0]),
                    numpy.array([[1, 1e16, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]),
                    numpy.where(numpy.eye(4, k=3) > 0, numpy.nan, numpy.eye(4)))),
                ("`origin` 2147483640 0 0 puts voxels", {"origin": (2**31 - 8, 0, 0)}, {}),
                ("`origin` 0 -2147483648 0 puts voxels", {"origin": (0, -2**31, 0)}, {}),
                ("`origin` 0 0 999999998 puts voxels", {"origin": (0, 0, 999999998)}, {})):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                vdblic.write(self.folder / "w.vdb", vdblic.Grid(values, **grid), metadata)
            self.assertFalse((self.folder / "w.vdb").exists())
        for path in "w\0.vdb", "\ud800.vdb":
            for call in (lambda: vdblic.write(path, vdblic.Grid(values)), lambda: vdblic.read(path),
                         lambda: vdblic.diff(path, "w.vdb"), lambda: vdblic.coherence("w.vdb", path),
                         lambda: next(vdblic.advect(path)), lambda: vdblic.Renderer(transfer=path)):
                with self.subTest(repr(path)), self.assertRaises(ValueError):
                    call()
        vdblic.write(self.folder / "w.vdb", vdblic.Grid(values, origin=(999999997, -1000000000, 0)))
        self.assertEqual(vdblic.read(self.folder / "w.vdb").grids[0].values.sum(), 64)

    @unittest.skipUnless(HAS_MODULE, "the module is not built, or a sanitized one")
    def test_metadata_of_one_name_in_two_types(self):
        grid = vdb.FloatGrid()
        grid.fill((0, 0, 0), (7, 7, 7), 0.5)
        grid.name, grid["note"], grid["time"] = "density", "of the grid", "noon"
        vdb.write(str(self.folder / "f.vdb"), grids=[grid], metadata={"note": 5, "time": 0.5})
        self.says("vdblic_export", "f.vdb", "-o", "f.npz")
        with numpy.load(self.folder / "f.npz") as arrays:
            self.assertEqual(arrays["time"], 0.5)

    @unittest.skipUnless(HAS_MODULE, "the module is not built, or a sanitized one")
    def test_metadata_that_openvdb_calls_its_own(self):
        sys.path.insert(0, str(MODULE))
        import vdblic

        own = "class", "vector_type", "file_bbox_min", "file_compression", "file_delayed_load", "file_mem_bytes", "name"
        values = numpy.ones((4, 4, 4, 3), numpy.float32)
        for value in 5, "text", (1, 2, 3):
            grid = vdblic.Grid(values, name="velocity", staggered=True, metadata=dict.fromkeys(own, value))
            with self.subTest(value):
                vdblic.write(self.folder / "own.vdb", grid)
                self.assertTrue(vdblic.read(self.folder / "own.vdb")["velocity"].staggered)


def shown_like(text, name):
    """Whether an attribute of XML shows a name: as it is, or with what no XML has escaped."""
    return text is not None and (text == name.decode("utf-8", "replace") or text in (
        shown(name), shown(name).replace("\\u009b", "\\x9b")))


if __name__ == "__main__":
    unittest.main()
