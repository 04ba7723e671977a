"""The panel in the sidebar, and the same in the properties of volumes."""

import bpy

from .jobs import DONE, FAILED, RUNNING, STOPPED
from .line_nodes import key_of, lines_modifier
from .making import job_of, problems
from .materials import flow_node


def draw_make(layout, context):
    settings = context.scene.vdblic
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(settings, "source")
    layout.prop(settings, "domain" if settings.source == "DOMAIN" else "velocity")
    layout.prop(settings, "method")
    if settings.method == "STREAKS":
        layout.prop(settings, "draw", expand=True)
        layout.prop(settings, "spacing")
    layout.prop(settings, "refine")
    layout.prop(settings, "mask")
    layout.prop(settings, "scene_range")
    if settings.method == "DENSE" or settings.draw == "VOLUME":
        layout.prop(settings, "motion_blur")
    layout.prop(settings, "look")
    layout.prop(settings, "folder")
    layout.operator("vdblic.estimate", icon="INFO")
    if settings.estimate:
        wrap(layout, settings.estimate, context)
    draw_job(layout, context, settings)


def draw_job(layout, context, settings):
    job = job_of(settings)
    state = job.state if job else ""
    if state == RUNNING:
        done = len(job.finished)
        if hasattr(layout, "progress"):  # from 4.0 on
            layout.progress(factor=done / max(job.total, 1), text=f"{done} of {job.total} frames")
        else:
            layout.label(text=f"{done} of {job.total} frames", icon="TIME")
        row = layout.row(align=True)
        row.operator("vdblic.cancel", icon="CANCEL")
        row.operator("vdblic.log", icon="TEXT")
        return
    layout.operator("vdblic.make", icon="PLAY", text="Go On" if state == STOPPED else "Make Flow Texture")
    if state == STOPPED:
        wrap(layout, f"Stopped after {len(job.finished)} of {job.total} frames", context)
    if state == DONE and settings.shown != job.output:
        layout.operator("vdblic.collect", icon="IMPORT")
    if state == FAILED:
        wrap(layout, job.message, context, "ERROR")
    for problem in problems():
        if state != FAILED:
            wrap(layout, problem, context, "ERROR")
    if state:
        layout.operator("vdblic.log", icon="TEXT")


def draw_show(layout, context):
    thing = context.object
    layout.use_property_split = True
    layout.use_property_decorate = False
    lines = lines_modifier(thing)
    if lines:
        layout.operator("vdblic.show_lines", icon="SHADING_RENDERED")
        for name in "Select", "Select By", "Least", "Thickness":
            layout.prop(lines, f'["{key_of(lines, name)}"]', text=name)
        layout.prop_search(lines, f'["{key_of(lines, "Box")}"]', bpy.data, "objects", text="Box")
    else:
        layout.operator("vdblic.show", icon="SHADING_RENDERED")
    node = flow_node(thing.data.materials[0] if thing.data.materials else None)
    if node:
        if not lines:
            layout.operator("vdblic.color_by", icon="COLOR")
        for socket in node.inputs:
            if not socket.is_linked:
                layout.prop(socket, "default_value", text=socket.name)
    layout.operator("vdblic.prepare_render", icon="RENDER_STILL")


def wrap(layout, text, context, icon="NONE"):
    """A text in as many lines as the panel is wide."""
    width = max(20, int(context.region.width / 8) if context.region else 40)
    column = layout.column(align=True)
    line = ""
    lines = []
    for word in text.split():
        if line and len(line) + len(word) + 1 > width:
            lines.append(line)
            line = word
        else:
            line = f"{line} {word}".strip()
    for i, part in enumerate([*lines, line]):
        column.label(text=part, icon=icon if i == 0 else "BLANK1" if icon != "NONE" else "NONE")


class VDBLIC_PT_make(bpy.types.Panel):
    bl_label = "Make Flow Texture"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "VDBLIC"

    def draw(self, context):
        draw_make(self.layout, context)


class _OfVolume:
    @classmethod
    def poll(cls, context):
        thing = context.object
        return thing is not None and (thing.type == "VOLUME" or lines_modifier(thing) is not None)

    def draw(self, context):
        draw_show(self.layout, context)


class VDBLIC_PT_show(_OfVolume, bpy.types.Panel):
    bl_label = "Show Flow Texture"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "VDBLIC"


class VDBLIC_PT_volume(_OfVolume, bpy.types.Panel):
    bl_label = "Flow Texture"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"


class VDBLIC_PT_volume_make(bpy.types.Panel):
    bl_label = "Make"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"
    bl_parent_id = "VDBLIC_PT_volume"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        draw_make(self.layout, context)


CLASSES = [VDBLIC_PT_make, VDBLIC_PT_show, VDBLIC_PT_volume, VDBLIC_PT_volume_make]
