"""WRF's output: staggered winds, heights from the geopotential PH + PHB."""

import numpy

from ..errors import InputError
from .gridded import Gridded
from .grids import grid_of

GRAVITY = 9.81  # m/s², WRF's own
SPACE = ("bottom_top", "south_north", "west_east")


class WrfFile(Gridded):
    """Values are brought to the centres of WRF's cells. x and y count from the first one, along the model's grid."""

    usual, of_model = (("U",), ("V",), ("W",)), True

    def __init__(self, data, options):
        super().__init__(data, options)
        on_cells = lambda v: tuple(d.removesuffix("_stag") for d in v.dims if d != "Time") == SPACE
        self._fields = {n: SPACE for n, v in data.variables.items() if on_cells(v) and v.dtype.kind in "fiu"}
        spacing = [float(data.attributes.get(name, 0)) for name in ("DX", "DY")]
        if not min(spacing) > 0:
            raise InputError(f"{self.path}: WRF's global attributes DX and DY, the spacing of the grid, are missing")
        self._axes = [numpy.arange(data.sizes[name]) * step for name, step in zip(SPACE[:0:-1], spacing)]

    def _read(self, step, names, velocity):
        height = sum(self._centred(name, step, "m**2/s**2", self.place) for name in ("PH", "PHB")) / GRAVITY
        fields = {name: self._centred(name, step, "m/s" * (name in "UVW")) for name in names}
        return grid_of(*self._axes, height, fields)

    def _centred(self, name, step, wanted, read=None):
        """A variable at the centres of cells: the mean of two faces where it lies on faces."""
        values = (read or self.variable)(name, step)
        values = self.in_unit(name, values, wanted, wanted) if wanted else values
        for axis, dimension in enumerate(d for d in self.data.variables[name].dims if d != "Time"):
            if dimension.endswith("_stag"):
                count = values.shape[axis] - 1
                values = (values.take(range(1, count + 1), axis) + values.take(range(count), axis)) / 2
        return values
