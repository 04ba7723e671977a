"""A smoke domain off the origin, turned and scaled, whose cache is baked: for scripts of drive_addon.py."""

import shutil

import bpy


def bake(folder, resolution, frames, baked=None):
    """Returns the domain object. The ball rises in a box of 4 by 4 by 6 units, turned by half a radian.

    @param baked  a cache to copy in place of baking; empty: none. The modifiers are then switched off: the Mantaflow of
    the package `bpy` 5.0.1 ends the process
    """
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames
    bpy.ops.mesh.primitive_cube_add(size=1, location=(3, 1, 3))
    box = bpy.context.object
    box.name, box.scale, box.rotation_euler.z = "Smoke box", (4, 4, 6), 0.5
    domain = _fluid(box, "DOMAIN", baked is None).domain_settings
    domain.domain_type = "GAS"
    domain.resolution_max, domain.beta = resolution, 2
    domain.cache_directory = folder
    domain.cache_type = "ALL"
    domain.cache_frame_start, domain.cache_frame_end = 1, frames
    domain.cache_data_format = "OPENVDB"
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.7, location=(3.2, 1, 1))
    flow = _fluid(bpy.context.object, "FLOW", baked is None).flow_settings
    flow.flow_type, flow.flow_behavior = "SMOKE", "INFLOW"
    flow.use_initial_velocity, flow.velocity_coord = True, (0.5, 0, 2)
    bpy.context.object.hide_render = True
    bpy.context.view_layer.objects.active = box
    for _ in range(4):  # the first updates of a new fluid domain may raise without a display; later ones do not
        try:
            bpy.context.view_layer.update()
            break
        except SystemError:
            continue
    if baked is None and bpy.ops.fluid.bake_all() != {"FINISHED"}:
        raise RuntimeError("the simulation was not baked")
    if baked:
        shutil.copytree(baked, folder, dirs_exist_ok=True)
    return box


def _fluid(thing, kind, is_on):
    modifier = thing.modifiers.new("Fluid", "FLUID")
    modifier.show_viewport = modifier.show_render = is_on
    modifier.fluid_type = kind
    return modifier
