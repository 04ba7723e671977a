"""Preferences: where the tools are."""

import bpy
from bpy.props import StringProperty

from .tools import ToolError, check_tools

_session = {"folder": ""}  # where Blender runs the add-on without its preferences, as a farm's script may


def tools_folder():
    addon = bpy.context.preferences.addons.get(__package__)
    return (addon.preferences.tools if addon and addon.preferences else "") or _session["folder"]


class VDBLIC_Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    tools: StringProperty(
        name="Folder of the Tools",
        subtype="DIR_PATH",
        description="Folder that holds vdblic_advect and vdblic_info; empty: they are on PATH",
    )

    def draw(self, context):
        self.layout.prop(self, "tools")
        self.layout.operator("vdblic.test_tools")


class VDBLIC_OT_test_tools(bpy.types.Operator):
    """Find the tools and check that they are of the add-on's version"""

    bl_idname = "vdblic.test_tools"
    bl_label = "Test the Tools"

    folder: StringProperty(name="Folder", subtype="DIR_PATH", description="Use this folder from now on in this session")

    def execute(self, context):
        if self.folder:
            _session["folder"] = self.folder
        try:
            found = check_tools(tools_folder())
        except ToolError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"the tools are there: {found}")
        return {"FINISHED"}


CLASSES = [VDBLIC_Preferences, VDBLIC_OT_test_tools]
