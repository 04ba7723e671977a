"""VTK's data sets: their arrays, their cells of three dimensions, and the errors of VTK's readers."""

import contextlib
import re

import numpy

from .errors import InputError, needed

core = needed("vtkmodules.vtkCommonCore")
model = needed("vtkmodules.vtkCommonDataModel")
filters = needed("vtkmodules.vtkFiltersCore")
extraction = needed("vtkmodules.vtkFiltersExtraction")
bridge = needed("vtkmodules.util.numpy_support")

core.vtkSMPTools.SetBackend("Sequential")  # threads would race where several cells have a point: other bytes each time

GHOSTS = "vtkGhostType"
DUPLICATE_CELL, HIDDEN_POINT, REFINED_CELL, HIDDEN_CELL = 1, 2, 8, 32
RESIDUE = "residue of "
KEPT = "cells that are kept"
WEDGE = 13  # VTK's number of the cell type

VTK_ERROR = r"(ERROR|Warning): In [^,]*, line \d+ (?:vtk\w+ \([^)]*\): )?(.*?)(?=ERROR: |Warning: |Generic Warning: |$)"


@contextlib.contextmanager
def errors_of(path):
    """Turn VTK's printed errors into an InputError about a file."""
    core.vtkLogger.SetStderrVerbosity(core.vtkLogger.VERBOSITY_OFF)
    window = core.vtkStringOutputWindow()
    before = core.vtkOutputWindow.GetInstance()
    core.vtkOutputWindow.SetInstance(window)
    try:
        yield
    finally:
        core.vtkOutputWindow.SetInstance(before)
    text = window.GetOutput()
    text = text.decode(errors="replace") if isinstance(text, bytes) else text  # not UTF-8: bytes
    text = re.sub(r"\s+", " ", "".join(char if char.isprintable() else " " for char in text))
    for kind, message in re.findall(VTK_ERROR, text):
        if kind == "ERROR" or message.startswith("Error"):  # some readers only warn of files that end too early
            raise InputError(f"{path}: cannot be read: {message[:200].strip()}")


def output_of(algorithm, dataset):
    """The output of a VTK filter for a data set."""
    algorithm.SetInputData(dataset)
    algorithm.Update()
    return algorithm.GetOutput()


def arrays_of(dataset):
    """The numeric arrays of a data set or of its blocks: name → components."""
    found = {}
    for block in blocks_of(dataset):
        for data in block.GetPointData(), block.GetCellData():
            for i in range(data.GetNumberOfArrays()):
                array = data.GetArray(i)  # None for texts
                if array is not None and array.GetName() and array.GetName() != GHOSTS:
                    found.setdefault(array.GetName(), array.GetNumberOfComponents())
    return found


