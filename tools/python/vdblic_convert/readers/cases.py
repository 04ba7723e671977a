"""Cases of files that VTK reads, with time steps: OpenFOAM, EnSight, CGNS, Exodus, VTKHDF, Fluent, Tecplot."""

import gzip
import re

from ..errors import InputError, needed
from ..vtk_data import arrays_of, blocks_of, check_cells, errors_of, merged, model
from . import ensight
from .vtk_files import VtkSource
from .whole_files import check_whole

READERS = dict.fromkeys((".e", ".ex2", ".exo"), "vtkIOExodus.vtkExodusIIReader") | {
    ".cgns": "vtkIOCGNSReader.vtkCGNSReader", ".vtkhdf": "vtkIOHDF.vtkHDFReader",
    ".cas": "vtkIOGeometry.vtkFLUENTReader", ".tec": "vtkIOGeometry.vtkTecplotReader",
    ".case": "vtkIOEnSight.vtkGenericEnSightReader",
    ".encas": "vtkIOEnSight.vtkGenericEnSightReader"}  # fmt: skip
MOST_LEVELS = 30  # of AMReX: all of them


def open_source(path, options, grids=()):  # pylint: disable=unused-argument
    kind = path.suffix.lower()
    if (path / "Header").is_file() or kind == ".q":
        from . import solver_files

        return solver_files.AmrexFile(path) if path.is_dir() else solver_files.Plot3dFile(path, grids)
    if path.is_dir() or kind == ".foam":
        return OpenFoamCase(path)
    if check_whole(path) not in ("HDF5", "ADF") and kind == ".cgns":  # its library would end the process
        raise InputError(f"{path}: cannot be read: it is neither of the forms of CGNS, HDF5 and ADF")
    case = {".cas": FluentCase, ".tec": TecplotFile, ".case": EnSightCase, ".encas": EnSightCase}.get(kind, Case)
    return case(path, reader_of(READERS[kind]))


def reader_of(name):
    module, _, reader = name.partition(".")
    return getattr(needed(f"vtkmodules.{module}"), reader)()


class Case(VtkSource):
    """A reader of VTK's with time steps; each step is read when it is asked for."""

    def __init__(self, path, reader, name=None):
        self._reader = reader
        names = {"vtkGenericEnSightReader": "CaseFileName", "vtkMultiBlockPLOT3DReader": "QFileName"}
        with errors_of(path):
            getattr(reader, "Set" + names.get(reader.GetClassName(), "FileName"))(name or str(path))
            reader.UpdateInformation()
            if reader.IsA("vtkExodusIIReader"):
                for kind in reader.NODAL, reader.ELEM_BLOCK:
                    reader.SetAllArrayStatus(kind, 1)
                reader.UpdateInformation()
            elif reader.IsA("vtkCGNSReader"):
                reader.EnableAllPointArrays()
                reader.EnableAllCellArrays()
            elif reader.IsA("vtkAMReXGridReader"):
                reader.SetMaxLevel(MOST_LEVELS)
                reader.GetCellDataArraySelection().EnableAllArrays()
        key = needed("vtkmodules.vtkCommonExecutionModel").vtkStreamingDemandDrivenPipeline.TIME_STEPS()
        information = reader.GetOutputInformation(0)
        times = [information.Get(key, i) for i in range(information.Length(key))] if information.Has(key) else [None]
        super().__init__(path, times, [])

    def load(self, step):
        data = self._update(self.times[step])
        if not any(block.GetNumberOfCells() for block in blocks_of(data)):
            raise InputError(f"{self.path}: cannot be read, or it has no cells")
        check_cells(data, self.path)
        return data

    def _update(self, time):
        """Let VTK read a time."""
        with errors_of(self.path):
            self._reader.Update() if time is None else self._reader.UpdateTimeStep(time)
        return self._reader.GetOutputDataObject(0)


class FluentCase(Case):
    """A case and its data. VTK's reader never ends on a truncated file."""

    def __init__(self, path, reader):
        for part in path, path.with_suffix(".dat"):
            if not part.is_file():
                raise InputError(f"{path}: its data are in {part.name}, which does not exist")
            text = re.sub(rb'"[^"]*"', b"", part.read_bytes()).rstrip()
            sections, ends = len(re.findall(rb"\([23]\d{3} ?\(", text)), text.count(b"End of Binary Section")
            if not text.endswith(b")") or sections != ends or not ends and text.count(b"(") != text.count(b")"):
                raise InputError(f"{part}: it ends too early; copy it again")
        super().__init__(path, reader)


