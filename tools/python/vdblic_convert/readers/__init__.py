"""Readers of flows. A reader is a `Source`: a file or a case that holds time steps.

Each module reads one family of files; it and the packages that it needs are loaded when such a file is opened.
"""

import importlib
import pathlib

from vdblic._core import Parsing

from ..errors import InputError, ParameterError

READERS = {
    "vtk_files": (
        *(".vti", ".vtr", ".vts", ".vtu", ".vtp", ".vtm", ".vthb", ".vth", ".vtk"),
        *(".pvti", ".pvtr", ".pvts", ".pvtu", ".pvtp", ".pvd", ".series"),
    ),
    "cases": (".foam", ".case", ".encas", ".cgns", ".vtkhdf", ".e", ".ex2", ".exo", ".cas", ".tec", ".q"),
    "dataset": (".nc", ".nc4", ".cdf", ".nc3", ".zarr", ".grib", ".grib1", ".grib2", ".grb", ".grb2"),
    "arrays": (".npy", ".npz", ".h5", ".hdf5", ".mat"),
}
REFUSED = {  # by the end of the name
    "Fluent's form in HDF5": (".cas.h5", ".dat.h5"),
    "Xdmf": (".xmf", ".xdmf"),
    "Tecplot's binary form": (".plt", ".szplt"),
    "Plot3D's grid without the solution (.q) before it": (".xyz", ".p3d"),
    "Nek5000": (".nek5000",),
    "Enzo": (".hierarchy",),
    "a list of EnSight's servers": (".sos",),
}


USUAL_CALENDARS = {"standard", "gregorian", "proleptic_gregorian"}
GRIDS = ".xyz", ".x", ".p3d"  # of Plot3D


def open_sources(paths, options):
    """The source of the files of one flow. A file without a flow gives the grid of the others."""
    found, grids = [pathlib.Path(path) for path in paths], []
    if len(found) > 1 and all(path.suffix.lower() in READERS["dataset"][:4] for path in found):
        from . import dataset

        grids = [path for path in found if path.is_file() and dataset.is_grid(path)]
    elif found[0].suffix.lower() == ".q":
        grids = [path for path in found if path.suffix.lower() in GRIDS]
    flows = [path for path in found if path not in grids]
    flows, grids = (flows, grids) if flows else (found, [])
    sources = [open_source(path, options, grids) for path in flows]
    known = [source.data for source in sources if hasattr(source, "data")]
    for name in set(options.attribute).difference(*(data.answered for data in known)):
        held = "; ".join(f"{data.path} has {data.contents()}" for data in known) or f"{flows[0]} has no attributes"
        raise ParameterError(f"--attribute {name}: there is no variable '{name}'; {held}")
    source = sources[0] if len(sources) == 1 else Joined(sources)
    source.paths = list(paths)
    return source


def open_source(path, options, grids=()):
    """The reader of a file, of a case's folder or of one of Zarr. Raises InputError.

    `options` are the tool's: `attribute`, `layout` and `dt` complete a file's metadata. `grids` are files of its grid.
    """
    refused = lambda why: InputError(f"{path}: {why}")
    path, folder = pathlib.Path(path), pathlib.Path(path).is_dir()
    if not path.exists():
        raise refused("no such file")
    if not folder and not path.is_file():
        raise refused("is no regular file; an input must be one")
    for kind, ends in REFUSED.items():
        if path.name.lower().endswith(ends):
            raise refused(f"{kind} is not read; ParaView's File > Save Data writes it as .vtm or .vtu")
    holds = lambda *names: any((path / name).is_file() for name in names)
    if folder and holds(".zgroup", ".zmetadata", "zarr.json") or path.name.startswith("wrfout"):  # named by date
        reader = "dataset"
    elif folder:
        reader = "cases"
        if not holds("system/controlDict", "Header"):
            raise refused(
                "it is a folder, but not an OpenFOAM case, which has system/controlDict, nor a plot file of AMReX nor "
                "Zarr; name a file or a pattern such as name.%04d.vti"
            )
    else:
        reader = next((r for r, endings in READERS.items() if path.suffix.lower() in endings), None)
    if not folder and path.suffix != ".foam":
        with open(path, "rb") as file:
            start = file.read(30)
        if not start:
            raise refused("the file is empty")
        if start.startswith(b"version https://git-lfs"):
            raise refused("it is a pointer of Git LFS to the file, which 'git lfs pull' fetches")
    if not reader:
        known = " ".join(ending for endings in READERS.values() for ending in endings)
        raise refused(f"files of this kind cannot be read; known are {known} and the folders of OpenFOAM cases")
    open_file = importlib.import_module(f".{reader}", __name__).open_source
    if reader == "dataset":  # has its own Parsing for each library
        return open_file(path, options, grids)
    with Parsing(path, "the library that reads it", False):
        return open_file(path, options, grids) if grids else open_file(path, options)


