"""What NetCDF files of all conventions share: times, and variables as arrays."""

import re

import numpy

from ..errors import InputError, needed
from . import Source

netCDF4 = needed("netCDF4")
UNITLESS = "time", "t", "Time", "ocean_time"  # axes that count in seconds without saying so
EPOCH = "seconds since 1970-01-01"
SECONDS = {
    "s": 1,
    "sec": 1,
    "second": 1,
    "seconds": 1,
    "min": 60,
    "minutes": 60,
    "h": 3600,
    "hour": 3600,
    "hours": 3600,
    "d": 86400,
    "day": 86400,
    "days": 86400,
}


def text(variable, name):
    """An attribute as text; empty if there is none."""
    return str(getattr(variable, name, ""))


class NetcdfFile(Source):
    """What all conventions share: times, and variables as arrays with NaN where values are missing."""

    unit = "m"

    def __init__(self, path, data, time):
        self.path = path
        self.data = data
        self._time = time  # the time's dimension, if there is one
        super().__init__(path, self._times())

    def variable(self, name, step):
        """A variable at a step in double precision, without its time axis and other axes of one value."""
        variable = self.data.variables[name]
        place = [step if dimension == self._time else slice(None) for dimension in variable.dimensions]
        try:
            values = variable[tuple(place)]
        except (OSError, RuntimeError, IndexError) as error:
            raise InputError(f"{self.path}: variable '{name}' cannot be read: {error}") from None
        return numpy.ma.filled(numpy.ma.masked_invalid(numpy.ma.asarray(values, float)), numpy.nan)

    def place(self, name, step, needed=True):
        """A variable that places others. Raises InputError if it lacks a value, or one where it is `needed`."""
        return self.placed(name, self.variable(name, step), needed)

    def placed(self, name, values, needed):
        """The values of such a variable, where those that are not needed are some number."""
        missing = ~numpy.isfinite(values)
        lacks = numpy.count_nonzero(missing & needed)
        if lacks:
            ranges = [a for a in ("valid_min", "valid_max", "valid_range") if a in self.data.variables[name].ncattrs()]
            mend = f"correct {' and '.join(ranges)}, which are in packed numbers" if ranges else "complete the file"
            raise InputError(
                f"{self.path}: '{name}', which gives other values their place, lacks {lacks} of {values.size} values; "
                f"{mend}"
            )
        return numpy.where(missing, numpy.mean(values[~missing]) if not missing.all() else 0, values)

    def named(self, *standard_names, dimensions=None):
        """The first variable with one of these standard names, and on these dimensions if given; else None."""
        for standard_name in standard_names:
            for name, variable in self.data.variables.items():
                if text(variable, "standard_name") == standard_name and dimensions in (None, variable.dimensions):
                    return name
        return None

    def _times(self):
        if self._time is None:
            return [None]
        count = len(self.data.dimensions[self._time])
        if count == 0:
            raise InputError(f"{self.path}: it holds no time steps")
        variable = next(
            (
                v
                for name, v in self.data.variables.items()
                if v.dimensions[:1] == (self._time,)
                and (
                    name == self._time or name in ("Times", "time", "ocean_time") or text(v, "standard_name") == "time"
                )
            ),
            None,
        )
        try:
            return self._numbers(variable, count)
        except (ValueError, TypeError) as error:
            raise InputError(f"{self.path}: its times cannot be read: {error}") from None

    def _numbers(self, variable, count):
        """The times in seconds."""
        if variable is None:
            return [None] * count
        if variable.ndim == 2:  # WRF's characters
            dates = [row.tobytes().decode().strip("\0 ") for row in variable[:].filled(b" ")]
            whole = numpy.array([date.replace("_", "T") for date in dates], "datetime64[s]")
            self.calendar = True
            return whole.astype(float).tolist()
        units, values = text(variable, "units"), numpy.ma.filled(numpy.ma.asarray(variable[:], float), numpy.nan)
        if not numpy.isfinite(values).all():
            raise ValueError("some are missing")
        if " since " in units:
            calendar = text(variable, "calendar") or "standard"
            self.calendar = True
            return numpy.ravel(netCDF4.date2num(netCDF4.num2date(values, units, calendar), EPOCH, calendar)).tolist()
        unit = re.sub(r"\W.*", "", units) or ("s" if self._time in UNITLESS else "")
        if unit not in SECONDS:
            has = f"is in '{units}'" if units else "has no units"
            raise ValueError(
                f"the time axis '{self._time}' {has}; give it units such as days since a date: "
                f"ncatted -a units,{self._time},o,c,'days since 2000-01-01' {self.path}"
            )
        return (values * SECONDS[unit]).tolist()
