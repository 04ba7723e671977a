"""Imports a sequence of volumes like the file browser, as a rule without a material, and renders frames of it.

    blender -b --factory-startup --python-exit-code 9 -t 1 --python show_sequence.py -- REQUEST.json

The request: `files`, in order; scene `frames` to render; the `window` of the world (x0, x1, z0, z1) that an
orthographic camera sees along +y; `pixels` a unit of length; `samples` a pixel; optionally a `grid`, whose values are
then the extinction, with a material for it. Outputs beside it: answer.json,
Blender's description of the volume and of each frame, and alpha.<frame>.npy, the opacity of each pixel by row from z0 up.
"""

import json
import math
import pathlib
import sys

import bpy
import numpy
from mathutils import Vector

request_path = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
request = json.loads(request_path.read_text())
files = [pathlib.Path(file) for file in request["files"]]
x0, x1, z0, z1 = request["window"]
width, height = (round((b - a) * request["pixels"]) for a, b in ((x0, x1), (z0, z1)))

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
bpy.ops.object.volume_import(
    filepath=str(files[0]), directory=str(files[0].parent), files=[{"name": file.name} for file in files])
volume = bpy.context.object
data = volume.data

if request["grid"]:
    material = bpy.data.materials.new("grid")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    values, absorption = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeVolumeAbsorption")
    values.attribute_name = request["grid"]
    absorption.inputs["Color"].default_value = (0, 0, 0, 1)
    links.new(values.outputs["Fac"], absorption.inputs["Density"])
    links.new(absorption.outputs["Volume"], nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
    data.materials.append(material)

lens = bpy.data.cameras.new("camera")
lens.type, lens.ortho_scale, lens.clip_end = "ORTHO", max(x1 - x0, z1 - z0), 1000
camera = bpy.data.objects.new("camera", lens)
camera.location = ((x0 + x1) / 2, -500, (z0 + z1) / 2)
camera.rotation_euler = (math.pi / 2, 0, 0)
scene.collection.objects.link(camera)
scene.camera = camera

scene.render.engine = "CYCLES"
scene.cycles.samples = request["samples"]
scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
scene.render.resolution_x, scene.render.resolution_y = width, height
scene.render.film_transparent = True
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.filepath = str(request_path.parent / "alpha.exr")


def look(frame):
    """Render a scene frame; returns Blender's description of the shown volume."""
    scene.frame_set(frame)
    data.grids.load()
    shown = volume.evaluated_get(bpy.context.evaluated_depsgraph_get())
    corners = [volume.matrix_world @ Vector(corner) for corner in shown.bound_box]
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    alpha = numpy.array(image.pixels, numpy.float32).reshape(height, width, 4)[..., 3]
    bpy.data.images.remove(image)
    numpy.save(request_path.parent / f"alpha.{frame}.npy", alpha)
    return {"file": pathlib.Path(data.grids.frame_filepath).name,
            "grids": data.grids.keys(),
            "error": data.grids.error_message,
            "low": [min(corner[axis] for corner in corners) for axis in range(3)],
            "high": [max(corner[axis] for corner in corners) for axis in range(3)]}


answer = {"is_sequence": data.is_sequence, "frame_start": data.frame_start, "frame_duration": data.frame_duration,
          "volumes": sum(thing.type == "VOLUME" for thing in scene.objects),
          "frames": {frame: look(frame) for frame in request["frames"]}}
(request_path.parent / "answer.json").write_text(json.dumps(answer))