class Source:
    """A file or case that holds time steps.

    `times` has one number of seconds a step, None where it is unknown. `calendar` is the one by which they count from
    1970 on, if they do, `unit` is the length's unit if it is known. `explained` tells how each variable was understood.
    """

    calendar = False
    unit = None
    explained = {}
    middle = None  # longitude and latitude of the origin, if there is one

    def __init__(self, path, times):
        self.path = path
        self.paths = [path]
        self.times = times

    def components(self, step):  # pylint: disable=unused-argument
        """The arrays that the file itself declares to be the velocity along x, y and z; None where it does not."""
        return None, None, None

    def velocity(self, step):
        """The arrays that the file itself declares to be the velocity, if it does; the third may be missing."""
        x, y, z = self.components(step)
        return tuple(name for name in (x, y, z) if name) if x and y else ()

    def arrays(self, step):
        """The arrays of a step: name → components."""
        raise NotImplementedError

    def read(self, step, names):
        """A VTK data set with the named arrays."""
        raise NotImplementedError

    def parts(self, step, names, velocity=()):  # pylint: disable=unused-argument
        """VTK data sets that have the named arrays together, each with the names of its own.

        An array of three components may stand for one that `velocity` names: its share of the velocity.
        """
        return [(self.read(step, names), names)]

    def vector_of(self, name):  # pylint: disable=unused-argument
        """The kind of vector whose component along the grid's rows (0) or columns (1) a variable is; else None."""
        return None

    def free(self):
        """Free the memory of a step that was read; it is read again when it is needed."""

    def notes(self):
        """Messages for the user about the reading of the file."""
        return []


class Joined(Source):
    """Files that hold arrays of one flow, at the same times."""

    def __init__(self, sources):
        first, text = sources[0], lambda time: "no time" if time is None else f"{time:.15g} s"
        for other in sources[1:]:
            why = None
            if len(other.times) != len(first.times):
                counts = f"{len(other.times)} steps, {first.path} {len(first.times)}"
                why = f"it holds {counts}; files of one flow have the same"
            elif {first.calendar, other.calendar} - USUAL_CALENDARS and first.calendar != other.calendar:
                why = f"its calendar is {other.calendar or 'none'}, in {first.path} {first.calendar or 'none'}"
            for step, (a, b) in enumerate(zip(first.times, other.times)):
                if a != b and not why and (None in (a, b) or abs(a - b) > 1e-9 * max(abs(a), abs(b))):
                    times = f"{text(b)}, in {first.path} at {text(a)}"
                    why = f"step {step + 1} is at {times}; files of one flow have the same times"
            if why:
                raise InputError(f"{other.path}: {why}")
        super().__init__(first.path, first.times)
        self.paths = [path for source in sources for path in source.paths]
        self.calendar, self.unit, self._sources = first.calendar, first.unit, sources

    def components(self, step):
        found = [source.components(step) for source in self._sources]
        return tuple(next((names[axis] for names in found if names[axis]), None) for axis in range(3))

    @property
    def explained(self):
        return {name: text for source in self._sources for name, text in source.explained.items()}

    def arrays(self, step):
        return {name: count for source in reversed(self._sources) for name, count in source.arrays(step).items()}

    def parts(self, step, names, velocity=()):
        parts, left = [], list(names)
        for source in self._sources:
            source.middle = source.middle or self.middle
            own = [name for name in left if name in source.arrays(step)]
            parts += source.parts(step, own, velocity) if own else []
            left = [name for name in left if name not in own]
            self.middle = self.middle or source.middle
        return parts

    def free(self):
        for source in self._sources:
            source.free()

    def vector_of(self, name):
        return next((found for source in self._sources if (found := source.vector_of(name))), None)

    def notes(self):
        return [note for source in self._sources for note in source.notes()]
