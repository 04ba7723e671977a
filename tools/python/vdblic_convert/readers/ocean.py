"""ROMS and its like: u and v on the faces of cells, levels that follow the bottom."""

import re

import numpy

from ..errors import InputError
from .gridded import EASTWARD, Gridded
from .grids import grid_of
from .heights import TERMS, by_formula
from .place import Place, angles, on_plane, ordered

PLACES = (("lon_rho", "lat_rho"), "degree"), (("x_rho", "y_rho"), "m")
FACES = {1: r"(eta|y)_(v|psi)", 2: r"(xi|x)_(u|psi)"}  # names of dimensions on the faces, by axis of a field
METRES = dict.fromkeys(("eta", "depth", "depth_c"), "m")  # as ROMS has them where a file does not say so


def is_level(data, name):
    """Whether a variable is the levels, or the faces between them."""
    return data.text(name, "standard_name") in TERMS and data.text(name, "standard_name").startswith("ocean")


def is_ocean(data):
    if not any(_has_place(data, names) for names, _ in PLACES):
        return False
    levels = any(is_level(data, name) and data.variables[name].ndim == 1 for name in data.variables)
    return levels or {"xi_rho", "eta_rho"} <= set(data.sizes)


def _has_place(data, names):
    return all(name in data.variables and data.variables[name].ndim > 1 for name in names)


