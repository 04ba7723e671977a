"""NetCDF files by the CF conventions: axes, heights, and units of the velocity."""

import numpy

from ..errors import InputError
from .earth import GRAVITY, local_plane, standard_atmosphere, upward_velocity
from .grids import grid_of
from .netcdf_file import NetcdfFile, text

NAMES = {
    "X": ("x", "lon", "longitude", "nx", "easting"),
    "Y": ("y", "lat", "latitude", "ny", "northing"),
    "Z": ("z", "lev", "level", "height", "altitude", "depth", "plev", "pressure", "pressure_level", "isobaricinhpa"),
    "T": ("time", "valid_time", "t", "date", "year", "month", "day", "hour"),
}
UNITS = {
    "X": ("degrees_east", "degree_east", "degree_e", "degrees_e"),
    "Y": ("degrees_north", "degree_north", "degree_n", "degrees_n"),
    "Z": ("pa", "hpa", "mbar", "millibar", "millibars", "bar"),
}
STANDARD = {
    "X": ("longitude", "projection_x_coordinate", "grid_longitude"),
    "Y": ("latitude", "projection_y_coordinate", "grid_latitude"),
    "Z": ("air_pressure", "height", "altitude", "depth", "geopotential_height"),
    "T": ("time",),
}
PRESSURE = {"pa": 1, "hpa": 100, "mbar": 100, "millibar": 100, "millibars": 100, "bar": 1e5}
LENGTH = {"m": 1, "meter": 1, "meters": 1, "metre": 1, "metres": 1, "km": 1000, "kilometers": 1000}
LENGTH |= {"cm": 0.01, "centimeters": 0.01}
SPEED = {
    "m s-1": 1,
    "m/s": 1,
    "m s**-1": 1,
    "m s^-1": 1,
    "meter second-1": 1,
    "meters/second": 1,
    "cm s-1": 0.01,
    "cm/s": 0.01,
    "centimeter/s": 0.01,
    "km/h": 1 / 3.6,
    "km h-1": 1 / 3.6,
    "knots": 0.514444,
    "kt": 0.514444,
}
TENDENCY = {"pa s-1": 1, "pa/s": 1, "pa s**-1": 1, "pa s^-1": 1, "hpa s-1": 100, "hpa/s": 100}  # of pressure
COMPONENTS = (
    ("eastward_wind", "eastward_sea_water_velocity", "x_wind", "sea_water_x_velocity", "grid_eastward_wind"),
    ("northward_wind", "northward_sea_water_velocity", "y_wind", "sea_water_y_velocity", "grid_northward_wind"),
    (
        "upward_air_velocity",
        "upward_sea_water_velocity",
        "lagrangian_tendency_of_air_pressure",
        "downward_air_velocity",
    ),
)
USUAL = (  # names of components without a standard name; the last ones are those of POP and NEMO
    ("u", "U", "UVEL", "vozocrtx"),
    ("v", "V", "VVEL", "vomecrty"),
    ("w", "W", "WVEL", "vovecrtz"),
)