def blocks_of(dataset):
    """The data sets in a data set: itself, or the blocks of a multi-block."""
    if dataset is None:
        return []
    if not dataset.IsA("vtkCompositeDataSet"):
        return [dataset] if dataset.IsA("vtkDataSet") else []
    blocks, iterator = [], dataset.NewIterator()
    while not iterator.IsDoneWithTraversal():
        blocks.append(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    return [block for block in blocks if block.IsA("vtkDataSet")]


def check_cells(dataset, path):
    """Raise InputError where a cell has a corner that is not there: VTK would end the process."""
    for block in blocks_of(dataset):
        if block.IsA("vtkUnstructuredGrid") and block.GetNumberOfCells():
            last = bridge.vtk_to_numpy(block.GetCells().GetConnectivityArray()).max(initial=0)
            if last >= block.GetNumberOfPoints():
                raise InputError(f"{path}: cannot be read: a cell has point {last} of {block.GetNumberOfPoints()}")


def having(dataset, names):
    """The blocks that have all the named arrays."""
    data = lambda block, name: block.GetPointData().GetArray(name) or block.GetCellData().GetArray(name)
    return [block for block in blocks_of(dataset) if all(data(block, name) for name in names)]


def solid(dataset, names, path):
    """One data set of the cells of three dimensions, else of a plane, with all named arrays.

    Raises InputError if there are none.
    """
    own = [_without(block, REFINED_CELL) for block in having(dataset, names)]
    found = [cells for block in own if (cells := _cells_of(block, 3))]
    found = found or [cells for block in own if flat_axis(block) is not None and (cells := _cells_of(block, 2))]
    if not found:
        raise InputError(f"{path}: no cells of three dimensions, nor of a plane, have {', '.join(names)}")
    if len(found) == 1 and not found[0].IsA("vtkPolyData"):
        return found[0]
    of_points = {name for name in names for block in found if array(block, name)[1]}
    return merged([at_points(block, of_points) for block in found], names)


def flat_axis(block):
    """The axis that a plane lies across; None for other blocks."""
    bounds = numpy.array(block.GetBounds()).reshape(3, 2)
    lengths = bounds[:, 1] - bounds[:, 0]
    flat = int(numpy.argmin(lengths))
    return flat if lengths[flat] <= 1e-6 * lengths.max() and (numpy.delete(lengths, flat) > 0).all() else None


def merged(blocks, names):
    """One unstructured grid of blocks, with coincident points merged and duplicate cells of other blocks removed.

    So means over the cells around a point cross the borders of blocks.
    """
    blocks = [_without(block, DUPLICATE_CELL) for block in blocks]
    merge, grid = needed("vtkmodules.vtkFiltersGeneral").vtkMergeCells(), model.vtkUnstructuredGrid()
    merge.SetUnstructuredGrid(grid)
    merge.SetTotalNumberOfDataSets(len(blocks))
    merge.SetTotalNumberOfPoints(sum(block.GetNumberOfPoints() for block in blocks))
    merge.SetTotalNumberOfCells(sum(block.GetNumberOfCells() for block in blocks))
    merge.SetPointMergeTolerance(0.0)
    merge.SetOutputPointsPrecision(1)
    for block in blocks:  # with the same arrays: others are lost
        alike = block.NewInstance()
        alike.CopyStructure(block)
        points, cells = (block.GetPointData(), alike.GetPointData()), (block.GetCellData(), alike.GetCellData())
        for name in names:
            values, of_points = array(block, name)
            add_array((points if of_points else cells)[1], name, values.astype(float))
        for (data, own), count in (points, alike.GetNumberOfPoints()), (cells, alike.GetNumberOfCells()):
            flags = data.GetArray(GHOSTS)
            add_array(own, GHOSTS, numpy.zeros(count, numpy.uint8) if flags is None else bridge.vtk_to_numpy(flags))
        cells = filters.vtkAppendFilter()  # for merging ends the process where blocks are of several kinds
        cells.SetOutputPointsPrecision(1)
        merge.MergeDataSet(output_of(cells, alike))
    merge.Finish()
    return grid


def _without(block, flag):
    """A block without the cells that have a flag, such as cells that another block refines."""
    kept = cell_flags(block) & flag == 0
    if kept.all():
        return block
    marked, chosen = shallow_copy(block), filters.vtkThreshold()
    add_array(marked.GetCellData(), KEPT, kept.astype(numpy.uint8))
    chosen.SetInputArrayToProcess(0, 0, 0, model.vtkDataObject.CELL, KEPT)
    chosen.SetLowerThreshold(1)
    return output_of(chosen, marked)


def cell_flags(block):
    """VTK's flags of the cells; 0 without any."""
    flags = block.GetCellData().GetArray(GHOSTS)
    return numpy.zeros(1, numpy.uint8) if flags is None else bridge.vtk_to_numpy(flags)


def array(dataset, name):
    """The values of an array, one row a point or a cell, and whether it belongs to the points."""
    for data, of_points in (dataset.GetPointData(), True), (dataset.GetCellData(), False):
        if data.GetArray(name) is not None:
            return bridge.vtk_to_numpy(data.GetArray(name)), of_points
    raise KeyError(name)


def add_array(data, name, values):
    """Add values, one row a point or a cell, to point or cell data."""
    added = bridge.numpy_to_vtk(numpy.ascontiguousarray(values), deep=True)
    added.SetName(name)
    data.AddArray(added)


def at_points(dataset, names):
    """The data set with the named arrays at its points. Arrays of cells become means over the cells around a point.

    Means interpolated back to a cell's middle differ from its value, most of all at a rim. The difference stays with
    the cells, as an array RESIDUE and the name.
    """
    of_cells = [name for name in names if dataset.GetPointData().GetArray(name) is None]
    if not of_cells:
        return dataset
    mean, back = filters.vtkCellDataToPointData(), filters.vtkPointDataToCellData()
    mean.ProcessAllArraysOff()
    back.ProcessAllArraysOff()
    for name in of_cells:
        mean.AddCellDataArray(name)
        back.AddPointDataArray(name)
    result = output_of(mean, dataset)
    found = output_of(back, result).GetCellData()
    for name in of_cells:
        lack = array(dataset, name)[0] - bridge.vtk_to_numpy(found.GetArray(name))
        add_array(result.GetCellData(), RESIDUE + name, lack)
    return result


def cell_sizes(grid):
    """The volumes, or areas in a plane, of an unstructured grid's cells, and their lengths along the axes (cells, 3)."""
    sizes = output_of(needed("vtkmodules.vtkFiltersVerdict").vtkCellSizeFilter(), grid)
    volumes = abs(array(sizes, "Volume" if flat_axis(grid) is None else "Area")[0])
    points = bridge.vtk_to_numpy(grid.GetPoints().GetData())
    corners = points[bridge.vtk_to_numpy(grid.GetCells().GetConnectivityArray())]
    first = bridge.vtk_to_numpy(grid.GetCells().GetOffsetsArray())[:-1]
    return volumes, numpy.maximum.reduceat(corners, first) - numpy.minimum.reduceat(corners, first)


def shallow_copy(dataset):
    """A data set of the same arrays, to which others can be added."""
    copy = dataset.NewInstance()
    copy.ShallowCopy(dataset)
    return copy


def hide_cells_of_hidden_points(dataset):
    """Hide the cells that have a hidden corner, as they are to VTK's readers but not to its probes."""
    flags = dataset.GetPointData().GetArray(GHOSTS)
    if flags is None:
        return
    marked = dataset.NewInstance()
    marked.CopyStructure(dataset)
    add_array(marked.GetPointData(), "hidden", (bridge.vtk_to_numpy(flags) & HIDDEN_POINT).astype(float))
    hidden = array(output_of(filters.vtkPointDataToCellData(), marked), "hidden")[0] > 0
    flags = cell_flags(dataset) | numpy.where(hidden, HIDDEN_CELL, 0)
    add_array(dataset.GetCellData(), GHOSTS, flags.astype(numpy.uint8))


def _cells_of(block, dimension):
    """A block without its cells of other dimensions; None if it has no others."""
    if block.IsA("vtkUnstructuredGrid"):
        types, cell, others = model.vtkCellTypes(), model.vtkGenericCell(), False
        chosen = extraction.vtkExtractCellsByType()
        block.GetCellTypes(types)
        for number in map(types.GetCellType, range(types.GetNumberOfTypes())):
            cell.SetCellType(number)
            if cell.GetCellDimension() == dimension:
                chosen.AddCellType(number)
            else:
                others = True
        block = output_of(chosen, block) if others else block
    elif dimension != (2 if block.IsA("vtkPolyData") else numpy.count_nonzero(numpy.array(dimensions_of(block)) > 1)):
        return None
    return block if block.GetNumberOfCells() else None


def dimensions_of(grid):
    """The points of a structured grid along x, y and z."""
    extent = grid.GetExtent()
    return [last - first + 1 for first, last in zip(extent[::2], extent[1::2])]


def axes_of(grid):
    """The coordinates of a rectilinear grid along each axis."""
    return [bridge.vtk_to_numpy(getattr(grid, f"Get{letter}Coordinates")()) for letter in "XYZ"]


def set_axes(grid, axes):
    """Give a rectilinear grid its coordinates along each axis."""
    for letter, axis in zip("XYZ", axes):
        getattr(grid, f"Set{letter}Coordinates")(bridge.numpy_to_vtk(numpy.ascontiguousarray(axis, float), deep=True))
