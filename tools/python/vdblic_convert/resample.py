"""Values of a flow at the voxels of a uniform grid, by VTK's probes."""

import numpy

from .target import Target, filling, on_points
from .vtk_data import (
    GHOSTS,
    HIDDEN_CELL,
    HIDDEN_POINT,
    LAYER,
    RESIDUE,
    add_array,
    array,
    at_points,
    bridge,
    cell_sizes,
    core,
    dimensions_of,
    filters,
    hide_cells_of_hidden_points,
    model,
    shallow_copy,
    solid,
)

MOST_VOXELS = 256**3  # of a grid that nobody chose
CELL = "cell of the voxel"
FIRST_CURVED = 21  # of VTK's numbers of cell types


def usual_target(dataset, names, path):
    """The grid for a flow if the user chooses none: its own voxels, as many as a structured grid has points, or about a
    voxel for each cell of the finer half of all."""
    if own := _own_target(dataset, names):
        return own
    cells = solid(dataset, names, path)
    box = _bounds(cells)
    if not cells.IsA("vtkUnstructuredGrid"):
        target = on_points(box, dimensions_of(cells))
        return target.flattened() if cells.GetFieldData().GetArray(LAYER) else target
    return filling(box, _size_by_cells(cells, box))


def _size_by_cells(cells, box):
    """How many voxels fill a box so that one is as large as a cell of the finer half, and a layer of cells has one."""
    volumes, extents = cell_sizes(cells)
    finer = volumes <= numpy.median(volumes)
    volume, spacing = numpy.median(volumes[finer]), numpy.median(extents[finer], axis=0)
    corners = cells.GetCells().GetConnectivityArray().GetNumberOfTuples() / len(volumes)
    if cells.GetCellType(0) >= FIRST_CURVED:  # cells of order n are n voxels long
        order = max(round(corners ** (1 / 3)) - 1, 1)
        volume, spacing = volume / order**3, spacing / order
    lengths = numpy.array(box[3:]) - numpy.array(box[:3])
    layer = spacing > 0.99 * lengths
    spacing = numpy.where(layer, lengths, spacing)
    if not layer.all():
        least = numpy.prod(lengths) / MOST_VOXELS
        spacing[~layer] *= (max(volume, least) / numpy.prod(spacing)) ** (1 / numpy.count_nonzero(~layer))
    return numpy.maximum(numpy.round(lengths / spacing), 1).astype(int)


def bounds_of(dataset, names, path):
    """The box of a flow's cells, as x0, y0, z0, x1, y1, z1."""
    own = _own_target(dataset, names)
    if own and own.along_axes():  # with its voxels whole
        low = own.origin() - own.spacing / 2
        return (*low, *(low + own.spacing * own.size))
    return _bounds(solid(dataset, names, path))


def sampled(dataset, names, target, path):
    """The named arrays at the centres of a grid's voxels, and where they have values.

    Returns one array of (x, y, z, components) for each name, a mask of (x, y, z), and the share of the data's cells in
    which there is a voxel. Voxels on the data's own points or cells get their values unchanged.
    """
    own = _own_target(dataset, names)
    if own and own.size == target.size and numpy.array_equal(own.matrix, target.matrix) and own.first == target.first:
        values, mask, met = [array(dataset, name)[0] for name in names], _visible(dataset, names), 1.0
    else:
        values, mask, met = _probed(at_points(solid(dataset, names, path), names), names, target)
    volumes = [value.reshape(*target.size[::-1], -1).transpose(2, 1, 0, 3) for value in values]
    mask = mask.reshape(target.size[::-1]).transpose(2, 1, 0)
    for volume in volumes:
        mask = mask & numpy.isfinite(volume).all(axis=3)
    return volumes, mask, met


def _own_target(dataset, names):
    """The voxels of an image whose arrays all belong to its points, or all to its cells; else None."""
    if not dataset.IsA("vtkImageData"):
        return None
    association = [dataset.GetPointData().GetArray(name) is not None for name in names]
    if not all(association) and any(association):
        return None
    matrix, index = dataset.GetIndexToPhysicalMatrix(), numpy.eye(4)
    matrix = numpy.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    index[:3, 3] = numpy.array(dataset.GetExtent()[::2])
    size = numpy.array(dataset.GetDimensions())
    if not all(association):
        index[:3, 3] += 0.5
        size = numpy.maximum(size - 1, 1)
    return Target(tuple(map(int, size)), matrix @ index)


def _visible(dataset, names):
    """Which points, or cells, of an image are not hidden by VTK's ghost flags."""
    of_points = array(dataset, names[0])[1]
    data, hidden = (dataset.GetPointData(), HIDDEN_POINT) if of_points else (dataset.GetCellData(), HIDDEN_CELL)
    if data.GetArray(GHOSTS) is None:
        return numpy.ones(dataset.GetNumberOfPoints() if of_points else dataset.GetNumberOfCells(), bool)
    return bridge.vtk_to_numpy(data.GetArray(GHOSTS)) & hidden == 0


def _probed(dataset, names, target):
    dataset = shallow_copy(dataset)
    hide_cells_of_hidden_points(dataset)
    add_array(dataset.GetCellData(), CELL, numpy.arange(dataset.GetNumberOfCells(), dtype=float))
    probe = filters.vtkProbeFilter()
    probe.SetInputData(_vtk_grid(target))
    probe.SetSourceData(dataset)
    probe.Update()
    data = probe.GetOutput().GetPointData()
    mask = bridge.vtk_to_numpy(data.GetArray(probe.GetValidPointMaskArrayName())) != 0
    values = []
    for name in names:
        values.append(bridge.vtk_to_numpy(data.GetArray(name)))
        if residue := data.GetArray(RESIDUE + name):
            values[-1] = values[-1] + bridge.vtk_to_numpy(residue)
    met = len(numpy.unique(bridge.vtk_to_numpy(data.GetArray(CELL))[mask])) / dataset.GetNumberOfCells()
    return values, mask, met


def _vtk_grid(target):
    """The voxels' centres as VTK's points; as an image where they lie along the axes, because that is probed faster."""
    if target.along_axes():
        image = model.vtkImageData()
        image.SetDimensions(*target.size)
        image.SetOrigin(*target.origin())
        image.SetSpacing(*target.spacing)
        return image
    points, cloud = core.vtkPoints(), model.vtkPolyData()
    points.SetData(bridge.numpy_to_vtk(target.centres(), deep=True))
    cloud.SetPoints(points)
    return cloud


def _bounds(dataset):
    x0, x1, y0, y1, z0, z1 = dataset.GetBounds()
    return x0, y0, z0, x1, y1, z1
