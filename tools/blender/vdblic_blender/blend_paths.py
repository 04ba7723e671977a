"""Paths as Blender's files hold them."""

import os
import pathlib

import bpy


def absolute(path):
    """An absolute path; `//` is the folder of the .blend file. Raises ValueError where there is no such file."""
    if path.startswith("//") and not bpy.data.filepath:
        raise ValueError(
            f"{path}: it is relative to the .blend file, which is not saved yet; save it or choose another"
        )
    return str(pathlib.Path(os.path.normpath(os.path.expanduser(bpy.path.abspath(path)))))
