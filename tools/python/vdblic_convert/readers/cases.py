"""Cases of files that VTK reads, with time steps: OpenFOAM, EnSight, CGNS, Exodus, VTKHDF, Fluent and Tecplot."""

import re

from ..errors import InputError, needed
from ..vtk_data import arrays_of, blocks_of, check_cells, errors_of, merged, model
from . import ensight
from .vtk_files import VtkSource
from .whole_files import check_whole

OTHERS = dict.fromkeys((".e", ".ex2", ".exo"), ("vtkIOExodus", "vtkExodusIIReader")) | {
    ".vtkhdf": ("vtkIOHDF", "vtkHDFReader"),
    ".cas": ("vtkIOGeometry", "vtkFLUENTReader"),
    ".tec": ("vtkIOGeometry", "vtkTecplotReader"),
}


def open_source(path, options):  # pylint: disable=unused-argument
    if path.is_dir() or path.suffix.lower() == ".foam":
        return OpenFoamCase(path)
    if path.suffix.lower() == ".cgns":
        if check_whole(path) not in ("HDF5", "ADF"):  # its library would end the process
            raise InputError(f"{path}: cannot be read: it is neither of the forms of CGNS, HDF5 and ADF")
        return Case(path, needed("vtkmodules.vtkIOCGNSReader").vtkCGNSReader())
    if path.suffix.lower() in OTHERS:
        check_whole(path)
        module, name = OTHERS[path.suffix.lower()]
        kind = {".cas": FluentCase, ".tec": TecplotFile}.get(path.suffix.lower(), Case)
        return kind(path, getattr(needed(f"vtkmodules.{module}"), name)())
    return EnSightCase(path)


class Case(VtkSource):
    """A reader of VTK's with time steps; each step is read when it is asked for."""

    def __init__(self, path, reader, name=None):
        self._reader = reader
        set_name = reader.SetCaseFileName if reader.IsA("vtkGenericEnSightReader") else reader.SetFileName
        with errors_of(path):
            set_name(name or str(path))
            if reader.IsA("vtkExodusIIReader"):
                reader.UpdateInformation()
                for kind in reader.NODAL, reader.ELEM_BLOCK:
                    reader.SetAllArrayStatus(kind, 1)
            reader.UpdateInformation()
            if reader.IsA("vtkCGNSReader"):
                reader.EnableAllPointArrays()
                reader.EnableAllCellArrays()
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
            if time is None:
                self._reader.Update()
            else:
                self._reader.UpdateTimeStep(time)
        return self._reader.GetOutputDataObject(0)


class FluentCase(Case):
    """A case and its data. VTK would read a file that ends too early for ever."""

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
    """A text of one time. VTK takes zeros for values that are missing, and several times for parts of one."""

    def __init__(self, path, reader):
        text = re.sub(r"#.*", "", path.read_bytes().decode(errors="replace"))
        times = set(re.findall(r"SOLUTIONTIME\s*=\s*([-+\d.eE]+)", text, re.IGNORECASE))
        if not re.search(r"VARIABLES\s*=", text, re.IGNORECASE):
            raise InputError(f"{path}: it is no text of Tecplot with VARIABLES; save it as text")
        if len(times) > 1 or re.search("SHARE", text, re.IGNORECASE):
            raise InputError(f"{path}: zones of several times or with shared arrays are not read; save a file for each time")
        super().__init__(path, reader)
        names = re.search(r'VARIABLES\s*=\s*((?:"[^"]*"[\s,]*)+|[^\n]+)', text, re.IGNORECASE)[1]
        names = len(re.findall('"[^"]*"', names) or re.split(r"[\s,]+", names.strip()))
        found = sum(len(line.split()) for line in text.splitlines() if not re.search(r'[=")]|[A-CF-Za-cf-z]', line))
        needed_numbers = 0
        for block in blocks_of(self.read(0, ())):
            of_cells, cells = block.GetCellData().GetNumberOfArrays(), block.GetNumberOfCells()
            needed_numbers += (names - of_cells) * block.GetNumberOfPoints() + of_cells * cells
            if block.IsA("vtkUnstructuredGrid"):
                needed_numbers += block.GetCells().GetConnectivityArray().GetNumberOfValues()
        if found < needed_numbers and "*" not in text:
            raise InputError(f"{path}: it ends too early: {found} of {needed_numbers} numbers are there; copy it again")
        self.times = [float(time) for time in times] or [None]


class EnSightCase(Case):
    """A case of EnSight, whose text files are looked through before VTK reads them."""

    def __init__(self, path):
        self._files = ensight.Case(path)
        super().__init__(path, needed("vtkmodules.vtkIOEnSight").vtkGenericEnSightReader())

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
        if collated and not pieces and not whole - {0}:
            raise InputError(
                f"{path}: VTK cannot read the collated files in {collated.name}; put the case together first: "
                f"reconstructPar -case {folder}"
            )
        reader = needed("vtkmodules.vtkIOParallel").vtkPOpenFOAMReader()
        reader.SetController(needed("vtkmodules.vtkParallelCore").vtkDummyController())  # it crashes without one
        self._decomposed = bool(pieces) and not whole - {0}
        reader.SetCaseType(0 if self._decomposed else 1)
        reader.SkipZeroTimeOff()
        reader.CreateCellToPointOff()  # solid cells are merged first
        super().__init__(path, reader, str(folder / "system" / "controlDict"))
        for piece, times in pieces.items():
            lacking = set().union(*pieces.values()) - times
            if self._decomposed and lacking:
                self._notes.append(f"{path}: {piece} lacks the times {_listed(lacking)}, which are left out")
                self.times = [time for time in self.times if time not in lacking]
        if pieces and not self._decomposed and (lacking := set().union(*pieces.values()) - whole):
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
    """The times that a folder of OpenFOAM holds."""
    return {
        float(entry.name)
        for entry in folder.iterdir()
        if re.fullmatch(r"[\d.]+(e[+-]?\d+)?", entry.name) and entry.is_dir() and any(entry.iterdir())
    }


def _listed(times):
    shown = [f"{time:g}" for time in sorted(times)]
    return ", ".join(shown[:10]) + (" ..." if len(shown) > 10 else "")
