"""Values of a flow at the voxels of a uniform grid, by VTK's probes."""

import functools
import itertools

import numpy

from . import vtk_data as vtk
from .errors import InputError
from .target import Points, Target, filling, on_points

MOST_VOXELS = 256**3  # of a default grid
CELL = "cell of the voxel"
FIRST_CURVED = 21  # of VTK's numbers of cell types
ROUNDING = 1e-5  # how far from a voxel's centre a corner of a cell counts as on it [voxels]


class Flow:
    """The named arrays of a data set or of its blocks, in cells or on voxels of their own."""

    def __init__(self, dataset, names, path):
        self._dataset, self._names, self._path = dataset, names, path
        self._images = [(block, _voxels_of(block, names)) for block in vtk.having(dataset, names)]
        self._own = _joined([voxels for _, voxels in self._images])  # of images side by side

    @functools.cached_property
    def _cells(self):
        return vtk.solid(self._dataset, self._names, self._path)

    def usual_target(self):
        """The default grid for a flow: its own voxels; as many as a structured grid has points (or cells, if they have
        the values); or voxels about as large as a cell of the finer half."""
        if self._own:
            return self._own
        cells, box = self._cells, _box(self._cells)
        if cells.IsA("vtkUnstructuredGrid"):
            return filling(box, _size_by_cells(cells, box))
        points = numpy.array(vtk.dimensions_of(cells))
        if not any(vtk.array(cells, name)[1] for name in self._names):
            return filling(box, numpy.maximum(points - 1, 1))
        return on_points(box, points)

    def bounds(self):
        """The box around the cells, or around voxels along the axes, as x0, y0, z0, x1, y1, z1."""
        if self._own and self._own.along_axes():
            low = self._own.origin() - self._own.spacing / 2
            return (*low, *(low + self._own.spacing * self._own.size))
        return _box(self._cells)

    def covered(self, target):
        """A grid extended by voxels to cover the flow."""
        if self._own:
            return target.covering(self._own.corners())
        return target.covering(numpy.array(list(itertools.product(*_ends(self._cells)))))

    def sampled(self, target):
        """The named arrays at the centres of a grid's voxels, and where they have values.

        Returns one array of (x, y, z, components) for each name, a mask of (x, y, z), and the share of the data's cells
        in which there is a voxel. Voxels on the data's own points or cells get their values unchanged.
        """
        if self._own and (place := target.place_of(self._own)) is not None:
            volumes, mask = self._copied(target)
            met = 1.0
        else:
            values, mask, met = _probed(vtk.at_points(self._cells, self._names), self._names, target)
            volumes = [value.reshape(*target.size[::-1], -1).transpose(2, 1, 0, 3) for value in values]
            mask = mask.reshape(target.size[::-1]).transpose(2, 1, 0)
        for volume in volumes:
            mask = mask & numpy.isfinite(volume).all(axis=3)
        return volumes, mask, met

    def holds(self, points):
        """Whether places are in the data's cells, also in those without a value."""
        dataset = vtk.shallow_copy(self._dataset)
        dataset.GetPointData().Initialize()
        return numpy.ravel(_probed(dataset, (), points)[1])

    def _copied(self, target):
        """The voxels of images that lie on a grid."""
        mask, volumes = numpy.zeros(target.size, bool), []
        for block, voxels in self._images:
            place = target.place_of(voxels)
            low, high = numpy.maximum(place, 0), numpy.minimum(place + voxels.size, target.size)
            there = tuple(map(slice, low, numpy.maximum(high, low)))
            here = tuple(map(slice, low - place, numpy.maximum(high, low) - place))
            seen = _by_axes(_visible(block, self._names), voxels)[here][..., 0]
            mask[there] |= seen
            for i, name in enumerate(self._names):
                values = _by_axes(vtk.array(block, name)[0], voxels)[here]
                if i == len(volumes):
                    volumes.append(numpy.zeros((*target.size, values.shape[3]), values.dtype))
                volumes[i][there][seen] = values[seen]
        return volumes, mask


def _by_axes(values, voxels):
    return values.reshape(*voxels.size[::-1], -1).transpose(2, 1, 0, 3)


def _size_by_cells(cells, box):
    """How many voxels fill a box so that one is as large as a cell of the finer half, and a layer of cells has one."""
    volumes, extents = vtk.cell_sizes(cells)
    lengths, flat = numpy.array(box[3:]) - numpy.array(box[:3]), vtk.flat_axis(cells)
    if cells.GetCellType(0) >= FIRST_CURVED:  # cells of order n are n voxels long
        corners = cells.GetCells().GetConnectivityArray().GetNumberOfTuples() / len(volumes)
        dimension = 3 if flat is None else 2
        order = max(round(corners ** (1 / dimension)) - 1, 1)
        volumes, extents = volumes / order**dimension, extents / order
    if flat is not None:
        volumes, extents[:, flat] = volumes * lengths[flat], lengths[flat]
    finer = volumes <= numpy.median(volumes)
    volume, spacing = numpy.median(volumes[finer]), numpy.median(extents[finer], axis=0)
    layer = spacing > 0.99 * lengths
    spacing = numpy.where(layer, lengths, spacing)
    if not layer.all():
        least = numpy.prod(lengths) / MOST_VOXELS
        spacing[~layer] *= (max(volume, least) / numpy.prod(spacing)) ** (1 / numpy.count_nonzero(~layer))
    return numpy.maximum(numpy.round(lengths / spacing), 1).astype(int)


