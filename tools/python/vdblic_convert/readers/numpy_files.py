"""NumPy's files: arrays indexed [x, y, z] or [time, x, y, z], with the components of a vector last.

An .npz may hold, beside its fields: `time` (seconds, one a step), `origin` (centre of voxel 0 0 0), `voxel_size` (one
or three lengths), `matrix` (4 × 4, indices to world space, in place of both) and `active` (a mask). Values that
are not finite are left out.
"""

import tokenize
import zipfile

import numpy

from ..errors import InputError
from ..vtk_data import add_array, model
from . import Source

PLACE = ("time", "frame", "dt", "origin", "voxel_size", "matrix", "active")


def open_source(path):
    try:
        loaded = numpy.load(path, mmap_mode="r", allow_pickle=False)
        arrays = {name: loaded[name] for name in loaded.files} if hasattr(loaded, "files") else {"velocity": loaded}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, KeyError, tokenize.TokenError) as error:
        raise InputError(f"{path}: cannot be read as NumPy's arrays: {error}") from None
    return NumpyFile(path, arrays)


class NumpyFile(Source):
    def __init__(self, path, arrays):
        self._place = {name: arrays.pop(name) for name in PLACE if name in arrays}
        self._arrays = {name: array for name, array in arrays.items() if numpy.issubdtype(array.dtype, numpy.number)}
        dimensions = {name: array.ndim - _is_vector(array) for name, array in self._arrays.items()}
        self._arrays = {name: array for name, array in self._arrays.items() if dimensions[name] in (3, 4)}
        if not self._arrays:
            raise InputError(f"{path}: no array is a field: one has the axes x y z or time x y z, and components last")
        self._steady = all(dimensions[name] == 3 for name in self._arrays)
        shapes = {array.shape[: dimensions[name]] for name, array in self._arrays.items()}
        if len(shapes) > 1:
            raise InputError(f"{path}: the fields have different shapes: {', '.join(map(str, sorted(shapes)))}")
        (self._shape,) = shapes
        self._mask(path)
        times = numpy.ravel(self._place.get("time", [])).astype(float).tolist()
        steps = 1 if self._steady else self._shape[0]
        if times and len(times) != steps:
            raise InputError(f"{path}: there are {steps} steps but {len(times)} times")
        super().__init__(path, times or [None] * steps)

    def arrays(self, step):
        return {name: array.shape[-1] if _is_vector(array) else 1 for name, array in self._arrays.items()}

    def read(self, step, names):
        image = model.vtkImageData()
        image.SetDimensions(*self._shape[-3:])
        self._put(image)
        for name in names:
            values = self._arrays[name] if self._steady else self._arrays[name][step]
            values = numpy.where(self._active[..., None], values.reshape(*self._shape[-3:], -1), numpy.nan)
            add_array(image.GetPointData(), name, values.transpose(2, 1, 0, 3).reshape(-1, values.shape[3]))
        return image

    def _mask(self, path):
        self._active = numpy.asarray(self._place.get("active", numpy.ones(self._shape[-3:], bool)), bool)
        if self._active.shape != self._shape[-3:]:
            raise InputError(f"{path}: 'active' has the shape {self._active.shape}, the fields {self._shape[-3:]}")

    def _put(self, image):
        """Give an image its place in world space."""
        try:
            matrix = numpy.array(self._place["matrix"], float) if "matrix" in self._place else None
            spacing = numpy.broadcast_to(numpy.array(self._place.get("voxel_size", 1), float), 3)
            origin = numpy.broadcast_to(numpy.array(self._place.get("origin", 0), float), 3)
            if matrix is not None:
                spacing, origin = numpy.linalg.norm(matrix[:3, :3], axis=0), matrix[:3, 3]
                image.SetDirectionMatrix(*(matrix[:3, :3] / spacing).ravel())
        except (ValueError, IndexError):
            raise InputError(
                f"{self.path}: 'origin' and 'voxel_size' have one or three numbers, 'matrix' 4 x 4"
            ) from None
        if not ((spacing > 0).all() and numpy.isfinite([*spacing, *origin]).all()):
            raise InputError(f"{self.path}: voxels of {spacing} at {origin} have no size or no place")
        image.SetSpacing(*spacing)
        image.SetOrigin(*origin)


def _is_vector(array):
    return array.ndim > 3 and array.shape[-1] == 3
