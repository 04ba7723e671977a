"""A run of vdblic_advect in the background, which outlives Blender.

The folder of the textures holds what is known of the run: `vdblic.job.json` (command, process), `vdblic.log` (its
messages), `vdblic.paths` (the files so far) and, when it has ended, `vdblic.status`. So another Blender, or the same
one after a file was opened, finds it again.
"""

import json
import os
import pathlib
import shlex
import signal
import subprocess

from .tools import last_error

RUNNING, DONE, STOPPED, FAILED = "RUNNING", "DONE", "STOPPED", "FAILED"
# The shell waits for the tools, which get the signals of the group itself, and leaves its status.
_SHELL = 'trap : TERM; eval "$2"; echo $? > "$1"'
_children = []


class JobError(RuntimeError):
    """A run that cannot start; the message names the mend."""


class Job:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        try:
            self._told = json.loads(self._file("job.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            self._told = {}

    @classmethod
    def start(cls, folder, commands, total, output, layer=""):
        """Begin a run. Raises JobError.

        @param commands  each a tool and words: the one that tells its files, and those that follow it
        @param total  number of frames  @param output, layer  what is shown at its end: a pattern, a layer of lines
        """
        job = cls(folder)
        if job.state == RUNNING:
            raise JobError(f"{folder}: a run is already going on there; cancel it or choose another folder")
        try:
            job.folder.mkdir(parents=True, exist_ok=True)
            for name in "status", "paths":
                job._file(name).unlink(missing_ok=True)
            first, *others = map(shlex.join, commands)
            script = " && ".join([first, *(f"{other} >&2" for other in others)])
            told = {"command": script, "total": total, "output": output, "layer": layer}
            job._write(told | {"process": 0, "born": 0})
            with open(job._file("paths"), "wb") as paths, open(job._file("log"), "wb") as log:
                shell = ["/bin/sh", "-c", _SHELL, "sh", str(job._file("status")), script]
                child = subprocess.Popen(
                    shell, stdin=subprocess.DEVNULL, stdout=paths, stderr=log, start_new_session=True
                )
        except OSError as error:
            raise JobError(
                f"{folder}: a run cannot be begun: {error.strerror}; free space or choose another " "folder"
            ) from None
        _children.append(child)
        job._write(told | {"process": child.pid, "born": _birth(child.pid)})
        return job

    @property
    def is_known(self):
        return bool(self._told)

    @property
    def output(self):
        """The pattern of the textures."""
        return self._told.get("output", "")

    @property
    def layer(self):
        """The layer of the lines, or nothing."""
        return self._told.get("layer", "")

    @property
    def total(self):
        return self._told.get("total", 0)

    @property
    def command(self):
        return self._told.get("command", "")

    @property
    def log(self):
        return self._file("log")

    @property
    def finished(self):
        """The textures so far."""
        try:
            return self._file("paths").read_text(encoding="utf-8", errors="replace").splitlines()
        except OSError:
            return []

    @property
    def state(self):
        if not self._told:
            return ""
        status = self._status()
        if status is None:
            return RUNNING if self._is_alive() else STOPPED
        return DONE if status == 0 else STOPPED if status > 128 else FAILED

    @property
    def message(self):
        """Why the run failed, in the tool's words."""
        try:
            return last_error(self.log.read_text(encoding="utf-8", errors="replace"))
        except OSError:
            return "no message"

    def cancel(self):
        """Ask the run to stop after the file that it writes; it leaves a checkpoint."""
        if self.state == RUNNING and self._told.get("process"):
            os.killpg(self._told["process"], signal.SIGTERM)

    def _file(self, name):
        return self.folder / f"vdblic.{name}"

    def _write(self, told):
        self._told = told
        part = self._file("job.part")
        part.write_text(json.dumps(told), encoding="utf-8")
        part.replace(self._file("job.json"))

    def _status(self):
        try:
            return int(self._file("status").read_text())
        except (OSError, ValueError):
            return None

    def _is_alive(self):
        for child in _children[:]:
            if child.poll() is not None:
                _children.remove(child)
        process = self._told.get("process", 0)
        return process > 0 and self._told.get("born") == _birth(process)


def _birth(process):
    """When a process began, in the system's ticks; None if there is no such process."""
    try:
        text = pathlib.Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return None
    fields = text.rpartition(")")[2].split()
    return None if fields[0] == "Z" else int(fields[19])
