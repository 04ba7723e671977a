"""The scene that the add-on leaves: something to see on this frame, in the views, once, and no rest of earlier tries."""

import unittest

import numpy
import pyopenvdb as vdb

from test_blender_addon import InCurrentBlender, InDebiansBlender

VIEWS = (
    "views = [space for screen in bpy.data.screens for area in screen.areas for space in area.spaces "
    'if space.type == "VIEW_3D"]'
)


class Both:
    """What both Blenders do."""

    helpers = VIEWS

    def test_what_is_imported_is_seen_and_told(self):
        (file, _) = self.textures(frames="7-8")
        told = self.drive(f"""
            tell("known", len(views))
            bpy.ops.mesh.primitive_cube_add(size=20, location=(0, 0, 0))
            scene.frame_set(1)
            bpy.ops.vdblic.import_sequence(filepath={str(file)!r})
            tell("frame", scene.frame_current)
            tell("views", [[*view.region_3d.view_location, view.region_3d.view_distance] for view in views])
            scene.frame_set(40)
            bpy.ops.vdblic.import_sequence(filepath={str(file)!r})
            tell("late", scene.frame_current)
            scene.frame_set(8)
            bpy.ops.vdblic.import_sequence(filepath={str(file)!r})
            tell("there", scene.frame_current)
            """)
        self.assertEqual([told["frame"], told["late"], told["there"]], [7, 8, 8])
        self.assertGreater(told["known"], 0)
        for *centre, distance in told["views"]:
            numpy.testing.assert_allclose(centre, (0.65, 1.15, 0.65), atol=0.06)  # of voxels (-3, 4, 1) to (16, 19, 12)
            self.assertTrue(2 < distance < 8, distance)
        self.assertRegex(self.output, r"Info: lic: 1\.9 x 1\.5 x 1\.1 units, frames 7 to 8")
        self.assertRegex(self.output, "Warning: lic: it stands inside Cube, which hides it")

    def test_materials_that_are_replaced_go(self):
        (file,) = self.textures(frames="1-1")
        told = self.drive(f"""
            bpy.ops.vdblic.import_sequence(filepath={str(file)!r})
            for look in "INK", "PAPER", "FLOW":
                bpy.ops.vdblic.show(look=look)
            tell("left", [len(bpy.data.materials), len(bpy.data.node_groups)])
            kept = bpy.context.object.data.materials[0]
            bpy.ops.vdblic.import_sequence(filepath={str(file)!r}, material=False)
            bpy.context.object.data.materials.append(kept)
            bpy.ops.vdblic.show()
            tell("shared", [len(bpy.data.materials), len(bpy.data.node_groups)])
            """)
        self.assertEqual((told["left"], told["shared"]), ([1, 1], [2, 2]))

    def test_make_again_replaces_what_it_made(self):
        self.textures("velocities", "1-2")
        told = self.drive(f"""
            settings = scene.vdblic
            settings.source, settings.velocity = "FILES", {str(self.folder / "velocities/v.0001.vdb")!r}
            settings.method, settings.folder = "DENSE", {str(self.folder / "out")!r}
            bpy.ops.vdblic.make(wait=True)
            volume = bpy.context.object
            volume.name = "mine"
            settings.refine = 2
            bpy.ops.vdblic.make(wait=True)
            tell("left", [len(scene.objects), len(bpy.data.volumes), len(bpy.data.materials), bpy.context.object.name])
            volume.data.grids.load()
            tell("size", max(abs(x) for x in volume.data.grids["density"].matrix_object[0][:3]))
            """)
        self.assertEqual(told["left"], [1, 1, 1, "mine"])
        if self.bakes:
            self.assertAlmostEqual(told["size"], 0.05, places=6)
        else:  # which keeps what it read for as long as it runs
            self.assertIn("until it is started anew", self.output)

    def test_opacity_follows_a_grid_of_its_own(self):
        """A full texture with q from 0 to 15 along x, seen from the front: only what is above 8 is seen."""
        grids = []
        x = numpy.indices((16, 16, 16))[0].astype(numpy.float32)
        for name, values in ("density", numpy.ones_like(x)), ("magnitude", x[::-1] + 1), ("q", x):
            grid = vdb.FloatGrid()
            grid.name, grid.transform = name, vdb.createLinearTransform(0.1)
            grid.copyFromArray(values)
            grids.append(grid)
        vdb.write(str(self.folder / "full.vdb"), grids=grids)
        told = self.drive(f"""
            import math, numpy
            bpy.ops.vdblic.import_sequence(filepath={str(self.folder / "full.vdb")!r}, material=False)
            bpy.ops.vdblic.show(opacity_by="q", clear=8)
            node = bpy.context.object.data.materials[0].node_tree.nodes["Flow"]
            tell("colours", bpy.context.object.data.materials[0].node_tree.nodes["Scalar"].attribute_name)
            bpy.ops.vdblic.color_by(scalar="density")
            tell("gate", [node.inputs["Clear"].default_value, node.inputs["Solid"].default_value])
            tell("refused", refused(bpy.ops.vdblic.show, opacity_by="p"))
            lens = bpy.data.cameras.new("lens")
            lens.type, lens.ortho_scale = "ORTHO", 1.6
            camera = bpy.data.objects.new("lens", lens)
            camera.location, camera.rotation_euler = (0.75, -5, 0.75), (math.pi / 2, 0, 0)
            scene.collection.objects.link(camera)
            scene.camera = camera
            bpy.ops.vdblic.prepare_render()
            scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 16, "CPU"
            scene.render.resolution_x = scene.render.resolution_y = 16
            scene.render.film_transparent = True
            scene.render.image_settings.file_format = "OPEN_EXR"
            scene.render.filepath = {str(self.folder / "full.exr")!r}
            bpy.ops.render.render(write_still=True)
            pixels = numpy.array(bpy.data.images.load(scene.render.filepath).pixels).reshape(16, 16, 4)
            tell("alpha", pixels[8, :, 3].tolist())
            """)
        self.assertEqual(told["colours"], "magnitude")
        self.assertAlmostEqual(told["gate"][0], 8)
        self.assertAlmostEqual(told["gate"][1], 15, delta=1)
        self.assertIn("no grid 'p' of numbers; it has density, magnitude, q", told["refused"])
        self.assertEqual(max(told["alpha"][:7]), 0, told["alpha"])
        self.assertGreater(min(told["alpha"][13:]), 0.3, told["alpha"])

    def test_eevee_draws_the_volume_for_camera_and_views(self):
        (file,) = self.textures(frames="1-1")
        told = self.drive(f"""
            from mathutils import Vector
            bpy.ops.vdblic.import_sequence(filepath={str(file)!r})
            volume = bpy.context.object
            camera = bpy.data.objects.new("lens", bpy.data.cameras.new("lens"))
            camera.location = 0.6, 1.2, 3
            scene.collection.objects.link(camera)
            scene.camera = camera
            bpy.context.view_layer.update()
            for i, view in enumerate(views):
                view.region_3d.view_location = volume.matrix_world @ Vector(volume.bound_box[0])
                view.region_3d.view_distance = 20 + i
            bpy.ops.vdblic.prepare_render()
            near = (camera.matrix_world.inverted() @ volume.matrix_world @ Vector(volume.bound_box[6])).z
            eevee = scene.eevee
            tell("range", [eevee.volumetric_start, -near, 19 + len(views), eevee.volumetric_end])
            tell("custom", getattr(eevee, "use_volume_custom_range", True))
            """)
        start, near, far, end = told["range"]
        if told["custom"]:
            self.assertTrue(0 < start <= near < 3 and 20 < far <= end, told["range"])
        self.assertEqual(told["custom"], self.bakes)


class DebiansBlender(Both, InDebiansBlender):
    pass


class CurrentBlender(Both, InCurrentBlender):
    pass


if __name__ == "__main__":
    unittest.main()
