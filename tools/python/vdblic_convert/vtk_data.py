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

GHOSTS = "vtkGhostType"
HIDDEN_POINT, HIDDEN_CELL = 2, 32
RESIDUE = "residue of "
WEDGE = 13  # VTK's number of the cell type
LAYER = "one layer"  # field data of a grid whose points are the faces of a layer of voxels


@contextlib.contextmanager
def errors_of(path):
    """Turn what VTK prints as an error into an InputError about a file."""
    core.vtkLogger.SetStderrVerbosity(core.vtkLogger.VERBOSITY_OFF)
    window = core.vtkStringOutputWindow()
    before = core.vtkOutputWindow.GetInstance()
    core.vtkOutputWindow.SetInstance(window)
    try:
        yield
    finally:
        core.vtkOutputWindow.SetInstance(before)
    text = window.GetOutput()
    text = text.decode(errors="replace") if isinstance(text, bytes) else text  # as VTK returns what is not UTF-8
    text = re.sub(r"\s+", " ", "".join(char if char.isprintable() else " " for char in text))
    for kind, message in re.findall(
        r"(ERROR|Warning): In [^,]*, line \d+ (?:vtk\w+ \([^)]*\): )?(.*?)(?=ERROR: |Warning: |Generic Warning: |$)",
        text,
    ):
        if kind == "ERROR" or message.startswith("Error"):  # some readers only warn of files that end too early
            raise InputError(f"{path}: cannot be read: {message[:200].strip()}")


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
    """The data sets that a data set consists of: itself, or those of a multi-block."""
    if dataset is None:
        return []
    if not dataset.IsA("vtkCompositeDataSet"):
        return [dataset] if dataset.IsA("vtkDataSet") else []
    blocks, iterator = [], dataset.NewIterator()
    while not iterator.IsDoneWithTraversal():
        blocks.append(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    return [block for block in blocks if block.IsA("vtkDataSet")]


def solid(dataset, names, path):
    """One data set of the cells of three dimensions that have all the named arrays. Raises InputError without any.

    Blocks are merged where their points coincide, so that means over the cells around a point do not end at the border
    of a block.
    """
    blocks = [_cells_of_three_dimensions(block) for block in blocks_of(dataset) if _has(block, names)]
    blocks = [block for block in blocks if block.GetNumberOfCells() > 0]
    if not blocks:
        blocks = [thick for block in blocks_of(dataset) if _has(block, names) and (thick := _thickened(block))]
    if not blocks:
        raise InputError(f"{path}: no cells of three dimensions have {', '.join(names)}")
    if len(blocks) == 1:
        return blocks[0]
    append = filters.vtkAppendFilter()
    append.MergePointsOn()
    for block in blocks:
        append.AddInputData(block)
    append.Update()
    return append.GetOutput()


def joined(grid):
    """An unstructured grid with one point where it has several at one place. Its point data are lost."""
    points, first, numbers = numpy.unique(
        bridge.vtk_to_numpy(grid.GetPoints().GetData()), axis=0, return_index=True, return_inverse=True
    )
    if len(first) == grid.GetNumberOfPoints() or grid.GetFaces() is not None:
        return grid
    corners = numbers[bridge.vtk_to_numpy(grid.GetCells().GetConnectivityArray())]
    cells, places, result = model.vtkCellArray(), core.vtkPoints(), model.vtkUnstructuredGrid()
    cells.SetData(
        grid.GetCells().GetOffsetsArray(), bridge.numpy_to_vtkIdTypeArray(corners.astype(numpy.int64), deep=True)
    )
    places.SetData(bridge.numpy_to_vtk(points, deep=True))
    result.SetPoints(places)
    result.SetCells(grid.GetCellTypesArray(), cells)
    result.GetCellData().ShallowCopy(grid.GetCellData())
    return result


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
    """The data set with the named arrays at its points. Those of cells become means over the cells around a point.

    Such a mean is no longer the cell's value in the middle of a cell, least of all at a rim. What it lacks there stays
    with the cells, as an array RESIDUE and the name.
    """
    of_cells = [name for name in names if dataset.GetPointData().GetArray(name) is None]
    if not of_cells:
        return dataset
    mean, back = filters.vtkCellDataToPointData(), filters.vtkPointDataToCellData()
    mean.SetInputData(dataset)
    mean.ProcessAllArraysOff()
    back.SetInputConnection(mean.GetOutputPort())
    back.ProcessAllArraysOff()
    for name in of_cells:
        mean.AddCellDataArray(name)
        back.AddPointDataArray(name)
    back.Update()
    result = mean.GetOutput()
    for name in of_cells:
        lack = array(dataset, name)[0] - bridge.vtk_to_numpy(back.GetOutput().GetCellData().GetArray(name))
        add_array(result.GetCellData(), RESIDUE + name, lack)
    return result


def cell_sizes(grid):
    """The volumes of an unstructured grid's cells, and their lengths along x, y and z (cells, 3)."""
    sizes = needed("vtkmodules.vtkFiltersVerdict").vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.Update()
    volumes = abs(bridge.vtk_to_numpy(sizes.GetOutput().GetCellData().GetArray("Volume")))
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
    marked, count = dataset.NewInstance(), filters.vtkPointDataToCellData()
    marked.CopyStructure(dataset)
    add_array(marked.GetPointData(), GHOSTS + " hidden", (bridge.vtk_to_numpy(flags) & HIDDEN_POINT).astype(float))
    count.SetInputData(marked)
    count.Update()
    hidden = bridge.vtk_to_numpy(count.GetOutput().GetCellData().GetArray(GHOSTS + " hidden")) > 0
    before = dataset.GetCellData().GetArray(GHOSTS)
    before = 0 if before is None else bridge.vtk_to_numpy(before)
    add_array(dataset.GetCellData(), GHOSTS, (before | numpy.where(hidden, HIDDEN_CELL, 0)).astype(numpy.uint8))


def _has(block, names):
    return all(block.GetPointData().GetArray(name) or block.GetCellData().GetArray(name) for name in names)


def _cells_of_three_dimensions(block):
    """A structured block as it is; an unstructured one without its lines and faces."""
    if block.IsA("vtkImageData"):
        return block
    if not block.IsA("vtkUnstructuredGrid"):
        flat = block.IsA("vtkPolyData") or min(dimensions_of(block)) < 2
        return model.vtkPolyData() if flat else block
    types, cell, chosen = model.vtkCellTypes(), model.vtkGenericCell(), extraction.vtkExtractCellsByType()
    block.GetCellTypes(types)
    all_solid = True
    for i in range(types.GetNumberOfTypes()):
        cell.SetCellType(types.GetCellType(i))
        if cell.GetCellDimension() == 3:
            chosen.AddCellType(types.GetCellType(i))
        else:
            all_solid = False
    if all_solid:
        return block
    chosen.SetInputData(block)
    chosen.Update()
    return chosen.GetOutput()


def _thickened(block):
    """A plane across an axis as a layer of wedges, as thick as its cells are wide; None for other blocks."""
    bounds = numpy.array(block.GetBounds()).reshape(3, 2)
    lengths = bounds[:, 1] - bounds[:, 0]
    flat = int(numpy.argmin(lengths))
    if not (numpy.delete(lengths, flat) > 0).all() or lengths[flat] > 1e-6 * lengths.max():
        return None
    surface, triangles = needed("vtkmodules.vtkFiltersGeometry").vtkGeometryFilter(), filters.vtkTriangleFilter()
    surface.SetInputData(block)
    triangles.SetInputConnection(surface.GetOutputPort())
    triangles.Update()
    plane = triangles.GetOutput()
    if not plane.GetNumberOfPolys():
        return None
    corners = bridge.vtk_to_numpy(plane.GetPolys().GetConnectivityArray()).reshape(-1, 3).astype(numpy.int64)
    points, count = bridge.vtk_to_numpy(plane.GetPoints().GetData()).astype(float), plane.GetNumberOfPoints()
    width = numpy.sqrt(numpy.prod(numpy.delete(lengths, flat)) / block.GetNumberOfCells())
    both = numpy.concatenate([points, points])
    both[:, flat] += numpy.repeat((-0.5, 0.5), count) * width
    places, cells, result = core.vtkPoints(), model.vtkCellArray(), model.vtkUnstructuredGrid()
    places.SetData(bridge.numpy_to_vtk(both, deep=True))
    cells.SetData(6, bridge.numpy_to_vtkIdTypeArray(numpy.hstack([corners, corners + count]).ravel(), deep=True))
    result.SetPoints(places)
    result.SetCells(WEDGE, cells)
    for data, copy, times in (plane.GetPointData(), result.GetPointData(), 2), (
        plane.GetCellData(),
        result.GetCellData(),
        1,
    ):
        for i in range(data.GetNumberOfArrays()):
            if data.GetArray(i) is not None and data.GetArray(i).GetName():
                values = bridge.vtk_to_numpy(data.GetArray(i))
                add_array(copy, data.GetArray(i).GetName(), numpy.concatenate([values] * times))
    return result


def dimensions_of(grid):
    """The points of a structured grid along x, y and z."""
    extent = grid.GetExtent()
    return [last - first + 1 for first, last in zip(extent[::2], extent[1::2])]
