"""Our tools on this machine: where they are, and whether they are of the add-on's version."""

import os
import pathlib
import re
import shutil
import subprocess

VERSION = "1.0.0"
NEEDED = ("vdblic_advect", "vdblic_info")
SECONDS = 20


class ToolError(RuntimeError):
    """A tool that is missing, of another version, or that failed; the message tells the mend."""


def find_tool(name, folder=""):
    """The path of a tool, in a folder or on PATH. Raises ToolError."""
    found = shutil.which(name, path=os.path.expanduser(folder)) if folder else shutil.which(name)
    if not found:
        where = folder or "on PATH"
        raise ToolError(
            f"{name}: not found {'in ' if folder else ''}{where}; name the folder of the tools in the "
            "add-on's preferences"
        )
    return found


def version_of(path):
    """The version of a tool. Raises ToolError."""
    try:
        done = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=SECONDS)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ToolError(f"{path}: cannot be run: {error}; install the tools anew") from None
    found = re.search(r"\d+\.\d+(\.\d+)?", done.stdout)
    if done.returncode or not found:
        raise ToolError(f"{path}: it does not tell its version; it is not one of our tools, name another folder")
    return found[0]


def check_tools(folder=""):
    """Check that the tools exist and have the add-on's version; returns the ones found. Raises ToolError."""
    paths = [find_tool(name, folder) for name in NEEDED]
    for path in paths:
        version = version_of(path)
        if version.split(".")[:2] != VERSION.split(".")[:2]:
            raise ToolError(
                f"{path}: version {version}, but the add-on is {VERSION}; install tools and add-on of one " "version"
            )
    return f"{VERSION}, in {pathlib.Path(paths[0]).parent}"


def last_error(text):
    """The message of a failed tool: its last line with an error, else its last line."""
    lines = [line for line in re.split(r"[\r\n]+", text) if line.strip() and not line.endswith(" lists the options.")]
    errors = [line for line in lines if ": error: " in line] or lines
    return re.sub(r"^(vdblic_\w+): (error: )?", r"\1: ", errors[-1]) if errors else "no message"


def run_tool(name, words, folder="", timeout=600):
    """Run a tool to its end; returns its standard output. Raises ToolError with its message."""
    path = find_tool(name, folder)
    try:
        done = subprocess.run([path, *words], capture_output=True, text=True, timeout=timeout)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ToolError(f"{path}: cannot be run: {error}") from None
    if done.returncode:
        raise ToolError(last_error(done.stderr))
    return done.stdout