def flow_at(source, step, names, carry, choose, path):
    """A step of a source at the voxels of the grid that `choose` makes of its Flow.

    Returns the velocity (x, y, z, 3), the carried values by name, where all have values, the least share of cells in
    which there is a voxel, and the grid. A component along a turned grid is a share of the vector: that of the velocity,
    or of two that are carried together.
    """
    volumes, mask, met, target = {}, True, 1.0, None
    for data, own in source.parts(step, (*names, *(name for name in carry if name not in names)), names):
        flow = Flow(data, own, path)
        target = target or choose(flow)
        values, valid, share = flow.sampled(target)
        volumes.update(zip(own, values))
        mask, met = mask & valid, min(met, share)
    velocity = numpy.zeros((*mask.shape, 3), numpy.float32)
    for slot, name in enumerate(names):
        whole = volumes[name].shape[3] == 3
        velocity[... if whole else (..., slice(slot, slot + 1))] += volumes[name]
    turned = {name for name in carry if volumes[name].shape[3] > source.arrays(step)[name]}
    for slot, name in enumerate(names):  # components of the velocity that are carried, too
        if name in turned:
            volumes[name] = velocity[..., slot : slot + 1]
    parts = {source.vector_of(name): name for name in turned.difference(names)}  # by the kind of vector, and x or y
    shares = {name: volumes[name] for name in parts.values()}
    for (kind, slot), name in parts.items():
        if (kind, 1 - slot) not in parts:
            raise InputError(
                f"{path}: '{name}' is the component {'xy'[slot]} of a vector along a grid that is turned; carry the "
                f"other one, too: --carry {name},NAME"
            )
        volumes[name] = (shares[name] + shares[parts[kind, 1 - slot]])[..., slot : slot + 1]
    return velocity, {name: volumes[name] for name in carry}, mask, met, target


def _voxels_of(dataset, names):
    """The voxels of an image whose arrays all belong to its points, or all to its cells; else None."""
    if not dataset.IsA("vtkImageData"):
        return None
    association = {vtk.array(dataset, name)[1] for name in names}
    if len(association) > 1 or (vtk.cell_flags(dataset) & vtk.REFINED_CELL).any():
        return None
    matrix, index, of_cells = dataset.GetIndexToPhysicalMatrix(), numpy.eye(4), not association.pop()
    matrix = numpy.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    index[:3, 3] = numpy.array(dataset.GetExtent()[::2]) + 0.5 * of_cells
    size = numpy.maximum(numpy.array(dataset.GetDimensions()) - of_cells, 1)
    return Target(tuple(map(int, size)), matrix @ index)


def _joined(lattices):
    """One grid of the voxels of several, where these are the same voxels or their neighbours; else None."""
    first = lattices[0] if lattices and None not in lattices else None
    for other in lattices[1:] if first else ():
        first = first.covering(other.corners()) if first and first.place_of(other) is not None else None
    return first


def _visible(dataset, names):
    """Which points, or cells, of an image are not hidden by VTK's ghost flags."""
    values, of_points = vtk.array(dataset, names[0])
    data, hidden = (dataset.GetPointData(), vtk.HIDDEN_POINT) if of_points else (dataset.GetCellData(), vtk.HIDDEN_CELL)
    flags = data.GetArray(vtk.GHOSTS)
    return numpy.ones(len(values), bool) if flags is None else vtk.bridge.vtk_to_numpy(flags) & hidden == 0


def _probed(dataset, names, target):
    dataset = vtk.shallow_copy(dataset)
    vtk.hide_cells_of_hidden_points(dataset)
    vtk.add_array(dataset.GetCellData(), CELL, numpy.arange(dataset.GetNumberOfCells(), dtype=float))
    if isinstance(target, Points):
        dataset, target = _by_index(dataset, target)
    if target.along_axes() and not dataset.IsA("vtkImageData"):
        _to_indices(dataset, target)
        target = Target(target.size, numpy.eye(4))
    probe = vtk.filters.vtkProbeFilter()
    probe.SetSourceData(dataset)
    probed = vtk.output_of(probe, _vtk_grid(target))
    value_of = lambda name: vtk.array(probed, name)[0]
    mask, values = value_of(probe.GetValidPointMaskArrayName()) != 0, []
    for name in names:
        corrected = probed.GetPointData().HasArray(vtk.RESIDUE + name)
        values.append(value_of(name) + value_of(vtk.RESIDUE + name) if corrected else value_of(name))
    flags = numpy.broadcast_to(vtk.cell_flags(dataset), dataset.GetNumberOfCells())
    seen = numpy.count_nonzero(flags & vtk.HIDDEN_CELL == 0)
    return values, mask, len(numpy.unique(value_of(CELL)[mask])) / max(seen, 1)


