"""AMReX's plot files and Plot3D, whose files are checked because VTK's readers trust their numbers."""

import re

import numpy

from ..errors import InputError
from ..vtk_data import GHOSTS, HIDDEN_POINT, add_array, array, blocks_of, bridge
from . import GRIDS
from .cases import Case, reader_of


class AmrexFile(Case):
    """A folder with the cells of one time, in levels of boxes."""

    def __init__(self, path):
        try:
            _check_plot_file(path)
        except (ValueError, IndexError, OSError, TypeError, AttributeError) as error:
            if isinstance(error, InputError):
                raise
            why = f": {error}" if isinstance(error, (ValueError, OSError)) else ""
            raise InputError(f"{path}: cannot be read as a plot file of AMReX{why}; copy it again") from None
        super().__init__(path, reader_of("vtkIOAMR.vtkAMReXGridReader"))


def _check_plot_file(path):
    """Raise an error if a part of a plot file is missing, or is none that VTK reads as it is meant."""
    lines = (path / "Header").read_text(encoding="ascii", errors="replace").split("\n")
    count = int(lines[1])
    dimension, levels = int(lines[2 + count]), int(lines[4 + count]) + 1
    coordinates = int(lines[10 + count + levels])
    if coordinates or dimension != 3:
        kind = "cylindrical or spherical" if coordinates else f"of {dimension} dimensions"
        raise InputError(f"{path}: its coordinates are {kind}; AMReX is read in x, y and z only")
    folders = [line.rpartition("/")[0] for line in lines if re.fullmatch(r"\S+/Cell", line)]
    if len(folders) != levels:
        raise ValueError(f"its Header tells of {levels} levels, and of the folders of {len(folders)}")
    for folder in folders:
        text = (path / folder / "Cell_H").read_text(encoding="ascii", errors="replace")
        places = re.findall(r"^FabOnDisk: (\S+) (\d+)\s*$", text, re.MULTILINE)
        if len(places) != int(re.search(r"^\((\d+) ", text, re.MULTILINE)[1]):
            raise ValueError(f"{folder}/Cell_H ends too early")
        for name, place in places:
            with open(path / folder / name, "rb") as file:
                file.seek(int(place))
                head = file.readline(1000).decode("ascii", "replace")
                width, box, parts = re.fullmatch(r"FAB \(\(8, \((\d+) .*\)\)\((.*)\) (\d+)\s", head).groups()
                corners = [numpy.array(part.split(","), int) for part in re.findall(r"\(([-\d,]+)\)", box)]
                wanted = int(width) // 8 * int(parts) * int(numpy.prod(corners[1] - corners[0] + 1.0))
                left = file.seek(0, 2) - int(place) - len(head)
            if left < wanted:
                raise ValueError(f"{folder}/{name} ends too early: {left} of {wanted} bytes are there")


class Plot3dFile(Case):
    """A solution and its grid. The flow is momentum by density; points that the grid marks by 0 are hidden."""

    def __init__(self, path, grids):
        beside = (path.with_suffix(ending) for ending in GRIDS)
        grid = next(filter(type(path).is_file, (*grids, *beside)), None)
        if grid is None:
            mend = f"name it: vdblic_import {path} GRID.xyz"
            raise InputError(f"{path}: its grid is not beside it in {path.stem}.xyz; {mend}")
        for part in path, grid:
            with open(part, "rb") as file:
                start = file.read(64)
            if start and start.isascii() and b"\0" not in start:
                raise InputError(f"{part}: the text of Plot3D does not tell the order of its numbers; save it in binary")
        reader = reader_of("vtkIOParallel.vtkMultiBlockPLOT3DReader")
        reader.AutoDetectFormatOn()
        reader.SetXYZFileName(str(grid))
        reader.SetScalarFunctionNumber(-1)
        reader.SetVectorFunctionNumber(200)  # the velocity
        super().__init__(path, reader)
        self.times = [None]  # that of the file has no unit
        self._notes.append(f"{path}: the velocity is momentum by density, in the unit of the solver's numbers")

    def load(self, step):
        data = super().load(step)
        for block in blocks_of(data):
            if block.GetPointData().GetArray("IBlank"):
                hidden = numpy.where(array(block, "IBlank")[0] == 0, HIDDEN_POINT, 0)
                add_array(block.GetPointData(), GHOSTS, hidden.astype(numpy.uint8))
        return data
