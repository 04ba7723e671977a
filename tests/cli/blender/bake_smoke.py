"""Bakes a short smoke simulation to .vdb files, in Blender's own background mode.

    blender -b --factory-startup --python-exit-code 9 -t 1 --python bake_smoke.py -- FOLDER RESOLUTION FRAMES [DEPTH]

A hot ball rises in a box of 4 by 4 by 6 metres with its corner off the origin. RESOLUTION is the voxels along the
longest side, DEPTH (16 or 32) the bits of a number. Blender numbers the files FOLDER/data/fluid_data_0001.vdb and so on.
"""

import sys

import bpy

BOX = (4, 4, 6)
CENTRE = (1, 0, 3)

folder, resolution, frames, *depth = sys.argv[sys.argv.index("--") + 1:]

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.frame_start, scene.frame_end = 1, int(frames)


def fluid(add_mesh, kind, **placement):
    """A new mesh with a fluid modifier; returns its object and the modifier's settings."""
    add_mesh(**placement)
    thing = bpy.context.object
    modifier = thing.modifiers.new("Fluid", "FLUID")
    modifier.fluid_type = kind
    return thing, modifier.domain_settings if kind == "DOMAIN" else modifier.flow_settings


box, domain = fluid(bpy.ops.mesh.primitive_cube_add, "DOMAIN", size=1, location=CENTRE)
box.scale = BOX
domain.domain_type = "GAS"
domain.resolution_max = int(resolution)
domain.beta = 2  # buoyancy of heat: fast enough to matter in few frames
domain.cache_directory = folder
domain.cache_type = "ALL"
domain.cache_frame_start, domain.cache_frame_end = 1, int(frames)
domain.cache_data_format = "OPENVDB"
domain.openvdb_cache_compress_type = "NONE"
domain.openvdb_data_depth = depth[0] if depth else "16"

_, flow = fluid(bpy.ops.mesh.primitive_uv_sphere_add, "FLOW", radius=0.7, location=(1.2, 0, 1))
flow.flow_type = "SMOKE"
flow.flow_behavior = "INFLOW"
flow.use_initial_velocity = True
flow.velocity_coord = (0.5, 0, 2)

bpy.context.view_layer.objects.active = box
for _ in range(4):  # the first updates of a new fluid domain may raise without a display; later ones do not
    try:
        bpy.context.view_layer.update()
        break
    except SystemError:
        continue
if bpy.ops.fluid.bake_all() != {"FINISHED"}:
    raise RuntimeError("the simulation was not baked")
