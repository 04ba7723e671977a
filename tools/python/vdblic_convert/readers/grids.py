"""VTK's structured grids from coordinates and fields of NumPy."""

import numpy

from ..vtk_data import GHOSTS, HIDDEN_POINT, add_array, bridge, core, model, set_axes

EVEN = 1e-3  # of a spacing: how far coordinates may be from even ones; degrees in float32 are about as exact


def grid_of(x, y, z, fields):
    """A grid of fields (z, y, x[, 3]). Its points without a value are hidden.

    `x` and `y` are axes or (y, x), `z` is an axis or (z, y, x); axes may fall. Even axes give an image, uneven ones a
    rectilinear grid, all else a structured grid.
    """
    axes = [x, y, z]
    for i, along in enumerate((-1, -2, -3)):
        if axes[i].ndim == 1 and axes[i][0] > axes[i][-1]:
            fields = {name: numpy.flip(field, 2 - i) for name, field in fields.items()}
            axes = [numpy.flip(axis, along) if axis.ndim > 1 and axis.ndim >= -along else axis for axis in axes]
            axes[i] = axes[i][::-1]
    shape = next(iter(fields.values())).shape[:3]
    flat = all(values.ndim == 1 for values in axes)
    grid = (_image if all(map(_even, axes)) else _rectilinear)(axes) if flat else _structured(axes, shape)
    for name, field in fields.items():
        add_array(grid.GetPointData(), name, field.astype(numpy.float32).reshape(-1, *field.shape[3:]))
    valid = numpy.all([numpy.isfinite(field).reshape(*shape, -1).all(axis=3) for field in fields.values()], axis=0)
    if not valid.all():
        add_array(grid.GetPointData(), GHOSTS, numpy.where(valid, 0, HIDDEN_POINT).astype(numpy.uint8).ravel())
    return grid


def _even(axis):
    step = (axis[-1] - axis[0]) / max(len(axis) - 1, 1)
    return len(axis) == 1 or (
        bool(step) and numpy.abs(axis - axis[0] - step * numpy.arange(len(axis))).max() <= EVEN * abs(step)
    )


def _image(axes):
    image = model.vtkImageData()
    image.SetDimensions(*map(len, axes))
    image.SetOrigin(*(axis[0] for axis in axes))
    spacing = [(axis[-1] - axis[0]) / max(len(axis) - 1, 1) for axis in axes]
    image.SetSpacing([length or min(filter(None, spacing), default=1.0) for length in spacing])
    return image


def _rectilinear(axes):
    grid = model.vtkRectilinearGrid()
    grid.SetDimensions(*map(len, axes))
    set_axes(grid, axes)
    return grid


def _structured(axes, shape):
    full = [a if a.ndim > 1 else a.reshape([-1 if i == 2 - k else 1 for i in range(3)]) for k, a in enumerate(axes)]
    places = numpy.stack([numpy.broadcast_to(axis, shape).ravel() for axis in full], axis=1)
    points, grid = core.vtkPoints(), model.vtkStructuredGrid()
    points.SetData(bridge.numpy_to_vtk(places, deep=True))
    grid.SetDimensions(*shape[::-1])
    grid.SetPoints(points)
    return grid
