"""Cases of files with time steps that VTK reads: OpenFOAM, EnSight and CGNS."""

import re

from ..errors import InputError, needed
from ..vtk_data import arrays_of, blocks_of, errors_of, merged, model
from . import Source, ensight
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
        return Case(path, getattr(needed(f"vtkmodules.{module}"), name)())
    return EnSightCase(path)


class Case(Source):
    """A reader of VTK's with time steps; each step is read when it is asked for."""

    def __init__(self, path, reader, name=None):
        self._reader = reader
        self._read = None, None  # the last step and its data
        set_name = reader.SetCaseFileName if reader.IsA("vtkGenericEnSightReader") else reader.SetFileName
        with errors_of(path):
            set_name(name or str(path))
            if reader.IsA("vtkExodusIIReader"):
                reader.UpdateInformation()
                for kind in reader.NODAL, reader.ELEM_BLOCK:
                    reader.SetAllArrayStatus(kind, 1)
            if reader.IsA("vtkCGNSReader"):
                reader.UpdateInformation()
                reader.EnableAllPointArrays()
                reader.EnableAllCellArrays()
            reader.UpdateInformation()
        key = needed("vtkmodules.vtkCommonExecutionModel").vtkStreamingDemandDrivenPipeline.TIME_STEPS()
        information = reader.GetOutputInformation(0)
        times = [information.Get(key, i) for i in range(information.Length(key))] if information.Has(key) else [None]
        super().__init__(path, times)

    def arrays(self, step):
        return arrays_of(self.read(step, ()))

    def read(self, step, names):
        if self._read[0] != step:
            self._read = None, None
            data = self._update(self.times[step])
            if not any(block.GetNumberOfCells() for block in blocks_of(data)):
                raise InputError(f"{self.path}: cannot be read, or it has no cells")
            self._read = step, data
        return self._read[1]

    def free(self):
        self._read = None, None

    def _update(self, time):
        """Let VTK read a time."""
        with errors_of(self.path):
            if time is None:
                self._reader.Update()
            else:
                self._reader.UpdateTimeStep(time)
        return self._reader.GetOutputDataObject(0)


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
        pieces = any(folder.glob("processor[0-9]*"))
        whole = any(
            re.fullmatch(r"[\d.]+(e[+-]?\d+)?", entry.name) and any(entry.iterdir())
            for entry in folder.iterdir()
            if entry.is_dir() and entry.name != "0"
        )
        collated = next(folder.glob("processors*"), None)
        if collated and not pieces and not whole:
            raise InputError(
                f"{path}: VTK cannot read the collated files in {collated.name}; put the case together first: "
                f"reconstructPar -case {folder}"
            )
        reader = needed("vtkmodules.vtkIOParallel").vtkPOpenFOAMReader()
        reader.SetController(needed("vtkmodules.vtkParallelCore").vtkDummyController())  # it crashes without one
        self._decomposed = pieces and not whole
        reader.SetCaseType(0 if self._decomposed else 1)
        reader.SkipZeroTimeOff()
        reader.CreateCellToPointOff()  # solid cells are merged first
        super().__init__(path, reader, str(folder / "system" / "controlDict"))
        if not self.times:
            raise InputError(f"{path}: the case has no times")

    def _update(self, time):
        self._reader.DisableAllPatchArrays()
        names = map(self._reader.GetPatchArrayName, range(self._reader.GetNumberOfPatchArrays()))
        for name in [name for name in names if name.endswith("internalMesh")]:  # one for each region
            self._reader.SetPatchArrayStatus(name, 1)
        data = super()._update(time)
        if not self._decomposed:
            return data
        cells = model.vtkMultiBlockDataSet()  # VTK puts the processors' cells together, but leaves their points apart
        for i, block in enumerate(block for block in blocks_of(data) if block.IsA("vtkUnstructuredGrid")):
            cells.SetBlock(i, merged([block], list(arrays_of(block))))
        return cells
