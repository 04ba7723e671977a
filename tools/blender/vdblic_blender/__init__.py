"""VDBLIC in Blender: flow textures made, imported and shown.

A legacy add-on before Blender 4.2, an extension from then on.
"""

bl_info = {
    "name": "VDBLIC Flow Textures",
    "author": "VDBLIC",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Import; 3D View > Sidebar > VDBLIC",
    "description": "Flow textures of velocity volumes: made in the background, imported, shown",
    "category": "Import-Export",
}

import bpy
from bpy.app.handlers import persistent
from bpy.props import PointerProperty

from . import importing, lines, making, panels, preferences, showing

CLASSES = [cls for module in (preferences, importing, lines, showing, making, panels) for cls in module.CLASSES]


@persistent
def _look_again(*_):
    """A run goes on while files are opened and saved; the opened one may be its own."""
    making.start_watching()


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.vdblic = PointerProperty(type=making.VDBLIC_Settings)
    for module in importing, lines:
        bpy.types.TOPBAR_MT_file_import.append(module.menu)
    bpy.app.handlers.frame_change_pre.append(lines.follow)
    bpy.app.handlers.load_post.append(_look_again)


def unregister():
    if bpy.app.timers.is_registered(making.watch):
        bpy.app.timers.unregister(making.watch)
    bpy.app.handlers.load_post.remove(_look_again)
    bpy.app.handlers.frame_change_pre.remove(lines.follow)
    for module in importing, lines:
        bpy.types.TOPBAR_MT_file_import.remove(module.menu)
    del bpy.types.Scene.vdblic
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