class OceanFile(Gridded):
    """Values are brought to the centres of cells (ROMS's rho points). Land has no values."""

    usual, of_model = (("u",), ("v",), ("w",)), True

    def __init__(self, data, options):
        super().__init__(data, options)
        levels = [n for n, v in data.variables.items() if v.ndim == 1 and (is_level(data, n) or n == "s_rho")]
        self._levels = min(levels, key=lambda name: data.variables[name].size) if levels else None
        if self._levels and not is_level(data, self._levels):
            self._levels_of_roms()
        self._shape = self._columns()
        self._fields = {name: True for name, variable in data.variables.items() if self._is_field(name, variable)}
        self.check_fields("is on the cells or their faces")

    def _read(self, step, names, velocity):
        water = self._water(step)
        x, y, columns, turn, north = self._horizontal(step, water)
        fields = {name: self._centred(name, step, water)[..., columns] for name in names}
        for name in names:
            slot = velocity.index(name) if name in velocity else (self.vector_of(name) or (None, 2))[1]
            if name in velocity:
                fields[name] = self.in_unit(name, fields[name], "m/s", "m/s", f"component {'xyz'[slot]}")
            is_east = re.fullmatch(EASTWARD, self.data.text(name, "standard_name"))
            if slot < 2 and not (is_east and north is None):
                fields[name] = self.along(name, fields[name], (north if is_east else turn) + slot * numpy.pi / 2)
        z = by_formula(self, self._levels, step, water, METRES)[0][..., columns] if self._levels else numpy.zeros(1)
        if self.globe:
            if self._unit != "degree":
                raise self.globe.lacks_degrees(self.path)
            x, y, z, fields = self.globe.closed(Place(x, y), z, fields, velocity)
        return grid_of(x, y, z, fields)

    def vector_of(self, name):
        dims = self.data.variables[name].dims
        faces = [axis for axis, words in FACES.items() if re.fullmatch(words, dims[axis - 3])]
        return (re.sub("[uv]", "", name, 1), 2 - faces[0]) if len(faces) == 1 else None

    def _levels_of_roms(self):
        """The formula of levels that only ROMS's own variables tell."""
        data = self.data
        if "Vtransform" not in data.variables:
            raise InputError(
                f"{self.path}: nothing tells the formula of the levels '{self._levels}', neither standard_name nor "
                f"Vtransform; say it: --attribute '{self._levels}:standard_name=ocean_s_coordinate_g2' "
                f"'{self._levels}:formula_terms=s: s_rho C: Cs_r eta: zeta depth: h depth_c: hc'"
            )
        transform = int(self.variable("Vtransform", 0))
        data.variables[self._levels].attrs |= {
            "standard_name": f"ocean_s_coordinate_g{transform}",
            "formula_terms": f"s: {self._levels} C: Cs_r eta: zeta depth: h depth_c: hc",
        }

    def _columns(self):
        """The cells: rows and columns, after levels if there are any."""
        data = self.data
        self._place, self._unit = next((names, unit) for names, unit in PLACES if _has_place(data, names))
        rows = data.variables[self._place[0]].dims[-2:]
        return [data.variables[self._levels].size if self._levels else 1, *(data.sizes[name] for name in rows)]

    def _is_field(self, name, variable):
        sizes = [self.data.sizes[d] for d in variable.dims if d != self.time]
        if len(sizes) == 2 and not self._levels and name not in self.data.sizes and self.in_time(name):
            sizes = [1, *sizes]
        return (
            len(sizes) == 3
            and variable.dtype.kind in "fiu"
            and abs(sizes[0] - self._shape[0]) <= 1
            and all(0 <= n - m <= 1 for n, m in zip(self._shape[1:], sizes[1:]))
        )

    def _water(self, step):
        """The columns that are no land."""
        if "mask_rho" not in self.data.variables:
            return numpy.ones(self._shape[1:], bool)
        water = numpy.nan_to_num(self.variable("mask_rho", step)) != 0
        if not water.any():
            raise InputError(f"{self.path}: 'mask_rho' is 1 nowhere, so all is land")
        return water

    def _centred(self, name, step, water):
        """A variable at the centres of cells; on land NaN. A face towards land has no flow."""
        values, dims = self.variable(name, step), (None, *self.data.variables[name].dims[-2:])
        values = values if self._levels else values[None]
        if values.shape[0] == self._shape[0] + 1:
            values = (values[1:] + values[:-1]) / 2
        counts = {  # of cells along axes on whose faces the values lie, one after each cell
            axis: self._shape[axis]
            for axis, words in FACES.items()
            if values.shape[axis] < self._shape[axis] or re.fullmatch(words, dims[axis])
        }
        wet = water
        for axis in counts:
            rest = [(0, 1) if i == axis - 1 else (0, 0) for i in range(2)]
            wet = wet & numpy.take(numpy.pad(wet, rest, mode="edge"), range(1, self._shape[axis] + 1), axis - 1)
        if counts:
            wet = wet[: values.shape[1], : values.shape[2]]
            values = numpy.where(wet, values, numpy.nan_to_num(values))
        for axis, count in counts.items():  # the outer faces repeat the next
            wide = [(1, count - values.shape[axis]) if i == axis else (0, 0) for i in range(3)]
            wide = numpy.pad(values, wide, mode="edge")
            values = (numpy.take(wide, range(1, count + 1), axis) + numpy.take(wide, range(count), axis)) / 2
        return numpy.where(water, values, numpy.nan)

    def _horizontal(self, step, water):
        """x and y, the order of columns, and how far the grid, and east on a projected plane, are turned against x [radians]."""
        unit = self._unit
        x, y = (self.in_unit(name, self.place(name, step), unit, unit, "the cells' place") for name in self._place)
        columns, turn, north = numpy.arange(x.shape[1]), None, None
        if unit == "degree":
            x, columns = ordered(x)
            y = y[:, columns]
            turn = angles(x, y)[0]
            if not self.globe:
                x, y, self.middle, north, told = on_plane(x, y, self.middle)
                self._notes.extend(told)
        if "angle" in self.data.variables:
            turn = self.place("angle", step, water)[:, columns]
            turn = self.in_unit("angle", turn, "radian", "radian", "how the grid is turned")
        elif turn is None:
            turn = numpy.arctan2(numpy.gradient(y, axis=1), numpy.gradient(x, axis=1))
        return x, y, columns, turn if north is None else turn + north, north
