"""WRF's output: staggered winds, heights from the geopotential PH + PHB."""

import numpy

from ..errors import InputError
from .grids import grid_of
from .netcdf_file import NetcdfFile

GRAVITY = 9.81  # m/s², WRF's own
SPACE = ("bottom_top", "south_north", "west_east")


class WrfFile(NetcdfFile):
    """Values are brought to the centres of WRF's cells. x and y count from the first one, along the model's grid."""

    def __init__(self, path, data):
        super().__init__(path, data, "Time" if "Time" in data.dimensions else None)
        self._fields = [
            name
            for name, v in data.variables.items()
            if tuple(d.removesuffix("_stag") for d in v.dimensions if d != "Time") == SPACE
        ]
        spacing = [getattr(data, name, 0) for name in ("DX", "DY")]
        if not min(spacing) > 0:
            raise InputError(f"{path}: WRF's global attributes DX and DY, the spacing of the grid, are missing")
        self._axes = [(numpy.arange(len(data.dimensions[name])) * step) for name, step in zip(SPACE[:0:-1], spacing)]

    def components(self, step):
        return tuple(name if name in self._fields else None for name in "UVW")

    def arrays(self, step):
        return {name: 1 for name in self._fields}

    def read(self, step, names):
        height = sum(self._centred(name, step, self.place) for name in ("PH", "PHB")) / GRAVITY
        return grid_of(*self._axes, height, {name: self._centred(name, step) for name in names})

    def _centred(self, name, step, read=None):
        """A variable at the centres of cells: the mean of two faces where it lies on faces."""
        values = (read or self.variable)(name, step)
        for axis, dimension in enumerate(d for d in self.data.variables[name].dimensions if d != "Time"):
            if dimension.endswith("_stag"):
                low, high = [slice(None)] * 3, [slice(None)] * 3
                low[axis], high[axis] = slice(None, -1), slice(1, None)
                values = (values[tuple(low)] + values[tuple(high)]) / 2
        return values
