"""Ocean models on s-levels, as ROMS writes them: u and v on the faces of cells, levels that follow the bottom."""

import re

import numpy

from ..errors import InputError
from .earth import local_plane
from .grids import grid_of
from .netcdf_file import NetcdfFile, text


def is_level(variable):
    """Whether a variable is the levels, or the faces between them."""
    return text(variable, "standard_name").startswith("ocean_s") and text(variable, "formula_terms")


class OceanFile(NetcdfFile):
    """Values are brought to the centres of cells (ROMS's rho points). Land has no values."""

    def __init__(self, path, data):
        self._levels = min(filter(is_level, data.variables.values()), key=len)  # of the cells, not of their faces
        super().__init__(path, data, next((n for n in data.dimensions if n in ("ocean_time", "time")), None))
        terms = dict(re.findall(r"(\w+): *(\w+)", self._levels.formula_terms))
        self._terms = {term: name for term, name in terms.items() if name in data.variables}
        if "depth" not in self._terms:
            raise InputError(f"{path}: the formula_terms of {self._levels.name} name no depth that the file holds")
        self._rows, self._columns = data.variables[self._terms["depth"]].dimensions[-2:]
        self._fields = [name for name, v in data.variables.items() if self._is_field(v)]

    def components(self, step):
        return tuple(name if name in self._fields else None for name in "uvw")

    def arrays(self, step):
        return {name: 1 for name in self._fields}

    def read(self, step, names):
        water = self._water(step)
        fields = {name: self._centred(name, step, water) for name in names}
        if "angle" in self.data.variables and {"u", "v"} <= set(names):
            angle = self.place("angle", step, water)
            cosine, sine = numpy.cos(angle), numpy.sin(angle)
            u, v = fields["u"], fields["v"]
            fields["u"], fields["v"] = u * cosine - v * sine, u * sine + v * cosine
        return grid_of(*self._horizontal(step), self._heights(step, water), fields)

    def _is_field(self, variable):
        sizes = [len(self.data.dimensions[d]) for d in variable.dimensions if d != self._time]
        shape = [len(self._levels), len(self.data.dimensions[self._rows]), len(self.data.dimensions[self._columns])]
        return (
            len(sizes) == 3
            and abs(sizes[0] - shape[0]) <= 1
            and all(0 <= n - m <= 1 for n, m in zip(shape[1:], sizes[1:]))
        )

    def _water(self, step):
        """The columns that are no land."""
        shape = [len(self.data.dimensions[name]) for name in (self._rows, self._columns)]
        if "mask_rho" not in self.data.variables:
            return numpy.ones(shape, bool)
        water = numpy.nan_to_num(self.variable("mask_rho", step)) != 0
        if not water.any():
            raise InputError(f"{self.path}: 'mask_rho' is 1 nowhere, so all is land")
        return water

    def _centred(self, name, step, water):
        """A variable at the centres of cells; on land NaN. A face towards land has no flow."""
        values = self.variable(name, step)
        rows, columns = water.shape
        if values.shape[0] == len(self._levels) + 1:
            values = (values[1:] + values[:-1]) / 2
        wet = water
        if values.shape[1] < rows:
            wet = wet[1:] & wet[:-1]
        if values.shape[2] < columns:
            wet = wet[:, 1:] & wet[:, :-1]
        if wet is not water:
            values = numpy.where(wet, values, numpy.nan_to_num(values))
        for axis, count in (1, rows), (2, columns):
            if values.shape[axis] == count - 1:  # the faces between cells: the outer ones repeat the next
                wide = numpy.pad(values, [(1, 1) if i == axis else (0, 0) for i in range(3)], mode="edge")
                values = (numpy.take(wide, range(1, count + 1), axis) + numpy.take(wide, range(count), axis)) / 2
        return numpy.where(water, values, numpy.nan)

    def _horizontal(self, step):
        for x, y in ("lon_rho", "lat_rho"), ("x_rho", "y_rho"):
            if x in self.data.variables and y in self.data.variables:
                degrees = x == "lon_rho"
                x, y = self.place(x, step), self.place(y, step)
                if degrees:
                    x, y, _, self.middle = local_plane(x, y, self.middle)
                return x, y
        raise InputError(f"{self.path}: there are neither lon_rho and lat_rho nor x_rho and y_rho")

    def _heights(self, step, water):
        """Heights of the cells' centres by the CF conventions, appendix D."""

        def term(name):
            if name not in self._terms:
                return 0.0
            values = self.variable(self._terms[name], step)
            return self.placed(self._terms[name], values, water if values.ndim == 2 else True)

        depth, surface = numpy.maximum(term("depth"), 1e-3), term("eta")
        kind = text(self._levels, "standard_name")
        if kind == "ocean_sigma_coordinate":
            sigma = self._column(term("sigma"))
            return surface + sigma * (depth + surface)
        s, critical = self._column(term("s")), term("depth_c")
        if kind == "ocean_s_coordinate":
            a, b = term("a"), term("b")
            stretching = (1 - b) * numpy.sinh(a * s) / numpy.sinh(a) + b * (
                numpy.tanh(a * (s + 0.5)) / (2 * numpy.tanh(a / 2)) - 0.5
            )
            return surface * (1 + s) + critical * s + (depth - critical) * stretching
        stretching = self._column(term("C"))
        if kind == "ocean_s_coordinate_g2":
            return surface + (surface + depth) * (critical * s + depth * stretching) / (critical + depth)
        level = critical * s + (depth - critical) * stretching
        return level + surface * (1 + level / depth)

    @staticmethod
    def _column(values):
        return numpy.asarray(values).reshape(-1, 1, 1)
