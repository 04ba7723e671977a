"""Installs the add-on in a fresh Blender and runs a script with it, in Blender's background mode or with `bpy`.

    blender -b --factory-startup --python-exit-code 9 --python drive_addon.py -- ADDON.zip TOOLS SCRIPT.py
    python drive_addon.py -- ADDON.zip TOOLS SCRIPT.py                                  with Blender as a Python package

The script finds `bpy`, `scene`, `tell(name, value)`, which prints a line of JSON for the test, and `refused(operator,
**options)`, the message with which an operator refuses.
"""

import json
import os
import sys

import bpy

addon, tools, script = sys.argv[sys.argv.index("--") + 1 :]
bpy.ops.wm.read_factory_settings(use_empty=True)
if bpy.app.version >= (4, 2, 0):
    bpy.ops.extensions.package_install_files(filepath=addon, repo="user_default", enable_on_install=True)
    module = "bl_ext.user_default.vdblic_blender"
else:
    bpy.ops.preferences.addon_install(filepath=addon, overwrite=True)
    module = "vdblic_blender"
    bpy.ops.preferences.addon_enable(module=module)
bpy.context.preferences.addons[module].preferences.tools = tools
scene = bpy.context.scene


def tell(name, value):
    print("tell " + json.dumps([name, value]), flush=True)


def refused(operator, **options):
    try:
        operator(**options)
    except RuntimeError as error:
        return str(error).removeprefix("Error: ").strip()
    return ""


with open(script, encoding="utf-8") as file:
    code = compile(file.read(), script, "exec")
exec(code)
sys.stdout.flush()
if not bpy.app.binary_path:  # `bpy` may fail while the interpreter ends
    os._exit(0)
