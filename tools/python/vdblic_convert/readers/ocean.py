"""Ocean models on s-levels, as ROMS writes them: u and v on the faces of cells, levels that follow the bottom."""

import re

import numpy

from ..errors import InputError
from .earth import local_plane
from .grids import grid_of
from .netcdf_file import NetcdfFile, text


class OceanFile(NetcdfFile):
    """Values are brought to the centres of cells (ROMS's rho points). Land has no values."""

    def __init__(self, path, data):
        levels = [
            v
            for v in data.variables.values()
            if text(v, "formula_terms") and text(v, "standard_name").startswith("ocean_s")
        ]
        self._levels = min(levels, key=len)  # of the cells, not of the faces between them
        super().__init__(path, data, next((n for n in data.dimensions if n in ("ocean_time", "time")), None))
        terms = dict(re.findall(r"(\w+): *(\w+)", self._levels.formula_terms))
        self._terms = {term: name for term, name in terms.items() if name in data.variables}
        if "depth" not in self._terms:
            raise InputError(f"{path}: the formula_terms of {self._levels.name} name no depth that the file holds")
        self._rows, self._columns = data.variables[self._terms["depth"]].dimensions[-2:]
        self._fields = [name for name, v in data.variables.items() if self._is_field(v)]

    def velocity(self, step):
        found = tuple(name for name in "uvw" if name in self._fields)
        return found if found[:2] == ("u", "v") else ()

    def arrays(self, step):
        return {name: 1 for name in self._fields}

    def read(self, step, names):
        water = self._two("mask_rho", step) != 0 if "mask_rho" in self.data.variables else numpy.True_
        fields = {name: self._centred(name, step, water) for name in names}
        if "angle" in self.data.variables and {"u", "v"} <= set(names):
            cosine, sine = numpy.cos(self._two("angle", step)), numpy.sin(self._two("angle", step))
            u, v = fields["u"], fields["v"]
            fields["u"], fields["v"] = u * cosine - v * sine, u * sine + v * cosine
        return grid_of(*self._horizontal(step), self._heights(step), fields)

    def _is_field(self, variable):
        sizes = [len(self.data.dimensions[d]) for d in variable.dimensions if d != self._time]
        shape = [len(self._levels), len(self.data.dimensions[self._rows]), len(self.data.dimensions[self._columns])]
        return (
            len(sizes) == 3
            and abs(sizes[0] - shape[0]) <= 1
            and all(0 <= n - m <= 1 for n, m in zip(shape[1:], sizes[1:]))
        )

    def _two(self, name, step):
        """A variable on the cells' columns, without missing values."""
        return numpy.nan_to_num(self.variable(name, step))

    def _centred(self, name, step, water):
        """A variable at the centres of cells; on land NaN. A face towards land has no flow."""
        values = self.variable(name, step)
        levels, rows, columns = len(self._levels), *(len(self.data.dimensions[d]) for d in (self._rows, self._columns))
        on_faces = values.shape != (levels, rows, columns)
        if on_faces:
            values = numpy.nan_to_num(values)
        if values.shape[0] == levels + 1:
            values = (values[1:] + values[:-1]) / 2
        for axis, count in (1, rows), (2, columns):
            if values.shape[axis] == count - 1:  # the faces between cells: the outer ones repeat the next
                wide = numpy.pad(values, [(1, 1) if i == axis else (0, 0) for i in range(3)], mode="edge")
                values = (numpy.take(wide, range(1, count + 1), axis) + numpy.take(wide, range(count), axis)) / 2
        return numpy.where(water, values, numpy.nan)

    def _horizontal(self, step):
        for x, y in ("lon_rho", "lat_rho"), ("x_rho", "y_rho"):
            if x in self.data.variables and y in self.data.variables:
                x, y = self.variable(x, step), self.variable(y, step)
                if not (numpy.isfinite(x).all() and numpy.isfinite(y).all()):
                    raise InputError(f"{self.path}: the coordinates of the rho points have missing values")
                return local_plane(x, y)[:2] if "lon_rho" in self.data.variables else (x, y)
        raise InputError(f"{self.path}: there are neither lon_rho and lat_rho nor x_rho and y_rho")

    def _heights(self, step):
        """Heights of the cells' centres by the CF conventions, appendix D."""

        def term(name):
            return self._two(self._terms[name], step) if name in self._terms else 0.0

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
