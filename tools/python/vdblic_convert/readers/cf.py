"""Gridded files by the CF conventions: which variables are the velocity, how it is directed, and where it is."""

import re

import numpy

from ..errors import InputError
from ..units import measures
from .earth import standard_atmosphere, upward_velocity
from .gridded import EASTWARD, Gridded
from .grids import grid_of
from .heights import heights_of_axis, vertical
from .place import LONGITUDE, TURNED, axis_of, horizontal
from .sgrid import CGrid

ALONG = r"(|.*_)(grid_(?:east|north)ward|x|y)_.+"
USUAL = (  # names of components without a standard name; the last ones are used by models
    ("u", "U", "UVEL", "vozocrtx", "ua", "uo", "water_u", "air_u", "u10"),
    ("v", "V", "VVEL", "vomecrty", "va", "vo", "water_v", "air_v", "v10"),
    ("w", "W", "WVEL", "vovecrtz", "wa", "wo"),
)


class CfFile(Gridded):
    usual = USUAL

    def __init__(self, data, options):
        super().__init__(data, options)
        for dimension in data.sizes.keys() - data.variables.keys() - {self.time}:  # coordinates of another name
            own = [n for n, v in data.variables.items() if v.dims == (dimension,) and axis_of(data, n)]
            data.variables |= {dimension: data.variables[own[0]]} if len(own) == 1 else {}
        self.c_grid = CGrid(data, axis_of)
        self._put_axes()
        axes = {dimension: axis_of(data, dimension) for dimension in data.sizes if dimension != self.time}
        self._axes = axes | self.c_grid.axes
        numbers = [n for n, v in data.variables.items() if n not in data.sizes and v.dtype.kind in "fiu"]
        self._fields = {name: space for name in numbers if (space := self._space(name))}
        for name in numbers if not any(self.components(0)) else ():
            self._check_axes(name)
        mend = "; say which axes are which: --attribute 'NAME:axis=X', Y or Z"
        self.check_fields("has two horizontal axes, with or without a vertical axis, that are known", mend)

    def _put_axes(self):
        """The axes of a C grid that follow from its others."""
        data, told = self.data, ("units", "standard_name", "positive", "axis")
        for name in [d for d in self.c_grid.axes if d in data.sizes and d not in data.variables]:
            for (other,) in self.c_grid.others((name,)):
                if other in data.variables and data.variables[other].dims == (other,) and data.sizes[other] > 1:
                    values, unit = self.place(other, 0), data.text(other, "units")
                    values = numpy.unwrap(values, period=360) if re.fullmatch(LONGITUDE, unit, re.I) else values
                    values = self.c_grid.moved(values, (other,), (name,), data.sizes)
                    data.add(name, (name,), values, **{key: text for key in told if (text := data.text(other, key))})
                    break

    def levels_of(self, name):
        return self._fields[name][0]

    def grid_of(self, name):
        return self._fields[name], self.data.text(name, "coordinates")

    def field(self, name, step, dimensions):
        """A variable on (z, y, x)."""
        order = [d for d in self.data.variables[name].dims if d in dimensions]
        values = self.variable(name, step).reshape([self.data.sizes[d] for d in order])
        return values.transpose([order.index(d) for d in dimensions if d in order])

    def _read(self, step, names, velocity):
        dimensions = self._fields[names[0]]
        place = horizontal(self, names[0], dimensions)
        if self.globe and not place.in_degrees:
            raise self.globe.lacks_degrees(self.path)
        fields = {name: self.field(name, step, dimensions) for name in names}
        there = numpy.any([numpy.isfinite(values) for values in fields.values()], axis=0)
        if dimensions[0] is None:
            z, pressure = self._level(names[0]), None
            fields = {name: values[None] for name, values in fields.items()}
        else:
            z, pressure = vertical(self, names[0], dimensions, step, there)
        fields = {
            name: self._in_si(name, values, step, dimensions, pressure, velocity) for name, values in fields.items()
        }
        columns = tuple(d for d in self.data.variables[names[0]].dims if d != dimensions[0])
        surface = pressure is not None and self.helper(("surface_air_pressure",), ("Pa",), columns)
        if surface:
            ground = self.field(surface, step, dimensions[1:])
            ground = self.in_unit(surface, ground, "Pa", role="the ground's pressure")
            ground = self.placed(surface, ground, there.any(axis=0))
            pressure = pressure.reshape(-1, 1, 1) if pressure.ndim < 3 else pressure
            fields = {name: numpy.where(pressure > ground, numpy.nan, field) for name, field in fields.items()}
        fields = {
            name: self._turned(name, numpy.where(place.torn, numpy.nan, values[:, :, place.columns]), place, velocity)
            for name, values in fields.items()
        }
        z = z if z.ndim < 3 else z[:, :, place.columns]
        if place.in_degrees:
            return grid_of(*self.globe.closed(place, z, fields, velocity))
        return grid_of(place.x, place.y, z, fields)

    def _turned(self, name, values, place, velocity):
        """A horizontal component as its share of a velocity along the world's axes, where its own are others."""
        standard = self.data.text(name, "standard_name")
        slot = velocity.index(name) if name in velocity else (self.vector_of(name) or (None, 2))[1]
        if slot > 1 or name in velocity and len(velocity) < 2:
            return values
        self.explained.setdefault(name, f"'{name}' is carried")
        kinds = ["eastward"] * bool(re.fullmatch(EASTWARD, standard)) + ["along"] * bool(re.fullmatch(ALONG, standard))
        relative = str(self.data.attrs(name).get("GRIB_uvRelativeToGrid", ""))
        if relative in ("0", "1"):  # GRIB's own word; its y runs northwards, however the rows are stored
            kinds = ["along" if relative == "1" else "eastward"]
            place.along = place.along and (place.along[0], place.along[0] + numpy.pi / 2)
        if not kinds and name in velocity and len({self._fields[n] for n in velocity[:2] if n in self._fields}) > 1:
            kinds = ["along"]  # on the faces of cells
        turns = {kind: getattr(place, kind) for kind in kinds or ("eastward", "along")}
        if kinds and turns[kinds[0]] is None:
            raise InputError(
                f"{self.path}: '{name}' is {standard}, and nothing tells where east is along its axes: neither "
                "longitude and latitude nor a grid_mapping; if it is along the axes: --attribute "
                f"'{name}:standard_name={'xy'[slot]}_wind'"
            )
        known = [turn[slot] for turn in turns.values() if turn is not None]
        apart = lambda angle, other: numpy.abs(numpy.angle(numpy.exp(1j * (angle - other)))).max()
        turned = apart(known[0], known[-1])
        if not kinds and turned > TURNED:
            raise InputError(
                f"{self.path}: is '{name}' along the grid, which is turned by up to {numpy.degrees(turned):.3g} "
                f"degrees against east and north, or along those? say it: --attribute '{name}:standard_name="
                f"{'xy'[slot]}_wind' or '{name}:standard_name={('east', 'north')[slot]}ward_wind'"
            )
        how = {"along": "along the grid", "eastward": ("eastward", "northward")[slot]}
        self.explained[name] += f", {how[kinds[0]] if kinds else 'along the axes'}"
        if apart(known[0], slot * numpy.pi / 2) < 1e-6:
            return values
        if kinds == ["along"] and numpy.mean(numpy.sin(place.along[1] - place.along[0])) < 0:  # singular points may differ
            raise InputError(
                f"{self.path}: '{name}' is along a grid whose rows run the other way round than its columns; say how "
                f"it is directed: --attribute '{name}:standard_name={('east', 'north')[slot]}ward_wind', or turn the "
                f"rows: ncpdq -a -{self._fields[name][1]}"
            )
        parts = [values * numpy.cos(known[0]), values * numpy.sin(known[0]), 0 * values]
        return numpy.stack(parts, axis=-1)

    def vector_of(self, name):
        match = re.fullmatch(r"(|.*_)(eastward|northward|x|y)_(.+)", self.data.text(name, "standard_name"))
        return match and (match[1] + match[3], int(match[2] in ("northward", "y")))

    def _check_axes(self, name):
        """Raise InputError for a variable that would be a field without one of its axes."""
        long = self.long(name)
        other = [d for d in long if self._axes[d] is None]
        if other and {"X", "Y"} <= {self._axes[d] for d in long}:
            raise InputError(
                f"{self.path}: the axis '{other[0]}' of '{name}' is of no known kind; say it: --attribute "
                f"'{other[0]}:units=days since 2000-01-01' for the time, '{other[0]}:axis=Z' for levels; of members "
                f"keep one: ncks -d {other[0]},0, or of GRIB grib_copy -w {other[0]}=1"
            )

    def _space(self, name):
        """The dimensions of a field as z, y, x, without z for one level; empty if the variable has others."""
        long = self.long(name)
        kinds = [self._axes[d] for d in long]
        if len(long) == 3 and set(kinds) == {"X", "Y", "Z"}:
            return tuple(long[kinds.index(kind)] for kind in "ZYX")
        if len(long) == 2 and set(kinds) == {"X", "Y"}:
            return (None, *(long[kinds.index(kind)] for kind in "YX"))
        if len(long) == 3 and kinds[0] in ("Z", None) and kinds[1:] == [None, None]:
            return tuple(long)
        return ()

    def _level(self, name):
        """The height of a field that has one level."""
        other = [d for d in self.data.variables[name].dims if d not in (self.time, *self._fields[name])]
        level = next((d for d in other if self._axes[d] == "Z"), None)
        if level not in self.data.variables:
            return numpy.zeros(1)
        unit = self.data.text(level, "units")
        if unit == "1" or re.match("level|layer|sigma", unit):
            self._notes.append(f"the one level of '{level}' ({unit}) is put at height 0")
            return numpy.zeros(1)
        return heights_of_axis(self, level)

    def _in_si(self, name, values, step, dimensions, pressure, velocity):
        if name not in velocity:
            return values
        slot, unit = velocity.index(name), self.data.text(name, "units")
        zeros = numpy.count_nonzero(values == 0) / values.size
        if slot < 2 and 0.05 < zeros < 0.95:
            self._notes.append(
                f"{100 * zeros:.0f} % of '{name}' are exactly 0; if that is land: --attribute '{name}:missing_value=0'"
            )
        role = f"component {'xyz'[slot]}"
        if not (unit and measures(unit, "Pa/s") and slot == 2):
            down = -1 if self.data.text(name, "standard_name").startswith("downward_") else 1
            return self.in_unit(name, values, "m/s", role=role) * down
        if pressure is None:
            raise InputError(
                f"{self.path}: '{name}' is in {unit}, but no axis has the pressure that makes metres "
                "a second of it; choose other arrays with --array"
            )
        pressure = pressure.reshape(-1, 1, 1) if pressure.ndim < 3 else pressure
        warm = self.helper(("air_temperature",), ("K",), self.data.variables[name].dims)
        temperature = standard_atmosphere(pressure)[1]
        if warm:
            temperature = self.in_unit(warm, self.field(warm, step, dimensions), "K", role="the temperature")
        warmth = f"temperature of {warm!r}" if warm else "standard atmosphere"
        self._notes.append(f"'{name}' becomes m/s by the {warmth}")
        return upward_velocity(self.in_unit(name, values, "Pa/s", role=role), pressure, temperature)
