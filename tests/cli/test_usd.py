"""vdblic_export into layers of USD, as OpenUSD reads and validates them."""

import itertools
import json
import math
import pathlib
import shutil
import subprocess
import unittest

import numpy
import pyopenvdb as vdb

import python_module  # pylint: disable=unused-import
from support import SOURCE, ToolTest, peer

HERE = pathlib.Path(__file__).parent
WAKE = SOURCE / "samples/wake"
USD = peer("usd", "pxr")


def world_box(grids):
    """The box around the active voxels of grids in world space, voxels half an index to each side, by OpenVDB."""
    corners = []
    for grid in grids:
        low, high = grid.evalActiveVoxelBoundingBox()
        sides = zip((x - 0.5 for x in low), (x + 0.5 for x in high))
        corners += [grid.transform.indexToWorld(corner) for corner in itertools.product(*sides)]
    return numpy.min(corners, axis=0), numpy.max(corners, axis=0)


class Layers(ToolTest):
    def layer(self, *arguments, output="flow.usda", **options):
        (path,) = self.outputs("vdblic_export", *arguments, "-o", output, **options)
        return path

    def read(self, path, *frames):
        """What OpenUSD reads; its validators must find nothing."""
        if USD is None:
            self.skipTest("usd-core is missing: tests/peers.sh gets it")
        done = subprocess.run(
            [USD, HERE / "usd/read_layer.py", path, *map(str, frames)], text=True, capture_output=True
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)
        self.assertEqual(told["errors"], [])
        return told

    def box(self, name, low, high, transform, metadata=None, others=()):
        grid = vdb.FloatGrid()
        grid.fill(low, high, 1)
        grid.name, grid.gridClass, grid.transform = "density", vdb.GridClass.FOG_VOLUME, transform
        vdb.write(str(self.folder / name), grids=[grid, *others], metadata=metadata or {})
        return grid

    def test_the_wake_is_where_openvdb_has_it(self):
        for frame in 1, 2, 3:
            shutil.copy(WAKE / f"wake.{frame:04}.vdb", self.folder)
        self.outputs("vdblic_advect", "wake.%04d.vdb", "-o", "lic.%04d.vdb", "--refine", 2, "--preroll", 0)
        layer = self.layer("lic.%04d.vdb")
        told = self.read(layer, 1, 2, 3)
        self.assertEqual((told["default"], told["up"], told["meters"], told["range"]), ("/flow", "Z", 1, [1, 3]))
        self.assertEqual(told["rate"], 20)  # 0.05 s between the files
        self.assertEqual(
            told["fields"],
            {
                "density": ["density", "float", "fogVolume", "None"],
                "magnitude": ["magnitude", "float", "fogVolume", "None"],
            },
        )
        for frame in 1, 2, 3:
            file = self.folder / f"lic.{frame:04}.vdb"
            shown = told["frames"][str(frame)]
            self.assertEqual(shown["files"], {"density": str(file), "magnitude": str(file)})
            expected = world_box([vdb.read(str(file), name) for name in ("density", "magnitude")])
            for box in shown["extent"], shown["world"]:
                numpy.testing.assert_allclose(box, expected, rtol=1e-6, atol=1e-9)
        # The layer goes with its files.
        (self.folder / "away").mkdir()
        for path in self.folder.glob("*.*"):
            path.rename(self.folder / "away" / path.name)
        moved = self.read(self.folder / "away/flow.usda", 2)["frames"]["2"]
        self.assertEqual(moved["files"]["density"], str(self.folder / "away/lic.0002.vdb"))

    def test_turned_and_mirrored_voxels(self):
        c, s = 0.1 * math.cos(0.5), 0.1 * math.sin(0.5)
        for name, rows in (
            ("turned", [[c, 0, -s, 0], [0, 0.2, 0, 0], [s, 0, c, 0], [-0.3, 5, 0.2, 1]]),
            ("mirrored", [[-0.1, 0, 0, 0], [0, 0.1, 0, 0], [0, 0, 0.1, 0], [7, 0, 0, 1]]),
        ):
            grid = self.box(f"{name}.vdb", (-3, 2, 1), (11, 9, 5), vdb.createLinearTransform(rows))
            told = self.read(self.layer(f"{name}.vdb"), 0)
            numpy.testing.assert_allclose(told["frames"]["0"]["extent"], world_box([grid]), rtol=1e-6)

    def test_winds_with_a_stretch_and_a_camera(self):
        transform = vdb.createLinearTransform([[18000, 0, 0, 0], [0, 28000, 0, 0], [0, 0, 250, 0], [-4e5, 2e5, 0, 1]])
        for frame in 1, 2:
            self.box(f"w.{frame}.vdb", (0, 0, 0), (40, 40, 47), transform, {"dt": 3600.0, "length_unit": "m"})
        (self.folder / "camera.json").write_text(
            json.dumps(
                {
                    "keys": [
                        {"frame": 1, "eye": [0, -2e6, 8e5], "target": [0, 8e5, 2e5], "fov": 40},
                        {"frame": 2, "eye": [3e5, -2e6, 8e5]},
                    ]
                }
            )
        )
        told = self.read(self.layer("w.%d.vdb", "--stretch", 1, 1, 50, "--camera", "camera.json"), 1, 2)
        self.assertEqual(told["rate"], 24)  # an hour is no frame rate
        low, high = world_box([vdb.read(str(self.folder / "w.1.vdb"), "density")])
        numpy.testing.assert_allclose(told["frames"]["1"]["extent"], (low, high), rtol=1e-6)
        numpy.testing.assert_allclose(told["frames"]["1"]["world"], (low * (1, 1, 50), high * (1, 1, 50)), rtol=1e-6)
        for frame, eye in (1, (0, -2e6, 8e5)), (2, (3e5, -2e6, 8e5)):
            camera = told["frames"][str(frame)]["camera"]
            numpy.testing.assert_allclose(camera["eye"], eye)
            forward = numpy.array((0, 8e5, 2e5)) - eye
            numpy.testing.assert_allclose(camera["forward"], forward / numpy.linalg.norm(forward), atol=1e-7)
            self.assertAlmostEqual(camera["fov"], 40, places=4)
            self.assertGreater(camera["up"][2], 0.9)
            near, far = camera["clipping"]
            self.assertLess(near, 1.5e6)
            self.assertGreater(far, 3e6)

    def test_gaps_and_grids_that_come_and_go(self):
        unit = vdb.createLinearTransform(0.5)
        other = vdb.FloatGrid()
        other.fill((0, 0, 0), (1, 1, 1), 1)
        other.name = "vel.x"
        for frame in 1, 2, 3, 7, 8:
            self.box(f"g.{frame:02}.vdb", (0, 0, 0), (frame, 4, 4), unit, others=[other] if frame == 3 else [])
        self.assertIn("frame 4 is missing", self.fails(3, "vdblic_export", "g.%02d.vdb", "-o", "flow.usda"))
        done = self.run_tool("vdblic_export", "g.%02d.vdb", "-o", "flow.usda", "--frames", "1-3,7,8")
        self.assertEqual(done.stderr, "vdblic_export: frames 4 to 6 are missing: frame 3 stays until then\n")
        told = self.read(self.folder / "flow.usda", 1, 3, 6, 7)
        self.assertEqual(told["fields"]["vel_x"][0], "vel.x")
        self.assertEqual(told["range"], [1, 8])
        files = {
            frame: {name: file and pathlib.Path(file).name for name, file in shown["files"].items()}
            for frame, shown in told["frames"].items()
        }
        self.assertEqual(
            files,
            {
                "1": {"density": "g.01.vdb", "vel_x": None},
                "3": {"density": "g.03.vdb", "vel_x": "g.03.vdb"},
                "6": {"density": "g.03.vdb", "vel_x": "g.03.vdb"},
                "7": {"density": "g.07.vdb", "vel_x": None},
            },
        )
        self.assertEqual(told["frames"]["6"]["extent"], told["frames"]["3"]["extent"])  # as long as its file
        # Every second frame is no gap.
        done = self.run_tool("vdblic_export", "g.%02d.vdb", "-o", "flow.usda", "--frames", "1,3")
        self.assertNotIn("missing", done.stderr)

    def test_names_that_need_care(self):
        folder = self.folder / "Träger raum@@@1"
        folder.mkdir()
        velocity = vdb.Vec3SGrid()
        velocity.fill((0, 0, 0), (3, 3, 3), (1, 0, 0))
        velocity.name, velocity.gridClass = "7 ü", "staggered"
        vdb.write(str(folder / "v.vdb"), grids=[velocity], metadata={"creator": "Houdini/GEO_VDBTranslator"})
        (self.folder / "layers").mkdir()
        told = self.read(self.layer(folder / "v.vdb", output="layers/flow.usda"), 0)
        self.assertEqual(told["up"], "Y")
        self.assertEqual(told["fields"], {"_7__": ["7 ü", "float3", "staggered", "Vector"]})
        self.assertEqual(told["frames"]["0"]["files"]["_7__"], str(folder / "v.vdb"))

    def test_options_and_standard_input(self):
        self.box("o.1.vdb", (0, 0, 0), (4, 4, 4), vdb.createLinearTransform(1), {"length_unit": "km", "dt": 0.04})
        plain = self.layer("o.1.vdb").read_text()
        self.assertIn("metersPerUnit = 1000\n", plain)
        self.assertIn("timeCodesPerSecond = 25\n", plain)
        self.box("e.1.vdb", (0, 0, 0), (4, 4, 4), vdb.createLinearTransform(1), {"length_unit": "Mm"})
        self.assertIn("metersPerUnit = 1000000\n", self.layer("e.1.vdb").read_text())
        self.assertIn("startTimeCode = 1\n", plain)
        self.assertIn("endTimeCode = 2\n", plain)  # motion is blurred over an interval
        text = self.layer("-", "--up", "y", "--fps", 30, "--meters-per-unit", 0.01, stdin="o.1.vdb\n").read_text()
        for line in 'upAxis = "Y"', "timeCodesPerSecond = 30", "metersPerUnit = 0.01":
            self.assertIn(line + "\n", text)
        (self.folder / "flow.usda").write_text("mine")
        self.layer("o.1.vdb", "--skip-existing")
        self.assertEqual((self.folder / "flow.usda").read_text(), "mine")

    def test_a_coarser_proxy(self):
        for frame in 1, 2:
            self.box(f"p.{frame:04}.vdb", (0, 0, 0), (8 * frame - 1, 7, 7), vdb.createLinearTransform(0.5))
        made = self.outputs("vdblic_export", "p.%04d.vdb", "-o", "flow.usda", "--levels", 2)
        names = [f"flow.level{level}.{frame:04}.vdb" for frame in (1, 2) for level in (1, 2)]
        self.assertEqual([path.name for path in made], [*names, "flow.usda"])
        told = self.read(self.folder / "flow.usda", 1, 2)
        self.assertEqual(told["proxy"], ["render", "proxy", "/flow/proxy"])
        for frame in "1", "2":
            shown = told["frames"][frame]
            self.assertEqual(shown["proxy"], str(self.folder / f"flow.level2.000{frame}.vdb"))
            numpy.testing.assert_allclose(shown["world"], shown["proxy_world"], atol=1e-6)

    def test_an_orthographic_camera(self):
        self.box("o.vdb", (0, 0, 0), (4, 4, 4), vdb.createLinearTransform(1))
        (self.folder / "c.json").write_text(
            '{"keys": [{"frame": 1, "eye": [2, 2, 30], "target": [2, 2, 2], "height": 9}]}'
        )
        camera = self.read(self.layer("o.vdb", "--camera", "c.json"), 0)["frames"]["0"]["camera"]
        self.assertIn("Orthographic", camera["projection"])
        numpy.testing.assert_allclose(camera["up"], (0, 1, 0), atol=1e-7)

    def test_mistakes(self):
        self.box("m.1.vdb", (0, 0, 0), (4, 4, 4), vdb.createLinearTransform(1))
        empty = vdb.FloatGrid()
        empty.name = "density"
        vdb.write(str(self.folder / "empty.vdb"), grids=[empty])
        (self.folder / "noeye.json").write_text('{"keys": [{"frame": 1, "target": [0, 0, 0]}]}')
        (self.folder / "point.json").write_text('{"keys": [{"frame": 1, "target": [0, 0, 0], "eye": [0, 0, 0]}]}')
        before = self.files()
        for status, words, *arguments in (
            (2, "one layer names the files of all frames", "m.%d.vdb", "-o", "flow.%04d.usda"),
            (2, "--camera is of a layer", "m.1.vdb", "-o", "m.vti", "--camera", "noeye.json"),
            (2, "--stretch is of a layer", "m.1.vdb", "-o", "m.npz", "--stretch", 1, 1, 2),
            (2, 'no key has "eye"', "m.1.vdb", "-o", "flow.usda", "--camera", "noeye.json"),
            (2, "eye and target are one point", "m.1.vdb", "-o", "flow.usda", "--camera", "point.json"),
            (3, "noeye.jsn", "m.1.vdb", "-o", "flow.usda", "--camera", "noeye.jsn"),
            (3, "no grid 'q' of numbers or vectors; present: density", "m.1.vdb", "-o", "flow.usda", "--grids", "q"),
            (3, "no voxel in any frame", "empty.vdb", "-o", "flow.usda"),
            (4, "make it first", "m.1.vdb", "-o", "nowhere/flow.usda"),
        ):
            with self.subTest(words):
                self.assertIn(words, self.fails(status, "vdblic_export", *arguments))
                self.assertEqual(self.files(), before)


if __name__ == "__main__":
    unittest.main()