class TecplotFile(Case):
    """A text of one time. VTK reads missing values as zeros, and several times as parts of one."""

    def __init__(self, path, reader):
        text = re.sub(r"#.*", "", path.read_bytes().decode(errors="replace"))
        times = set(re.findall(r"SOLUTIONTIME\s*=\s*([-+\d.eE]+)", text, re.IGNORECASE))
        names = re.search(r'VARIABLES\s*=\s*((?:"[^"]*"[\s,]*)+|[^\n]+)', text, re.IGNORECASE)
        if not names:
            raise InputError(f"{path}: it is no text of Tecplot with VARIABLES; save it as text")
        if len(times) > 1 or re.search("SHARE", text, re.IGNORECASE):
            raise InputError(f"{path}: zones of several times or with shared arrays are not read; save a file for each time")
        super().__init__(path, reader)
        names = len(re.findall('"[^"]*"', names[1]) or re.split(r"[\s,]+", names[1].strip()))
        found = sum(len(line.split()) for line in text.splitlines() if not re.search(r'[=")]|[A-CF-Za-cf-z]', line))
        wanted = 0
        for block in blocks_of(self.read(0, ())):
            of_cells = block.GetCellData().GetNumberOfArrays()
            wanted += (names - of_cells) * block.GetNumberOfPoints() + of_cells * block.GetNumberOfCells()
            if block.IsA("vtkUnstructuredGrid"):
                wanted += block.GetCells().GetConnectivityArray().GetNumberOfValues()
        if found < wanted and "*" not in text:
            raise InputError(f"{path}: it ends too early: {found} of {wanted} numbers are there; copy it again")
        self.times = [float(time) for time in times] or [None]


class EnSightCase(Case):
    """A case of EnSight, whose text files are looked through before VTK reads them."""

    def __init__(self, path, reader):
        self._files = ensight.Case(path)
        super().__init__(path, reader)

    def _update(self, time):
        self._files.check(time)
        return super()._update(time)


class OpenFoamCase(Case):
    """The cells of an OpenFOAM case, as one piece or decomposed into processor folders. Patches are left out."""

    unit = "m"

    def __init__(self, path):
        folder = path if path.is_dir() else path.parent
        if not (folder / "system" / "controlDict").is_file():
            raise InputError(f"{path}: the folder {folder} is no OpenFOAM case; it lacks system/controlDict")
        whole, pieces = _times(folder), {piece.name: _times(piece) for piece in sorted(folder.glob("processor[0-9]*"))}
        collated = next(folder.glob("processors*"), None)
        if collated and not pieces and not whole.keys() - {0}:
            raise InputError(
                f"{path}: VTK cannot read the collated files in {collated.name}; put the case together first: "
                f"reconstructPar -case {folder}"
            )
        reader = reader_of("vtkIOParallel.vtkPOpenFOAMReader")
        reader.SetController(reader_of("vtkParallelCore.vtkDummyController"))  # it crashes without one
        self._decomposed = bool(pieces) and not whole.keys() - {0}
        self._folders = list(pieces.values()) if self._decomposed else [whole]
        reader.SetCaseType(0 if self._decomposed else 1)
        reader.SkipZeroTimeOff()
        reader.CreateCellToPointOff()  # solid cells are merged first
        super().__init__(path, reader, str(folder / "system" / "controlDict"))
        every = set().union(*pieces.values())
        for piece, times in pieces.items():
            if self._decomposed and (lacking := every - times.keys()):
                self._notes.append(f"{path}: {piece} lacks the times {_listed(lacking)}, which are left out")
                self.times = [time for time in self.times if time not in lacking]
        if pieces and not self._decomposed and (lacking := every - whole.keys()):
            self._notes.append(
                f"{path}: the times {_listed(lacking)} are in processor folders only and are left out; reconstructPar "
                "puts them together"
            )
        regions = [name.rpartition("/")[0].strip("/") for name in self._meshes()]
        if len(regions) > 1:
            self._notes.append(f"{path}: the regions that have the velocity are one flow, of {', '.join(regions)}")
        if not self.times:
            raise InputError(f"{path}: the case has no times")

    def _meshes(self):
        """The names of the regions' cells."""
        names = map(self._reader.GetPatchArrayName, range(self._reader.GetNumberOfPatchArrays()))
        return [name for name in names if name.endswith("internalMesh")]

    def _update(self, time):
        for times in self._folders:
            _check_objects(times.get(time))
        self._reader.DisableAllPatchArrays()
        for name in self._meshes():
            self._reader.SetPatchArrayStatus(name, 1)
        data = super()._update(time)
        if not self._decomposed:
            return data
        cells = model.vtkMultiBlockDataSet()  # VTK puts the processors' cells together, but leaves their points apart
        for i, block in enumerate(block for block in blocks_of(data) if block.IsA("vtkUnstructuredGrid")):
            cells.SetBlock(i, merged([block], list(arrays_of(block))))
        return cells


def _times(folder):
    """The times that a folder of OpenFOAM holds, and their folders."""
    is_time = lambda entry: re.fullmatch(r"[\d.]+(e[+-]?\d+)?", entry.name) and entry.is_dir() and any(entry.iterdir())
    return {float(entry.name): entry for entry in folder.iterdir() if is_time(entry)}


def _check_objects(folder):
    """Raise InputError where two files of a time say that they are one field: VTK would take either."""
    found = {}
    for path in sorted(folder.rglob("*")) if folder else ():
        if path.is_file():
            with (gzip.open if path.suffix == ".gz" else open)(path, "rb") as file:
                name = re.search(rb"FoamFile[^}]*?\bobject\s+([^;\s]+)", file.read(3000))
            other = found.setdefault((path.parent, name and name[1]), path)
            if name and other is not path:
                told = name[1].decode(errors="replace")
                raise InputError(f"{path}: it says that it is {told}, as {other.name} does; move one of them away")


def _listed(times):
    shown = [f"{time:g}" for time in sorted(times)]
    return ", ".join(shown[:10]) + (" ..." if len(shown) > 10 else "")
