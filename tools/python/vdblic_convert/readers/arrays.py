"""Arrays without names for their axes: NumPy's files, HDF5 and MATLAB's.

--layout gives their order. NumPy's files with `origin`, `voxel_size`, `matrix`, `active` or axes are in the order
of vdblic_export: [x, y, z] or [time, x, y, z], with the components of a vector last. Beside its fields a file may hold
`time` (seconds or dates, one a step), `origin` (centre of voxel 0 0 0), `voxel_size` (one or three lengths), `matrix`
(4 × 4, indices to world space, in place of both), or the axes `x`, `y` and `z`, and `active` (a mask). Values that are
not finite are left out.
"""

import numpy

from ..errors import InputError, ParameterError, needed
from ..stop import Stopped
from ..velocity import VECTORS
from ..vtk_data import add_array, model
from . import Source
from .grids import grid_of
from .whole_files import check_whole

FORM = ("origin", "voxel_size", "matrix", "active")  # which only files in the form of vdblic_export have
PLACE = ("time", "frame", "dt", *FORM)
NUMPY = ".npy", ".npz"


def open_source(path, options):
    numpys = path.suffix.lower() in NUMPY
    try:
        arrays = _of_numpy(path) if numpys else _of_hdf5(path)
    except (InputError, ParameterError, Stopped):
        raise
    except Exception as error:  # pylint: disable=broad-except # of parsers, compilers and decompressors
        form = "NumPy's arrays" if numpys else "HDF5"
        raise InputError(f"{path}: cannot be read as {form}: {error!s:.300}") from None
    try:
        return ArrayFile(path, arrays, options.layout)
    except (ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: its arrays are not understood: {error}") from None


def _of_numpy(path):
    loaded = numpy.load(path, mmap_mode="r", allow_pickle=False)
    arrays = {name: loaded[name] for name in loaded.files} if hasattr(loaded, "files") else {"velocity": loaded}
    return {name: array for name, array in arrays.items() if isinstance(array, numpy.ndarray)}


def _of_hdf5(path):
    """The datasets of a file by name; they are read when they are asked for."""
    with open(path, "rb") as file:
        old, _, form = file.read(10) == b"MATLAB 5.0", file.seek(512), file.read(4)
    if old and form != b"\x89HDF":
        raise InputError(f"{path}: it is of MATLAB before version 7.3; write it anew: save -v7.3")
    check_whole(path)
    h5py, arrays = needed("h5py"), {}

    def keep(name, item):
        if isinstance(item, h5py.Dataset) and not name.startswith("#"):
            arrays[name] = item[()] if name in PLACE or item.ndim < 2 else item

    h5py.File(path, "r").visititems(keep)
    return arrays


class ArrayFile(Source):
    def __init__(self, path, arrays, layout):
        self._place = {name: arrays.pop(name) for name in PLACE if name in arrays}
        self._told = bool(layout)
        axes = [arrays.get(axis) for axis in "xyz"]
        has_axes = all(axis is not None and numpy.ndim(axis) == 1 for axis in axes)
        own = path.suffix.lower() in NUMPY and (has_axes or any(name in self._place for name in FORM))
        orders = {name: _order(path, name, array, layout, own) for name, array in arrays.items()}
        self._order = {name: order for name, order in orders.items() if order}
        self._arrays = {name: arrays[name] for name in self._order}
        if not self._arrays:
            held = ", ".join(f"{name} {array.shape}" for name, array in list(arrays.items())[:10]) or "nothing else"
            raise InputError(
                f"{path}: no array is a field of the axes {layout or 'x y z'}, --layout tells others; it holds {held}"
            )
        sizes = [dict(zip(order, self._arrays[name].shape)) for name, order in self._order.items()]
        shapes = {tuple(size.get(axis, 1) for axis in "xyz") for size in sizes}
        steps = {size["t"] for size in sizes if "t" in size} or {1}
        if len(shapes) > 1 or len(steps) > 1:
            told = ", ".join(sorted(str(array.shape) for array in self._arrays.values()))
            raise InputError(f"{path}: the fields have different shapes: {told}")
        (self._shape,), (steps,) = shapes, steps
        if not (steps > 0 and all(size > 0 for size in self._shape)):
            raise InputError(f"{path}: the fields have no values: their shape is {self._shape}, with {steps} steps")
        alike = all(numpy.shape(axis) == (size,) for axis, size in zip(axes, self._shape))
        self._axes = None
        if alike and not {"voxel_size", "matrix"} & self._place.keys():
            self._axes = [numpy.array(axis, float) for axis in axes]
            for name, axis in zip("xyz", self._axes):
                steps_along = numpy.diff(axis)
                if not (numpy.isfinite(axis).all() and ((steps_along > 0).all() or (steps_along < 0).all())):
                    raise InputError(f"{path}: the axis '{name}' neither rises nor falls from each value to the next")
        self._active = numpy.asarray(self._place.get("active", numpy.ones(self._shape, bool)), bool)
        if self._active.shape != self._shape:
            raise InputError(f"{path}: 'active' has the shape {self._active.shape}, the fields {self._shape}")
        times = numpy.ravel(self._place.get("time", []))
        if times.dtype.kind == "M":
            times, self.calendar = times.astype("datetime64[us]").astype(float) / 1e6, "proleptic_gregorian"
        elif times.dtype.kind == "m":
            times = times / numpy.timedelta64(1, "s")
        if len(times) not in (0, steps):
            raise InputError(f"{path}: there are {steps} steps but {len(times)} times")
        super().__init__(path, times.astype(float).tolist() or [None] * steps)

    def notes(self):
        name, order = next(iter(self._order.items()))
        axes = ", ".join({"t": "time", "c": "components"}.get(axis, axis) for axis in order)
        told = "" if self._told else "; --layout tells others"
        return [f"the axes of '{name}' {self._arrays[name].shape} are {axes}{told}"]

    def arrays(self, step):
        return {name: 3 if "c" in order else 1 for name, order in self._order.items()}

    def read(self, step, names):
        fields = {name: self._field(name, step) for name in names}
        if self._axes:
            return grid_of(*self._axes, fields)
        image = model.vtkImageData()
        image.SetDimensions(*self._shape)
        self._put(image)
        for name, values in fields.items():
            add_array(image.GetPointData(), name, values.reshape(-1, *values.shape[3:]))
        return image

    def _field(self, name, step):
        """A field of a step as (z, y, x[, 3]), NaN where it is not active."""
        order = self._order[name]
        values = self._arrays[name][tuple(step if axis == "t" else slice(None) for axis in order)]
        values = numpy.asarray(values, float if values.dtype.itemsize > 4 else numpy.float32)
        order = order.replace("t", "")
        values = values.transpose([order.index(axis) for axis in "zyxc" if axis in order])
        values = values if "z" in order else values[None]
        if "c" in order and values.shape[3] == 2:
            values = numpy.concatenate([values, numpy.zeros_like(values[..., :1])], axis=3)
        active = self._active.transpose(2, 1, 0)
        return numpy.where(active[..., None] if "c" in order else active, values, numpy.nan)

    def _put(self, image):
        """Give an image its place in world space."""
        try:
            matrix = numpy.array(self._place["matrix"], float) if "matrix" in self._place else None
            spacing = numpy.broadcast_to(numpy.array(self._place.get("voxel_size", 1), float), 3)
            origin = numpy.broadcast_to(numpy.array(self._place.get("origin", 0), float), 3)
            if matrix is not None:
                if matrix.shape != (4, 4):
                    raise ValueError(matrix.shape)
                spacing, origin = numpy.linalg.norm(matrix[:3, :3], axis=0), matrix[:3, 3]
        except (ValueError, TypeError):
            raise InputError(
                f"{self.path}: 'origin' and 'voxel_size' have one or three numbers, 'matrix' 4 x 4"
            ) from None
        if not ((spacing > 0).all() and numpy.isfinite([*spacing, *origin]).all()):
            raise InputError(f"{self.path}: voxels of {spacing} at {origin} have no size or no place")
        if matrix is not None:
            turn = matrix[:3, :3] / spacing
            if abs(numpy.linalg.det(turn)) < 1e-12:
                raise InputError(f"{self.path}: 'matrix' flattens space")
            image.SetDirectionMatrix(*turn.ravel())
        image.SetSpacing(*spacing)
        image.SetOrigin(*origin)


def _order(path, name, array, layout, told):
    """The axes of a field as letters of t, c, x, y, z; empty for other arrays. Raises InputError if unclear."""
    shape, is_usual = numpy.shape(array), name.rpartition("/")[2] in VECTORS
    if array.dtype.kind not in "fiu":
        if array.dtype.kind == "c" and is_usual:
            raise InputError(f"{path}: no array is a field: '{name}' has complex numbers, a velocity has real ones")
        return ""
    if layout:
        orders = ["".join(axis for axis in layout if axis not in left_out) for left_out in ("", "c", "t", "tc")]
        fits = lambda order: len(order) == len(shape) and ("c" not in order or shape[order.index("c")] in (2, 3))
        return next(filter(fits, orders), "")
    if len(shape) < 3:
        return ""
    vector, is_velocity = shape[-1] == 3 and len(shape) > 3, is_usual and len(name) > 1
    if told and (vector or not is_velocity):
        return {3: "xyz", 4: "xyzc" if vector else "txyz", 5: "txyzc"}.get(len(shape), "")
    orders = ("xyz", "txyz", "xyz")
    if is_velocity or vector:
        orders = ("xyc", "xyzc", "txyzc") if vector or shape[-1] in (2, 3) else ("cxy", "cxyz", "tcxyz")
    reverse = "" if path.suffix.lower() in NUMPY else ", MATLAB's order reversed in MATLAB's files"
    raise InputError(
        f"{path}: nothing tells the order of the axes of '{name}' {shape}; say it: --layout "
        f"{orders[min(len(shape), 5) - 3]}, or other letters of t (time), c (component), x, y and z{reverse}"
    )
