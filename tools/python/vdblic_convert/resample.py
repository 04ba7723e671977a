"""Values of a flow at the voxels of a uniform grid, by VTK's probes."""

import numpy

from .target import Target, filling, on_points
from .vtk_data import (
    GHOSTS,
    HIDDEN_CELL,
    HIDDEN_POINT,
    RESIDUE,
    add_array,
    array,
    at_points,
    bridge,
    core,
    dimensions_of,
    filters,
    model,
    solid,
)

MOST_VOXELS = 256**3  # of a grid that nobody chose


def usual_target(dataset, names, path):
    """The grid for a flow if the user chooses none: its own voxels, else about as many as it has points or cells."""
    if own := _own_target(dataset, names):
        return own
    cells = solid(dataset, names, path)
    box = _bounds(cells)
    if not cells.IsA("vtkUnstructuredGrid"):
        return on_points(box, dimensions_of(cells))
    volume = float(numpy.prod(numpy.array(box[3:]) - numpy.array(box[:3])))
    return filling(box, voxel_size=(volume / min(cells.GetNumberOfCells(), MOST_VOXELS)) ** (1 / 3))


def bounds_of(dataset, names, path):
    """The box of a flow's cells, as x0, y0, z0, x1, y1, z1."""
    own = _own_target(dataset, names)
    if own and own.along_axes():  # with its voxels whole
        low = own.origin() - own.spacing / 2
        return (*low, *(low + own.spacing * own.size))
    return _bounds(solid(dataset, names, path))


def sampled(dataset, names, target, path):
    """The named arrays at the centres of a grid's voxels, and where they have values.

    Returns one array of (x, y, z, components) for each name, and a mask of (x, y, z). Voxels on the data's own points
    or cells get their values unchanged.
    """
    own = _own_target(dataset, names)
    if own and own.size == target.size and numpy.array_equal(own.matrix, target.matrix) and own.first == target.first:
        values, mask = [array(dataset, name)[0] for name in names], _visible(dataset, names)
    else:
        values, mask = _probed(at_points(solid(dataset, names, path), names), names, target)
    volumes = [value.reshape(*target.size[::-1], -1).transpose(2, 1, 0, 3) for value in values]
    mask = mask.reshape(target.size[::-1]).transpose(2, 1, 0)
    for volume in volumes:
        mask = mask & numpy.isfinite(volume).all(axis=3)
    return volumes, mask


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


def hide_cells(grid, valid):
    """Hide the cells of a structured grid that have a corner without a value, from VTK's probes.

    `valid` is a mask of (z, y, x) over the points.
    """
    whole = numpy.ones([n - 1 for n in valid.shape], bool)
    for corner in numpy.ndindex(2, 2, 2):
        whole &= valid[tuple(slice(c, c - 1 or None) for c in corner)]
    add_array(grid.GetCellData(), GHOSTS, numpy.where(whole, 0, HIDDEN_CELL).astype(numpy.uint8).ravel())


def _probed(dataset, names, target):
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
    return values, mask


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