class CfFile(NetcdfFile):
    def __init__(self, path, data):
        axes = {name: _axis(name, data.variables.get(name)) for name in data.dimensions}
        super().__init__(path, data, next((name for name, axis in axes.items() if axis == "T"), None))
        self._axes = axes
        self._notes = []
        numbers = {n: v for n, v in data.variables.items() if n not in data.dimensions and v.dtype != str}
        self._fields = {name: v for name, v in numbers.items() if len(self._space(v)) == 3}
        if not self._fields:
            for name, variable in numbers.items():
                self._check_axes(name, variable)
            raise InputError(
                f"{path}: no variable has a vertical axis and two horizontal ones; it holds "
                f"{', '.join(list(data.variables)[:20]) or 'no variables'}"
            )

    def notes(self):
        return self._notes

    def components(self, step):
        found = [self.named(*names) for names in COMPONENTS]
        found = [name if name in self._fields else None for name in found]
        for i, names in enumerate(USUAL):
            found[i] = found[i] or next((name for name in names if name in self._fields), None)
        return found

    def arrays(self, step):
        return {name: 1 for name in self._fields}

    def read(self, step, names):
        dimensions = self._space(self._fields[names[0]])
        x, y = self._horizontal(names[0], dimensions)
        fields = {name: self._field(name, step, dimensions) for name in names}
        there = numpy.any([numpy.isfinite(values) for values in fields.values()], axis=0)
        z, pressure = self._vertical(dimensions, step, there)
        fields = {name: self._in_si(name, values, step, dimensions, pressure) for name, values in fields.items()}
        surface = self.named("surface_air_pressure")
        if pressure is not None and surface:
            ground = self.place(surface, step, there.any(axis=0))
            under = numpy.broadcast_to(pressure.reshape(-1, 1, 1), there.shape) > ground
            fields = {name: numpy.where(under, numpy.nan, field) for name, field in fields.items()}
        return grid_of(x, y, z, fields)

    def parts(self, step, names):
        """One for each grid: components may lie on different faces of the cells."""
        self._notes, grids = [], {}
        for name in names:
            variable = self._fields[name]
            grids.setdefault((self._space(variable), text(variable, "coordinates")), []).append(name)
        return [(self.read(step, own), own) for own in grids.values()]

    def _check_axes(self, name, variable):
        """Raise InputError for a variable that would be a field if one of its axes were known to be the time."""
        long = [d for d in variable.dimensions if d != self._time and len(self.data.dimensions[d]) > 1]
        if len(long) == 4 and self._axes[long[0]] is None:
            raise InputError(
                f"{self.path}: the axis '{long[0]}' of '{name}' is of no known kind; if it is the time, give it units: "
                f"ncatted -a units,{long[0]},o,c,'days since 2000-01-01' {self.path}"
            )

    def _space(self, variable):
        """The dimensions of a field as z, y, x; empty if the variable has others."""
        long = [name for name in variable.dimensions if name != self._time and len(self.data.dimensions[name]) > 1]
        if len(long) != 3:
            return ()
        kinds = [self._axes[name] for name in long]
        if set(kinds) == {"X", "Y", "Z"}:
            return tuple(long[kinds.index(kind)] for kind in "ZYX")
        return tuple(long) if kinds[0] in ("Z", None) and kinds[1:] == [None, None] else ()

    def _field(self, name, step, dimensions):
        """A variable on (z, y, x)."""
        variable = self.data.variables[name]
        order = [d for d in variable.dimensions if d in dimensions]
        values = self.variable(name, step).reshape([len(self.data.dimensions[d]) for d in order])
        return values.transpose([order.index(d) for d in dimensions])

    def _in_si(self, name, values, step, dimensions, pressure):
        variable = self.data.variables[name]
        unit = text(variable, "units").lower().strip()
        if unit in TENDENCY:
            if pressure is None:
                raise InputError(
                    f"{self.path}: '{name}' is in {variable.units}, but no axis has the pressure that makes metres "
                    "a second of it; choose other arrays with --array"
                )
            warm = self.named("air_temperature", dimensions=variable.dimensions)
            temperature = (
                self._field(warm, step, dimensions) if warm else standard_atmosphere(pressure)[1].reshape(-1, 1, 1)
            )
            self._notes.append(
                f"'{name}' becomes m/s by the {'temperature of ' + repr(warm) if warm else 'standard atmosphere'}"
            )
            return upward_velocity(values * TENDENCY[unit], pressure.reshape(-1, 1, 1), temperature)
        down = -1 if text(variable, "standard_name").startswith("downward_") else 1
        return values * SPEED.get(unit, 1) * down

    def _horizontal(self, field, dimensions):
        """x and y of a field in metres."""
        names = dimensions[2], dimensions[1]
        if all(name in self.data.variables for name in names):
            coordinates = [self.place(name, 0) for name in names]
        else:
            declared = text(self._fields[field], "coordinates").split()
            variables = sorted(self.data.variables.items(), key=lambda item: item[0] not in declared)
            names = [
                next(
                    (
                        name
                        for name, v in variables
                        if v.dimensions[-2:] == dimensions[1:] and v.ndim <= 3 and _axis("", v) == kind
                    ),
                    None,
                )
                for kind in "XY"
            ]
            if None in names:
                raise InputError(f"{self.path}: the axes {dimensions[1]} and {dimensions[2]} have no coordinates")
            coordinates = [self.place(name, 0) for name in names]
            coordinates = [values.reshape(-1, *values.shape[-2:])[0] for values in coordinates]
        units = [text(self.data.variables[name], "units") for name in names]
        if units[0].lower().startswith("degree"):
            x, y, stretch, self.middle = local_plane(*coordinates, self.middle)
            if stretch > 1.05:
                self._notes.append(
                    f"on the plane, lengths from west to east are too long by a factor of up to {stretch:.3g}"
                )
            return x, y
        return [values * LENGTH.get(unit.lower(), 1) for values, unit in zip(coordinates, units)]

    def _vertical(self, dimensions, step, there):
        """Heights in metres, an axis or (z, y, x), and pressures in Pa where they are the axis.

        `there` tells where values are that need a height.
        """
        axis = self.data.variables.get(dimensions[0])
        unit = text(axis, "units").lower()
        pressure = self.place(dimensions[0], 0) * PRESSURE[unit] if unit in PRESSURE else None
        full = next((v.dimensions for v in self._fields.values() if self._space(v) == dimensions), None)
        if geopotential := self.named("geopotential", dimensions=full):
            heights = self.placed(geopotential, self._field(geopotential, step, dimensions), there)
            return heights / GRAVITY, pressure
        if height := self.named("geopotential_height", "altitude", "height_above_reference_ellipsoid", dimensions=full):
            return self.placed(height, self._field(height, step, dimensions), there), pressure
        if pressure is not None:
            self._notes.append("heights are those of the standard atmosphere, because there is no geopotential")
            return standard_atmosphere(pressure)[0], pressure
        if axis is None or unit and unit not in LENGTH:
            raise InputError(
                f"{self.path}: the vertical axis '{dimensions[0]}' ({unit or 'no unit'}) is neither a height, a "
                "depth nor a pressure, and there is no geopotential; add a variable with the standard_name "
                "geopotential_height"
            )
        down = text(axis, "positive") == "down" or text(axis, "standard_name") == "depth"
        return self.place(dimensions[0], 0) * LENGTH.get(unit, 1) * (-1 if down else 1), None


def _axis(name, variable):
    """X, Y, Z or T; None if it cannot be told."""
    unit = text(variable, "units").lower()
    if " since " in unit:
        return "T"
    declared = text(variable, "axis").upper()
    if declared in NAMES:
        return declared
    for axis in "XYZT":
        if unit in UNITS.get(axis, ()) or text(variable, "standard_name") in STANDARD[axis]:
            return axis
    if text(variable, "positive"):
        return "Z"
    return next((axis for axis, names in NAMES.items() if name.lower() in names), None)
