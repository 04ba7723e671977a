"""The add-on in Debian's Blender and in a current one (`bpy`): import, make, show, and what goes wrong.

Up to 4.5 Blender draws the value of voxel i at i + 1/2, from 5.0 on at i, so a volume is in its place where its object
moves that point to OpenVDB's; test_a_picture_is_where_openvdb_has_the_values looks at the picture itself.
"""

import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import textwrap
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, ToolTest, peer, skip

HERE = pathlib.Path(__file__).parent
ADDON = BIN / "vdblic_blender.zip"
if not ADDON.exists():
    skip("the add-on is not built")
UNIT = [[0.1, 0, 0, 0], [0, 0.1, 0, 0], [0, 0, 0.1, 0], [0, 0, 0, 1]]
BPY = peer("bpy", "bpy")
PLACE = """
def place(volume, index, grid="density"):
    from mathutils import Vector
    volume.data.grids.load()
    bpy.context.view_layer.update()
    beside = 0.5 if bpy.app.version < (5, 0, 0) else 0
    drawn = volume.data.grids[grid].matrix_object @ (Vector(index) + Vector((beside,) * 3))
    return list(volume.matrix_world @ drawn)
"""


class AddonTest(ToolTest):
    """Scripts with the add-on and `helpers`; a subclass says in which Blender."""

    helpers = PLACE

    def command(self, *words):
        raise NotImplementedError

    @classmethod
    def setUpClass(cls):
        home = tempfile.TemporaryDirectory(prefix="vdblic-home-")
        cls.addClassCleanup(home.cleanup)
        cls.home = home.name

    def drive(self, script, tools=BIN, status=0, **options):
        """What a script tells, by name; `output` has all that Blender prints."""
        path = self.folder / "script.py"
        path.write_text(
            f"import sys\nsys.path.insert(0, {str(HERE / 'blender')!r})\n{self.helpers}\n{textwrap.dedent(script)}",
            encoding="utf-8",
        )
        words = self.command(HERE / "blender/drive_addon.py", "--", ADDON, tools, path)
        environment = os.environ | {"HOME": self.home, "XDG_CONFIG_HOME": f"{self.home}/.config"}
        done = subprocess.run(
            list(map(str, words)), text=True, capture_output=True, timeout=300, env=environment, **options
        )
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        self.output = done.stdout
        lines = [json.loads(line[5:]) for line in done.stdout.splitlines() if line.startswith("tell ")]
        return dict(lines)

    def textures(self, folder="", frames="1-4", rows=UNIT, refine=1, metadata=None, options=()):
        """Textures of a swirl; returns the files."""
        (self.folder / folder).mkdir(exist_ok=True)
        x, y, z = numpy.meshgrid(*(numpy.arange(n, dtype=numpy.float32) for n in (20, 16, 12)), indexing="ij")
        grid = vdb.Vec3SGrid()
        grid.name, grid.transform = "velocity", vdb.createLinearTransform(rows)
        grid.copyFromArray(numpy.stack([8 - y, x - 10, 2 + 0 * z], axis=-1), ijk=(-3, 4, 1))
        first, last = map(int, frames.split("-"))
        for frame in range(first, last + 1):
            vdb.write(str(self.folder / folder / f"v.{frame:04}.vdb"), grids=[grid], metadata=metadata or {})
        return self.outputs(
            "vdblic_advect",
            f"{folder or '.'}/v.%04d.vdb",
            "-o",
            f"{folder or '.'}/lic.%04d.vdb",
            "--velocity-unit",
            "voxel/frame",
            "--velocity-scale",
            "0.2",
            "--refine",
            refine,
            "--preroll",
            0,
            *options,
        )

    baked_cache = None

    def baked(self):
        """A smoke cache baked by Debian's Blender, once."""
        if AddonTest.baked_cache is None:
            if not shutil.which("blender"):
                self.skipTest("Blender is missing, whose package bakes the smoke")
            folder = tempfile.TemporaryDirectory(prefix="vdblic-cache-")
            AddonTest.baked_cache = folder
            subprocess.run(
                [
                    "blender",
                    "-b",
                    "--factory-startup",
                    "-t",
                    "1",
                    "--python-exit-code",
                    "9",
                    "--python",
                    HERE / "blender/bake_smoke.py",
                    "--",
                    folder.name,
                    "20",
                    "6",
                ],
                check=True,
                capture_output=True,
            )
        return pathlib.Path(AddonTest.baked_cache.name)


@unittest.skipUnless(shutil.which("blender"), "Blender is missing")
class InDebiansBlender(AddonTest):
    bakes = True

    def command(self, script, *words):
        return ["blender", "-b", "--factory-startup", "-t", "1", "--python-exit-code", "9", "--python", script, *words]


