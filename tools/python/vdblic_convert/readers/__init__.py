"""Readers of flows. A reader is a `Source`: a file or a case that holds time steps.

Each module reads one family of files; it and the packages that it needs are loaded when such a file is opened.
"""

import importlib
import pathlib

from ..errors import InputError

READERS = {
    "vtk_files": (".vti", ".vtr", ".vts", ".vtu", ".vtm", ".vtk", ".pvti", ".pvtr", ".pvts", ".pvtu", ".pvd"),
    "cases": (".foam", ".case", ".encas", ".cgns"),
    "netcdf": (".nc", ".nc4", ".cdf"),
    "numpy_files": (".npy", ".npz"),
}


def open_source(path):
    """The reader of a file or of an OpenFOAM case's folder. Raises InputError."""
    path = pathlib.Path(path)
    if not path.exists():
        raise InputError(f"{path}: no such file")
    if path.is_dir() and not (path / "system" / "controlDict").is_file():
        raise InputError(
            f"{path}: it is a folder, but not an OpenFOAM case, which has system/controlDict; name a file or a "
            "pattern such as name.%04d.vti"
        )
    if path.is_file() and path.stat().st_size == 0 and path.suffix != ".foam":
        raise InputError(f"{path}: the file is empty")
    reader = (
        "cases"
        if path.is_dir()
        else next((r for r, endings in READERS.items() if path.suffix.lower() in endings), None)
    )
    if not reader and path.name.startswith("wrfout"):  # named by date
        reader = "netcdf"
    if not reader:
        known = " ".join(ending for endings in READERS.values() for ending in endings)
        raise InputError(
            f"{path}: files of this kind cannot be read; known are {known} and the folders of OpenFOAM cases"
        )
    return importlib.import_module(f".{reader}", __name__).open_source(path)


class Source:
    """A file or case that holds time steps.

    `times` has one number of seconds a step, None where it is unknown. `calendar` tells that they count from 1970 on,
    `unit` is the length's unit if it is known.
    """

    calendar = False
    unit = None

    def __init__(self, path, times):
        self.path = path
        self.times = times

    def velocity(self, step):  # pylint: disable=unused-argument
        """The arrays that the file itself declares to be the velocity, if it does."""
        return ()

    def arrays(self, step):
        """The arrays of a step: name → components."""
        raise NotImplementedError

    def read(self, step, names):
        """A VTK data set with the named arrays."""
        raise NotImplementedError

    def free(self):
        """Free the memory of a step that was read; it is read again when it is needed."""

    def notes(self):
        """What a user should be told about how the file is read."""
        return []
