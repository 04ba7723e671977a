"""Streaks as lines in Debian's Blender and in a current one (`bpy`): imported, played, chosen, made."""

import unittest

import numpy
import pyopenvdb as vdb

import python_module  # pylint: disable=unused-import
from test_blender_addon import InCurrentBlender, InDebiansBlender

from vdblic._core import read_lines

DRAWN = """
def drawn(thing):
    shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = [0.0] * (3 * len(shown.points))
    shown.points.foreach_get("position", points)
    widths = [0.0] * len(shown.points)
    shown.attributes["radius"].data.foreach_get("value", widths)
    low, high = ([pick(points[axis::3]) for axis in range(3)] for pick in (min, max))
    return [len(shown.curves), len(shown.points), low, high, max(widths)]
"""


class Both:
    """What both Blenders do."""

    helpers = DRAWN

    def swirl(self, creator=""):
        """Velocities of three frames of a solid body's rotation, 24 by 24 by 8 voxels of 0.1."""
        place = numpy.indices((24, 24, 8)).transpose(1, 2, 3, 0) - numpy.array([11.5, 11.5, 3.5])
        grid = vdb.Vec3SGrid()
        grid.name, grid.transform = "velocity", vdb.createLinearTransform(0.1)
        grid.copyFromArray(numpy.stack([-place[..., 1], place[..., 0], 0 * place[..., 0]], axis=-1).astype(numpy.float32))
        metadata = {"creator": creator} if creator else {}
        for frame in 4, 5, 6:
            vdb.write(str(self.folder / f"v.{frame:04}.vdb"), grids=[grid], metadata=metadata)

    def layer(self, creator=""):
        """Lines of three frames as a layer; returns it and what each frame has."""
        self.swirl(creator)
        streaks = "--method", "streaks", "--spacing", 3, "--refine", 3, "--draw", "lines", "--with", "q"
        files = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "s.%04d.vdb", *streaks)
        (layer,) = self.outputs("vdblic_export", "s.%04d.vdb", "-o", "flow.usda")
        return layer, [read_lines(file)[0] for file in files]

    def assert_drawn(self, drawn, moment):
        lines, points, low, high, widest = drawn
        self.assertEqual((lines, points), (len(moment["counts"]), len(moment["points"])))
        numpy.testing.assert_allclose(low, moment["points"].min(axis=0), atol=1e-5)
        numpy.testing.assert_allclose(high, moment["points"].max(axis=0), atol=1e-5)
        self.assertAlmostEqual(widest / moment["radius"].max(), 1, places=4)

    def test_lines_are_where_and_when_they_are(self):
        layer, moments = self.layer()
        (self.folder / "empty.usda").write_text('#usda 1.0\ndef Xform "flow"\n{\n}\n')
        told = self.drive(f"""
            scene.frame_start, scene.frame_end = 3, 30
            bpy.ops.vdblic.import_lines(filepath={str(layer)!r})
            thing = bpy.context.object
            tell("scene", [scene.frame_current, scene.frame_start, scene.frame_end, len(scene.objects)])
            tell("place", [list(row) for row in thing.matrix_world])
            views = [space.region_3d.view_location for screen in bpy.data.screens for area in screen.areas
                     for space in area.spaces if space.type == "VIEW_3D"]
            tell("views", [list(view) for view in views])
            for frame in 6, 4, 5:
                scene.frame_set(frame)
                tell(frame, drawn(thing))
            for frame in 1, 60:
                scene.frame_set(frame)
                tell(frame, drawn(thing))
            bpy.ops.wm.save_as_mainfile(filepath={str(self.folder / "lines.blend")!r})
            bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
            scene = bpy.context.scene
            scene.frame_set(5)
            tell("opened", drawn(bpy.context.object))
            tell("refused", refused(bpy.ops.vdblic.import_lines, filepath={str(self.folder / "none.usda")!r}))
            tell("no lines", refused(bpy.ops.vdblic.import_lines, filepath={str(self.folder / "empty.usda")!r}))
            tell("left", len(scene.objects))
            import os
            os.remove({str(layer)!r})
            scene.frame_set(6)
            tell("lost", drawn(scene.objects[0])[0] if len(bpy.data.meshes) == 0 else 0)
            """)
        self.assertEqual(told["scene"], [4, 3, 30, 1])
        numpy.testing.assert_allclose(told["place"], numpy.eye(4), atol=1e-6)
        numpy.testing.assert_allclose(told["views"], numpy.tile((1.15, 1.15, 0.35), (len(told["views"]), 1)), atol=0.1)
        for frame, moment in zip((4, 5, 6, 1, 60, "opened"), [*moments, moments[0], moments[2], moments[1]]):
            self.assert_drawn(told[frame], moment)
        self.assertRegex(self.output, f"units, frames 4 to 6, {len(moments[0]['counts'])} lines")
        self.assertIn("none.usda: no such file", told["refused"])
        self.assertIn("empty.usda: no lines", told["no lines"])
        self.assertEqual(told["left"], 1)
        if told["lost"] == 0:  # else Blender's own importer made them
            self.assertIn(f"No such file or directory: '{layer}'", self.output)

    def test_lines_are_chosen_and_coloured(self):
        layer, moments = self.layer("Houdini/GEO_VDBTranslator")
        told = self.drive(f"""
            bpy.ops.vdblic.import_lines(filepath={str(layer)!r}, look="INK", set_range=True)
            thing = bpy.context.object
            tell("range", [scene.frame_start, scene.frame_end])
            tell("up", list(thing.matrix_world.col[1])[:3])
            node = thing.data.materials[0].node_tree.nodes["Flow"]
            tell("colours", [node.inputs[name].default_value for name in ("From", "To")])
            speeds = {float(numpy.quantile(moments[0]["scalars"]["magnitude"], 0.5))!r}
            bpy.ops.vdblic.show_lines(select_by="magnitude", least=speeds)
            tell("fast", drawn(thing)[0])
            bpy.ops.mesh.primitive_cube_add(size=2, location=(0, 0, 0))
            box = bpy.context.object
            box.matrix_world = thing.matrix_world
            bpy.context.view_layer.objects.active = thing
            bpy.ops.vdblic.show_lines(box=box.name)
            tell("inside", drawn(thing)[0])
            bpy.ops.vdblic.show_lines(scalar="q", low=1, high=2)
            tell("all", [drawn(thing)[0], len(bpy.data.materials), box.hide_render])
            tell("scalar", thing.data.materials[0].node_tree.nodes["Scalar"].attribute_name)
            tell("refused", refused(bpy.ops.vdblic.show_lines, select_by="heat"))
            tell("no box", refused(bpy.ops.vdblic.show_lines, box="Crate"))
            """)
        moment = moments[0]
        lines = numpy.split(numpy.arange(len(moment["points"])), numpy.cumsum(moment["counts"])[:-1])
        speeds = moment["scalars"]["magnitude"]
        self.assertEqual(told["range"], [4, 6])
        numpy.testing.assert_allclose(told["up"], (0, 0, 1), atol=1e-6)
        numpy.testing.assert_allclose(told["colours"], numpy.quantile(speeds, (0.01, 0.99)), rtol=1e-4)
        fast = sum(speeds[line].mean() >= numpy.quantile(speeds, 0.5) for line in lines)
        self.assertAlmostEqual(told["fast"], fast, delta=2)
        self.assertTrue(0 < fast < len(lines))
        inside = sum((moment["points"][line].mean(axis=0) <= 1).all() for line in lines)
        self.assertEqual(told["inside"], inside)
        self.assertTrue(0 < inside < len(lines))
        self.assertEqual(told["all"], [len(lines), 1, True])
        self.assertEqual(told["scalar"], "q")
        self.assertRegex(told["refused"], "no scalar 'heat'; it has .*magnitude, q")
        self.assertIn("there is no object 'Crate'", told["no box"])

    def test_lines_are_made_and_made_again(self):
        self.swirl()
        told = self.drive(f"""
            settings = scene.vdblic
            settings.source, settings.velocity = "FILES", {str(self.folder / "v.0004.vdb")!r}
            settings.folder, settings.spacing, settings.refine = {str(self.folder / "out")!r}, 3, 3
            tell("default", [settings.method, settings.draw])
            bpy.ops.vdblic.make(wait=True)
            first = bpy.context.object
            tell("first", [first.type, scene.frame_current, drawn(first)[0]])
            first.name = "mine"
            bpy.ops.vdblic.show_lines(select_by="magnitude", least=0)
            settings.spacing = 4
            bpy.ops.vdblic.make(wait=True)
            again = bpy.context.object
            from_group = [item for item in again.modifiers if item.type == "NODES"]
            tell("again", [again.name, drawn(again)[0], len(scene.objects), len(bpy.data.hair_curves), len(bpy.data.meshes),
                           len(bpy.data.materials), len(bpy.data.cache_files), len(from_group)])
            settings.draw, settings.folder = "VOLUME", {str(self.folder / "volume")!r}
            bpy.ops.vdblic.make(wait=True)
            tell("volume", bpy.context.object.type)
            """)
        self.assertEqual(told["default"], ["STREAKS", "LINES"])
        self.assertEqual(told["first"][:2], ["CURVES", 4])
        self.assertGreater(told["first"][2], 20)
        name, lines, objects, curves, meshes, materials, caches, modifiers = told["again"]
        self.assertEqual((name, objects, curves, materials, modifiers), ("mine", 1, 1, 1, 1), told["again"])
        self.assertIn((meshes, caches), ((1, 0), (0, 1)))
        self.assertEqual(lines, len(read_lines(self.folder / "out/lines.0004.vdb")[0]["counts"]))
        self.assertTrue(10 < lines < told["first"][2])
        self.assertEqual(told["volume"], "VOLUME")


    def test_lines_of_a_domain_stand_in_it(self):
        cache = self.baked()
        told = self.drive(f"""
            from smoke_domain import bake
            settings = scene.vdblic
            box = bake({str(self.folder / "cache")!r}, 20, 6, {str(cache)!r})
            settings.source, settings.domain, settings.spacing = "DOMAIN", box, 3
            settings.refine, settings.folder = 3, {str(self.folder / "out")!r}
            bpy.ops.vdblic.make(wait=True)
            tell("place", [list(row) for row in bpy.context.object.matrix_world])
            """)
        # The domain's corner is at its lowest vertex; voxel i of the velocity begins i cells from it.
        size = numpy.array(vdb.read(str(cache / "data/fluid_data_0006.vdb"), "velocity").transform.voxelSize())
        turn = numpy.array(((numpy.cos(0.5), -numpy.sin(0.5), 0), (numpy.sin(0.5), numpy.cos(0.5), 0), (0, 0, 1)))
        corner = numpy.array((3, 1, 3)) + turn @ (-2, -2, -3)
        place = numpy.array(told["place"])
        numpy.testing.assert_allclose(place[:3, :3], turn, atol=1e-5)
        numpy.testing.assert_allclose(place[:3, 3], corner + turn @ (size / 2), atol=1e-5)
        self.assertNotIn("which hides it", self.output)


class DebiansBlender(Both, InDebiansBlender):
    pass


class CurrentBlender(Both, InCurrentBlender):
    pass


if __name__ == "__main__":
    unittest.main()