@unittest.skipIf(BPY is None, "bpy is missing: tests/peers.sh gets it")
class InCurrentBlender(AddonTest):
    bakes = False  # smoke_domain.py says why

    def command(self, script, *words):
        return [BPY, script, *words]


class Both:
    """What both Blenders do."""

    def test_a_sequence_is_imported_where_and_when_it_is(self):
        c, s = 0.08, 0.06
        rows = [[c, 0, -s, 0], [0, 0.1, 0, 0], [s, 0, c, 0], [-0.3, 5, 0.2, 1]]
        files = self.textures("Träger raum", "12-14", rows, refine=2)
        told = self.drive(f"""
            bpy.ops.vdblic.import_sequence(filepath={str(files[1])!r}, set_range=True)
            volume = bpy.context.object
            tell("range", [scene.frame_start, scene.frame_end, len(scene.objects)])
            shown = []
            for frame in 11, 12, 14, 15:
                scene.frame_set(frame)
                volume.data.grids.load()
                shown.append(volume.data.grids.frame_filepath if volume.data.grids.is_loaded else "")
            tell("files", shown)
            scene.frame_set(12)
            tell("place", place(volume, (7, 11, 5)))
            node = volume.data.materials[0].node_tree.nodes["Flow"]
            tell("inputs", {{socket.name: socket.default_value for socket in node.inputs}})
            tell("group", node.node_tree.name)
            bpy.ops.vdblic.color_by(scalar="density")
            tell("scalar", volume.data.materials[0].node_tree.nodes["Scalar"].attribute_name)
            tell("refused", refused(bpy.ops.vdblic.color_by, scalar="q"))
            bpy.ops.vdblic.show(kind="STREAKS")
            node = volume.data.materials[0].node_tree.nodes["Flow"]
            tell("streaks", [node.node_tree.name, node.inputs["Begin"].default_value])
            """)
        self.assertEqual(told["range"], [12, 14, 1])
        self.assertEqual(
            [path.endswith(name) for path, name in zip(told["files"][1:3], ("lic.0012.vdb", "lic.0014.vdb"))],
            [True, True],
            told["files"],
        )
        expected = vdb.read(str(files[0]), "density").transform.indexToWorld((7.0, 11.0, 5.0))
        numpy.testing.assert_allclose(told["place"], expected, atol=0.01 * 0.05)
        self.assertTrue(told["group"].startswith("VDBLIC Dense"))
        speeds = vdb.read(str(files[0]), "magnitude")
        highest = numpy.zeros((20, 16, 12), numpy.float32)
        speeds.copyToArray(highest, ijk=(-3, 4, 1))
        self.assertAlmostEqual(told["inputs"]["To"] / numpy.percentile(highest, 99), 1, delta=0.15)
        self.assertEqual(told["scalar"], "density")
        self.assertIn("no grid 'q' of numbers; it has density, magnitude", told["refused"])
        group, begin = told["streaks"]
        self.assertTrue(group.startswith("VDBLIC Streaks"))
        self.assertAlmostEqual(begin, 0.1, places=6)

    def test_what_cannot_be_shown_is_told_and_adds_nothing(self):
        (file,) = self.textures(frames="1-1")
        for frame in 1, 2, 4:
            shutil.copy(file, self.folder / f"gap.{frame:04}.vdb")
        for name in "mixed.1.vdb", "mixed.02.vdb", "mixed.03.vdb":
            shutil.copy(file, self.folder / name)
        mirrored = vdb.read(str(file), "density")
        mirrored.transform = vdb.createLinearTransform([[-0.1, 0, 0, 0], [0, 0.1, 0, 0], [0, 0, 0.1, 0], [0, 0, 0, 1]])
        vdb.write(str(self.folder / "mirrored.vdb"), grids=[mirrored])
        arrows = vdb.Vec3SGrid()
        arrows.name = "streaks"
        arrows.fill((0, 0, 0), (4, 4, 4), (1, 0, 0))
        vdb.write(str(self.folder / "lines.vdb"), grids=[arrows], metadata={"texture": "streaks"})
        (self.folder / "cut.vdb").write_bytes(file.read_bytes()[:2000])
        (self.folder / "empty.vdb").write_bytes(b"")
        wrong = {
            "gap.0002.vdb": "frame 3 is missing",
            "mixed.02.vdb": "numbers of different widths",
            "mirrored.vdb": "is mirrored, which Blender draws blank",
            "lines.vdb": "'streaks' has no voxels of numbers; if it has lines, import the layer",
            "cut.vdb": "no whole .vdb file",
            "empty.vdb": "no whole .vdb file",
            "none.vdb": "no such file",
            "script.py": "not a .vdb file",
        }
        told = self.drive(f"""
            for name in {list(wrong)!r}:
                tell(name, [refused(bpy.ops.vdblic.import_sequence, filepath={str(self.folder)!r} + "/" + name),
                            len(scene.objects), len(bpy.data.volumes), len(bpy.data.materials)])
            """)
        for name, words in wrong.items():
            message, *things = told[name]
            self.assertIn(words, message)
            self.assertIn(name.partition(".")[0], message)
            self.assertEqual((message.count("\n"), things), (0, [0, 0, 0]), message)

    def test_mixed_transforms_y_up_and_many_frames(self):
        coarse = self.textures("coarse", "1-2", refine=4)
        (up,) = self.textures("up", "1-1", metadata={"creator": "Houdini/GEO_VDBTranslator"})
        (self.folder / "many").mkdir()
        for frame in range(1, 501):
            os.link(coarse[0], self.folder / f"many/lic.{frame:04}.vdb")
        told = self.drive(f"""
            bpy.ops.vdblic.import_sequence(filepath={str(self.folder / "many/lic.0250.vdb")!r}, material=False)
            data = bpy.context.object.data
            tell("many", [data.frame_start, data.frame_duration])
            bpy.ops.vdblic.import_sequence(filepath={str(coarse[0])!r}, material=False)
            bpy.ops.vdblic.import_sequence(filepath={str(up)!r}, material=False)
            tell("up", place(bpy.context.object, (2, 5, 9)))
            bpy.ops.vdblic.import_sequence(filepath={str(up)!r}, material=False, up="Z", half=False)
            tell("as_is", [list(row) for row in bpy.context.object.matrix_world])
            """)
        self.assertEqual(told["many"], [1, 500])
        numpy.testing.assert_allclose(told["up"], (0.2, -0.9, 0.5), atol=0.001)
        numpy.testing.assert_allclose(told["as_is"], numpy.eye(4))

    def test_a_baked_domain_is_made_cancelled_resumed_and_rendered(self):
        folder = self.folder / "Träger raum"
        folder.mkdir()
        cache = None if self.bakes else str(self.baked())
        told = self.drive(f"""
            import time
            from smoke_domain import bake
            making = next(module for name, module in sys.modules.items() if name.endswith("vdblic_blender.making"))
            box = bake({str(folder / "cache")!r}, 20, 6, {cache!r})
            bpy.ops.wm.save_as_mainfile(filepath={str(folder / "szene.blend")!r})
            settings = scene.vdblic
            settings.source, settings.domain, settings.method, settings.refine = "DOMAIN", box, "DENSE", 8
            bpy.ops.vdblic.estimate()
            tell("estimate", settings.estimate)
            bpy.ops.vdblic.make()
            job = making.job_of(settings)
            while job.state == "RUNNING" and len(job.finished) < 2:
                time.sleep(0.01)
            bpy.ops.vdblic.cancel()
            while job.state == "RUNNING":
                time.sleep(0.01)
            tell("cancelled", [job.state, len(job.finished)])
            bpy.ops.wm.save_mainfile()
            bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
            scene = bpy.context.scene
            bpy.ops.vdblic.make(wait=True)
            job = making.job_of(scene.vdblic)
            tell("made", [job.state, len(job.finished), scene.vdblic.shown == job.output])
            bpy.ops.vdblic.log()
            tell("log", bpy.data.texts["vdblic.log"].as_string())
            volume = bpy.context.object
            scene.frame_set(6)
            tell("place", place(volume, (64, 64, 30)))
            tell("kind", volume.data.materials[0].name)

            from mathutils import Vector
            for name in "Smoke box", "Sphere":
                scene.objects[name].hide_render = True
            lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "SUN"))
            lens = bpy.data.objects.new("lens", bpy.data.cameras.new("lens"))
            lamp.data.energy = 8
            scene.collection.objects.link(lamp)
            scene.collection.objects.link(lens)
            lens.location = volume.matrix_world @ Vector((2, -9, 1.5))
            lens.rotation_euler = (Vector((3, 1, 1.5)) - lens.location).to_track_quat("-Z", "Y").to_euler()
            scene.camera = lens
            bpy.ops.vdblic.prepare_render()
            tell("settings", [scene.cycles.volume_step_rate, getattr(scene.cycles, "volume_biased", False)])
            scene.render.engine, scene.cycles.samples = "CYCLES", 4
            scene.cycles.device = "CPU"
            scene.render.film_transparent = True
            scene.render.resolution_x, scene.render.resolution_y = 96, 72
            scene.render.filepath = {str(folder / "bild.png")!r}
            bpy.ops.render.render(write_still=True)
            module = [name for name in bpy.context.preferences.addons.keys() if name.endswith("vdblic_blender")][0]
            bpy.ops.preferences.addon_disable(module=module)
            tell("gone", [hasattr(bpy.types.Scene, "vdblic"), hasattr(bpy.types, "VDBLIC_PT_make")])
            """)
        self.assertRegex(
            told["estimate"], r"6 frames, 0\.\d+ million voxels: [\d.]+ [MG]iB of memory, [\d.]+ s of processor time"
        )
        state, count = told["cancelled"]
        self.assertEqual(state, "STOPPED")
        self.assertTrue(2 <= count < 6, count)
        self.assertEqual(told["made"], ["DONE", 6, True])
        self.assertIn("textures are done", told["log"])  # it went on
        self.assertEqual(told["settings"], [1, False])
        self.assertTrue(told["kind"].startswith("VDBLIC Dense"))
        # The domain's corner is at its lowest vertex; voxel f of the texture begins f / 8 cells from it.
        size = numpy.array(vdb.read(str(folder / "cache/data/fluid_data_0006.vdb"), "velocity").transform.voxelSize())
        x, y, z = (numpy.array((64, 64, 30)) + 0.5) / 8 * size
        turn = numpy.array(((numpy.cos(0.5), -numpy.sin(0.5), 0), (numpy.sin(0.5), numpy.cos(0.5), 0), (0, 0, 1)))
        corner = numpy.array((3, 1, 3)) + turn @ (-2, -2, -3)
        numpy.testing.assert_allclose(told["place"], corner + turn @ (x, y, z), atol=0.01 * size[0] / 8)
        self.assertEqual(told["gone"], [False, False])
        picture = subprocess.run(["oiiotool", "--stats", folder / "bild.png"], text=True, capture_output=True).stdout
        averages = [float(x) for x in picture.partition("Stats Avg:")[2].split()[:4]]
        self.assertGreater(averages[3], 255 * 0.01, picture)  # covered
        self.assertGreater(max(averages[:3]), 1, picture)  # and lit

    def test_a_picture_is_where_openvdb_has_the_values(self):
        """The centre of a round cloud in a picture from the front."""
        index = numpy.stack(numpy.meshgrid(*[numpy.arange(24)] * 3, indexing="ij"), axis=-1)
        centre, size = numpy.array((11.0, 12, 10)), 0.2
        values = numpy.exp(-(((index - centre) / 3) ** 2).sum(axis=-1)).astype(numpy.float32)
        grid = vdb.FloatGrid()
        grid.name, grid.transform = "density", vdb.createLinearTransform(voxelSize=size)
        grid.copyFromArray(numpy.where(values < 1e-3, 0, values))
        vdb.write(str(self.folder / "cloud.vdb"), grids=[grid])
        told = self.drive(f"""
            import math, numpy
            bpy.ops.vdblic.import_sequence(filepath={str(self.folder / "cloud.vdb")!r}, material=False)
            data = bpy.context.object.data
            material = bpy.data.materials.new("cloud")
            material.use_nodes = True
            nodes, links = material.node_tree.nodes, material.node_tree.links
            nodes.clear()
            density, absorption = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeVolumeAbsorption")
            density.attribute_name = "density"
            absorption.inputs["Color"].default_value = (0, 0, 0, 1)
            links.new(density.outputs["Fac"], absorption.inputs["Density"])
            links.new(absorption.outputs["Volume"], nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
            data.materials.append(material)
            lens = bpy.data.cameras.new("lens")
            lens.type, lens.ortho_scale, lens.clip_end = "ORTHO", 4.8, 1000
            camera = bpy.data.objects.new("lens", lens)
            camera.location, camera.rotation_euler = (2.4, -50, 2.4), (math.pi / 2, 0, 0)
            scene.collection.objects.link(camera)
            scene.camera = camera
            scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 32, "CPU"
            scene.cycles.use_denoising = False
            scene.render.resolution_x = scene.render.resolution_y = 72
            scene.render.film_transparent = True
            scene.render.image_settings.file_format = "OPEN_EXR"
            scene.render.filepath = {str(self.folder / "cloud.exr")!r}
            bpy.ops.render.render(write_still=True)
            pixels = numpy.array(bpy.data.images.load(scene.render.filepath).pixels).reshape(72, 72, 4)
            depth = -numpy.log(1 - pixels[..., 3].clip(0, 0.999))
            at = (numpy.arange(72) + 0.5) / 15
            tell("centre", [float((depth @ at).sum() / depth.sum()), float((at @ depth).sum() / depth.sum())])
            """)
        numpy.testing.assert_allclose(told["centre"], centre[[0, 2]] * size, atol=0.05 * size)

    def test_a_mask_and_motion_blur(self):
        """Textures inside a mesh, or in its box where Blender's Python has no OpenVDB; their velocity is found."""
        self.textures("velocities", "1-2")
        told = self.drive(f"""
            bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(0.6, 1.2, 0.7))
            settings = scene.vdblic
            settings.source, settings.velocity = "FILES", {str(self.folder / "velocities/v.0001.vdb")!r}
            settings.method, settings.motion_blur, settings.mask = "DENSE", True, bpy.context.object
            settings.folder = {str(self.folder / "out")!r}
            bpy.ops.vdblic.make(wait=True)
            volume = bpy.context.object.data
            tell("velocity", [volume.velocity_grid, volume.velocity_unit, volume.velocity_scale])
            tell("blur", scene.render.use_motion_blur)
            tell("material", [material.name for material in volume.materials])
            tell("tools", any(__import__("importlib").util.find_spec(name) for name in ("openvdb", "pyopenvdb")))
            """)
        grid = vdb.read(str(self.folder / "out/lic.0002.vdb"), "density")
        places = [grid.transform.indexToWorld(tuple(map(float, item.min))) for item in grid.citerOnValues()]
        far = numpy.abs(numpy.array(places) - (0.6, 1.2, 0.7))
        self.assertLess(far.max(), 0.51)
        self.assertGreater(far.max(), 0.4)
        self.assertEqual(numpy.linalg.norm(far, axis=1).max() < 0.51, told["tools"])
        self.assertEqual((told["velocity"][:2], told["blur"]), (["vel", "SECOND"], True))
        self.assertEqual(len(told["material"]), 1)
        self.assertAlmostEqual(told["velocity"][2], 1, places=5)  # 1/24 s between the files, and in the scene

    def test_what_goes_wrong_while_making_is_told(self):
        self.textures("velocities", "1-3")
        old = self.folder / "old"
        old.mkdir()
        for name in "vdblic_advect", "vdblic_info":
            (old / name).write_text("#!/bin/sh\necho 9.1.0\n")
            (old / name).chmod(0o755)
        told = self.drive(f"""
            import resource
            from smoke_domain import bake
            preferences = bpy.context.preferences.addons[module].preferences
            settings = scene.vdblic
            count = len(scene.objects)
            settings.folder = {str(self.folder / "out")!r}
            def problem(name, **changes):
                for key, value in changes.items():
                    setattr(settings, key, value)
                tell(name, [refused(bpy.ops.vdblic.make, wait=True), len(bpy.data.volumes)])
            tell("tools", refused(bpy.ops.vdblic.test_tools))
            problem("no domain", source="DOMAIN")
            problem("no velocity", source="FILES")
            problem("no file", velocity={str(self.folder / "none.0001.vdb")!r})
            problem("unsaved", velocity={str(self.folder / "velocities/v.0001.vdb")!r}, folder="//vdblic")
            settings.folder = {str(self.folder / "out")!r}
            problem("bad data", velocity={str(self.folder / "velocities/lic.0001.vdb")!r})
            preferences.tools = {str(old)!r}
            problem("old", velocity={str(self.folder / "velocities/v.0001.vdb")!r})
            preferences.tools = {str(self.folder / "nowhere")!r}
            problem("missing")
            preferences.tools = {str(BIN)!r}
            box = bake({str(self.folder / "unbaked")!r}, 12, 4, "")
            problem("not baked", source="DOMAIN", domain=box)
            resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
            import signal
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            problem("full", source="FILES", refine=6)
            """)
        self.assertEqual(told.pop("tools"), "")
        wrong = {
            "no domain": "no domain: choose a Mantaflow smoke domain",
            "no velocity": "choose any file of a sequence",
            "no file": "no such file",
            "unsaved": "not saved yet",
            "bad data": "lic.0001.vdb",
            "old": "version 9.1.0, but the add-on is",
            "missing": "not found in",
            "not baked": "Smoke box: not baked",
            "full": "File too large",
        }
        self.assertEqual(told.keys(), wrong.keys())
        for name, words in wrong.items():
            message, volumes = told[name]
            self.assertIn(words, message, name)
            self.assertEqual((message.count("\n"), volumes), (0, 0), message)


class DebiansBlender(Both, InDebiansBlender):
    pass


class CurrentBlender(Both, InCurrentBlender):
    pass


if __name__ == "__main__":
    unittest.main()