def _to_indices(cells, target):
    """Bring cells to the space of a grid's indices.

    VTK leaves out a voxel whose centre is outside a cell's box by rounding. In indices both can be the same numbers.
    """
    if cells.IsA("vtkRectilinearGrid"):
        axes = zip(vtk.axes_of(cells), target.origin(), target.spacing)
        vtk.set_axes(cells, [_snapped((axis - origin) / length) for axis, origin, length in axes])
    else:
        places, points = vtk.bridge.vtk_to_numpy(cells.GetPoints().GetData()), vtk.core.vtkPoints()
        places = _snapped((places - target.origin()) / target.spacing)
        points.SetData(vtk.bridge.numpy_to_vtk(places, deep=True))
        cells.SetPoints(points)


def _snapped(indices):
    near = numpy.rint(indices)
    return numpy.where(abs(indices - near) < ROUNDING, near, indices)


def _by_index(grid, target):
    """A grid of straight columns as an image on its indices, and the places there: others VTK searches step by step."""
    if grid.IsA("vtkRectilinearGrid"):
        at = [
            numpy.interp(places, axis, numpy.arange(len(axis)), left=-1, right=-1)
            for places, axis in zip(target.at.T, vtk.axes_of(grid))
        ]
    elif not grid.IsA("vtkStructuredGrid") or (at := _in_columns(grid, target)) is None:
        return grid, target
    image = vtk.model.vtkImageData()
    image.SetDimensions(*vtk.dimensions_of(grid))
    image.GetPointData().ShallowCopy(grid.GetPointData())
    image.GetCellData().ShallowCopy(grid.GetCellData())
    return image, Points(target.size, target.matrix, at=numpy.stack(at, axis=1))


def _in_columns(grid, target):
    """The three indices of places in a grid whose columns lie along the radius; None if they do not."""
    shape = vtk.dimensions_of(grid)[::-1]
    points = vtk.bridge.vtk_to_numpy(grid.GetPoints().GetData()).reshape(*shape, 3)
    if 1 in shape:
        return None
    radius, height = numpy.linalg.norm(points[:, 0, 0], axis=-1), numpy.linalg.norm(target.at, axis=1)
    if radius.min() == 0 or numpy.abs(points / radius[:, None, None, None] - points[0] / radius[0]).max() > 1e-9:
        return None
    surface = points[0] / radius[0] * [[[[0.95]]], [[[1.05]]]]  # thick, because it is curved and its cells are flat
    rows, columns = numpy.indices(surface.shape[1:3], float)
    layer = vtk.model.vtkStructuredGrid()
    layer.SetDimensions(*surface.shape[2::-1])
    corners = vtk.core.vtkPoints()
    corners.SetData(vtk.bridge.numpy_to_vtk(surface.reshape(-1, 3), deep=True))
    layer.SetPoints(corners)
    for name, index in ("row", rows), ("column", columns):
        vtk.add_array(layer.GetPointData(), name, numpy.tile(index.ravel(), len(surface)))
    probe = vtk.filters.vtkProbeFilter()
    probe.SetSourceData(layer)
    found = vtk.output_of(probe, _vtk_grid(Points(target.size, target.matrix, at=target.at / height[:, None])))
    there = vtk.array(found, probe.GetValidPointMaskArrayName())[0] != 0
    order = numpy.argsort(radius)
    level = numpy.interp(height, radius[order], order.astype(float), left=-1, right=-1)
    return [*(numpy.where(there, vtk.array(found, name)[0], -1) for name in ("column", "row")), level]


def _vtk_grid(target):
    """The voxels' centres as VTK's points; as an image where they lie along the axes, because that is probed faster."""
    if target.along_axes():
        image = vtk.model.vtkImageData()
        image.SetDimensions(*target.size)
        image.SetOrigin(*target.origin())
        image.SetSpacing(*target.spacing)
        return image
    points, cloud = vtk.core.vtkPoints(), vtk.model.vtkPolyData()
    points.SetData(vtk.bridge.numpy_to_vtk(target.centres(), deep=True))
    cloud.SetPoints(points)
    return cloud


def _ends(dataset):
    return numpy.array(dataset.GetBounds()).reshape(3, 2)


def _box(cells):
    """The box of cells, as x0, y0, z0, x1, y1, z1; that of a plane is as thick as its cells are wide."""
    ends, flat = _ends(cells), vtk.flat_axis(cells)
    if flat is not None:
        lengths = numpy.delete(ends[:, 1] - ends[:, 0], flat)
        ends[flat] += numpy.array([-0.5, 0.5]) * numpy.sqrt(numpy.prod(lengths) / cells.GetNumberOfCells())
    return (*ends[:, 0], *ends[:, 1])
