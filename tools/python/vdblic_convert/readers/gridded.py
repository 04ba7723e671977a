"""Common parts of all formats with named axes: xarray's variables, in known units, at known times."""

import re

import numpy

from ..errors import InputError, needed
from ..units import converted, measures
from . import Source
from .times import is_date, seconds_of, seconds_of_texts

MEDIUM = r"(wind|(sea_water_)?velocity)"
COMPONENTS = (
    rf"(surface_)?(geostrophic_)?(grid_)?eastward_{MEDIUM}|(surface_)?(x_wind|sea_water_(surface_)?x_velocity|x_sea_water_velocity)",
    rf"(surface_)?(geostrophic_)?(grid_)?northward_{MEDIUM}|(surface_)?(y_wind|sea_water_(surface_)?y_velocity|y_sea_water_velocity)",
    rf"(up|down)ward_(air|sea_water)_{MEDIUM}|lagrangian_tendency_of_air_pressure",
)
EASTWARD = r"(?!.*grid_).*(east|north)ward_.*"
TIME = r"(ocean_|model_|valid_|forecast_)?time(_counter|_instant)?\d*|t|mt|date|step|year|month|day|hour"
PACKED = "valid_min", "valid_max", "valid_range"


class Data:
    """The variables of a file by name, read on demand, with the attributes that the user gave for them."""

    def __init__(self, path, variables, attributes, answers):
        self.path, self.variables, self.attributes = path, variables, attributes
        self.sizes = {}
        for name, variable in variables.items():
            for dimension, size in zip(variable.dims, variable.shape):
                if self.sizes.setdefault(dimension, size) != size:
                    raise InputError(
                        f"{path}: '{name}' has {size} values along '{dimension}', others {self.sizes[dimension]}: its "
                        "grid is another one"
                    )
        self.answered = answers.keys() & variables.keys()
        for name in self.answered:
            answer = answers[name]
            kept = {key: value for key, value in variables[name].attrs.items() if key.lower() not in answer}
            variables[name].attrs = kept | answer

    def add(self, name, dims, values, **attributes):
        """A variable that follows from others."""
        self.variables[name] = needed("xarray").Variable(dims, values, attributes)
        self.sizes |= zip(dims, values.shape)

    def contents(self):
        return ", ".join(list(self.variables)[:20]) or "no variables"

    def text(self, name, attribute):
        """An attribute, in whatever letters its name is; empty if there is none. Raises InputError for two of them."""
        keys = (attribute, "unit") if attribute == "units" else (attribute,)
        found = {str(value).strip() for key, value in self.attrs(name).items() if key.lower() in keys}
        if len(found) > 1:
            raise InputError(f"{self.path}: '{name}' has several attributes '{attribute}': {', '.join(sorted(found))}")
        value = found.pop() if found else ""
        if attribute == "standard_name":
            if not value and any(re.fullmatch(kind, self.text(name, "long_name")) for kind in COMPONENTS):
                value = self.text(name, "long_name")  # as NEMO has it
            value = value.lower().replace("ocean_sigma/general_coordinate", "ocean_sigma_coordinate")  # as FVCOM has it
        return value

    def attrs(self, name):
        return self.variables[name].attrs if name in self.variables else {}


class Gridded(Source):
    """A file of xarray's variables, which a convention places: `_fields` maps the names of its fields to their grids,
    and `_read(step, names, velocity)` makes the data set of variables on one grid."""

    unit = "m"
    usual = (), (), ()  # the names of components without a standard name; in models they precede standard names
    of_model = False
    used = ()  # the names of variables that are known as something else
    _fields = {}

    def __init__(self, data, options):
        self.data, self.path = data, data.path
        self.explained, self._notes, self.globe = {}, [], options.globe
        self.time = self._time_axis()
        try:
            super().__init__(data.path, self._times())
        except (ValueError, TypeError, OverflowError) as error:
            if not options.dt:
                name = self._time_variable() or self.time
                raise InputError(
                    f"{self.path}: its times cannot be read: {error}; say it anew: --attribute "
                    f"'{name}:units=days since 2000-01-01' '{name}:calendar=standard', or give the spacing by --dt"
                ) from None
            super().__init__(data.path, [None] * data.sizes.get(self.time, 1))

    def notes(self):
        return self._notes

    def check_fields(self, place, mend=""):
        if not self._fields:
            raise InputError(f"{self.path}: no variable {place}; it holds {self.data.contents()}{mend}")

    def arrays(self, step):
        return dict.fromkeys(self._fields, 1)

    def components(self, step):
        found, kinds = [], {name: self.data.text(name, "standard_name") for name in self._fields}
        for i, (standard, usual) in enumerate(zip(COMPONENTS, self.usual)):
            named = [name for name, kind in kinds.items() if re.fullmatch(standard, kind)]
            named = [name for name in named if self.levels_of(name)] or named
            if len(named) > 1 and i < 2 and not self.of_model:
                raise InputError(
                    f"{self.path}: {', '.join(named)} are all {kinds[named[0]]}; choose with --array U,V,W"
                )
            unlike = rf"(?!{COMPONENTS[1 - i]})" if i < 2 else ""
            unnamed = [name for name in usual if name in kinds and re.match(unlike, kinds[name])]
            found.append(next(iter(unnamed + named if self.of_model else named + unnamed), None))
        if all(found) and self.levels_of(found[0]) and not self.levels_of(found[2]):
            found[2] = None  # a vertical velocity of one level is none of the others
        return found

    def levels_of(self, name):  # pylint: disable=unused-argument
        """The vertical dimension of a field, if it has one."""
        return True

    def grid_of(self, name):
        return self._fields[name]

    def parts(self, step, names, velocity=()):
        """One for each grid: components may lie on different faces of the cells."""
        self._notes.clear()
        self.used, grids = {*velocity, *names}, {}
        for name in names:
            grids.setdefault(self.grid_of(name), []).append(name)
        return [(self._read(step, own, velocity), own) for own in grids.values()]

    def along(self, name, values, angle):
        """A component along the grid as its share of a velocity, by its angle against x [radians]."""
        self.explained[name] = self.explained.get(name, f"'{name}' is carried") + ", along the grid"
        return numpy.stack([values * numpy.cos(angle), values * numpy.sin(angle), 0 * values], axis=-1)

    def long(self, name):
        """The dimensions of a variable that have several values and are not the time."""
        return [d for d in self.data.variables[name].dims if d != self.time and self.data.sizes[d] > 1]

    def in_time(self, name):
        """Whether a variable has values of each step."""
        return self.data.sizes.get(self.time, 1) == 1 or self.time in self.data.variables[name].dims

    def variable(self, name, step):
        """A variable at a step in double precision, NaN where it is missing, without axes of one value."""
        variable = self.data.variables[name]
        try:
            if self.time in variable.dims:
                variable = variable.isel({self.time: step})
            values = numpy.array(variable.values, float)
        except (OSError, RuntimeError, IndexError, ValueError, TypeError) as error:
            raise InputError(f"{self.path}: variable '{name}' cannot be read: {error}") from None
        values[~numpy.isfinite(values)] = numpy.nan
        scale, offset = (float(variable.encoding.get(key, n)) for key, n in (("scale_factor", 1), ("add_offset", 0)))
        low, high, both = (variable.attrs.get(key) for key in PACKED)
        low, high = both if numpy.size(both) == 2 else (low, high)
        raw = values if (scale, offset) == (1, 0) else (values - offset) / scale
        if raw is not values and numpy.dtype(variable.encoding.get("dtype", float)).kind in "iu":
            raw = numpy.rint(raw)  # xarray unpacks short numbers in single precision
            values = raw * scale + offset
        with numpy.errstate(invalid="ignore"):
            wrong = numpy.abs(values) > 9e36  # NetCDF's default fill values
            for bound, beyond in (low, numpy.less), (high, numpy.greater):
                if bound is not None:  # of the unpacked values if it is of their type, no whole number
                    packed = numpy.result_type(bound).kind in "iu" or raw is values
                    wrong |= beyond(raw if packed else values, float(bound))
            if told := variable.attrs.get("missing_value"):  # the user's: xarray takes away the file's
                wrong |= values == self._number(name, told)
        return numpy.where(wrong, numpy.nan, values).squeeze()

    def _number(self, name, told):
        try:
            return float(told)
        except ValueError:
            raise InputError(f"{self.path}: the missing_value '{told}' of '{name}' is no number") from None

    def place(self, name, step, needed=True):
        """A variable that places others. Raises InputError if it lacks a value, or one where it is `needed`."""
        return self.placed(name, self.variable(name, step), needed)

    def placed(self, name, values, needed):
        """The values of such a variable; the ones that are not needed are any number."""
        missing = ~numpy.isfinite(values)
        lacks = numpy.count_nonzero(missing & needed)
        if lacks:
            ranges = [a for a in PACKED if a in self.data.variables[name].attrs]
            mend = f"correct {' and '.join(ranges)}, which are in packed numbers" if ranges else "complete the file"
            raise InputError(
                f"{self.path}: '{name}', which gives other values their place, lacks {lacks} of {values.size} values; "
                f"{mend}"
            )
        return numpy.where(missing, numpy.mean(values[~missing]) if not missing.all() else 0, values)

    def in_unit(self, name, values, wanted, usual="", role=""):
        """Values of a variable in another unit. Raises InputError unless its own is known; `usual` stands for none."""
        unit, told = self.data.text(name, "units") or usual, wanted.replace("**", "")
        if not unit:
            raise InputError(f"{self.path}: '{name}' has no units; say which: --attribute '{name}:units={told}'")
        try:
            result = converted(values, unit, wanted)
        except ValueError:
            raise InputError(
                f"{self.path}: '{name}' is in '{unit}', which cannot be converted to {told}; if that is wrong, say what "
                f"it is in: --attribute '{name}:units={told}'"
            ) from None
        self.explain(name, role, unit, values)
        return result

    def explain(self, name, role, unit, values):
        some = numpy.ravel(values)[numpy.isfinite(numpy.ravel(values))]
        some = ", ".join(f"{value:.6g}" for value in (some[0], some[-1])) if len(some) else "no values"
        self.explained[name] = f"'{name}' is {role or 'read'}: {some} {unit}"

    def named(self, *standard_names, dimensions=None):
        """The first variable with one of these standard names, and on these dimensions if given; else None."""
        found = (
            name for standard_name in standard_names for name, variable in self.data.variables.items()
            if self.data.text(name, "standard_name") == standard_name and dimensions in (None, variable.dims)
        )  # fmt: skip
        return next(found, None)

    def helper(self, standard_names, units, dimensions):
        """The variable of a standard name on the dimensions, or None. Raises InputError for an uncertain candidate."""
        if found := self.named(*standard_names, dimensions=dimensions):
            return found
        for name, variable in self.data.variables.items():
            own = self.data.text(name, "standard_name"), self.data.text(name, "units")
            may_be = not own[1] or measures(own[1], *units)
            if variable.dims == dimensions and not own[0] and name not in self.used and may_be:
                raise InputError(
                    f"{self.path}: '{name}' may be the {standard_names[0]}, but has no standard_name; say: --attribute "
                    f"'{name}:standard_name={standard_names[0]}', or =other"
                )
        return None

    def _time_axis(self):
        """The dimension that is the time, if there is one."""
        dims = [d for d in self.data.sizes if self._is_time(d)]
        long = [d for d in dims if self.data.sizes[d] > 1]
        if any(self.data.sizes[d] == 0 for d in dims):
            raise InputError(f"{self.path}: it holds no time steps")
        if len(long) > 1:
            sizes = " and ".join(f"'{d}' ({self.data.sizes[d]})" for d in long)
            raise InputError(f"{self.path}: it has several axes of time, {sizes}; keep one value of the others")
        return (long or dims or [None])[0]

    def _is_time(self, dimension):
        text, is_called = self.data.text, re.fullmatch(TIME, dimension, re.I) is not None
        if dimension not in self.data.variables:
            on_it = [name for name, variable in self.data.variables.items() if variable.dims == (dimension,)]
            return is_called or any(self._tells_time(name) for name in on_it)
        kind = text(dimension, "axis").upper() or text(dimension, "cartesian_axis").upper()
        standard = text(dimension, "standard_name")
        told = standard in ("time", "forecast_period", "forecast_reference_time") or kind == "T"
        return told or is_date(text(dimension, "units")) or is_called and not kind and not standard

    def _tells_time(self, name):
        standard = self.data.text(name, "standard_name")
        return is_date(self.data.text(name, "units")) and standard in ("", "time") or name == "ocean_time"

    def _times(self):
        """The times in seconds; None where the file has none."""
        data, text, count = self.data, self.data.text, self.data.sizes.get(self.time, 1)
        calendar_of = lambda name: text(name, "calendar").lower() or "standard"
        name = self._time_variable() or (self.time if self.time in data.variables else None)
        if name is None:
            return [None] * count
        values, units = data.variables[name].values, text(name, "units")
        if values.dtype.kind in "SU":
            times, self.calendar = seconds_of_texts(values), "standard"
            self.explain(name, "the time, as text", "s from 1970 on", times)
            return times.tolist()
        if not units:
            raise ValueError(f"the time axis '{name}' has no units")
        try:
            times = seconds_of(values, units, calendar_of(name))
        except ValueError as error:
            reason = f" ({error})" if str(error) != units else ""
            raise ValueError(f"the time axis '{name}' is in '{units}'{reason}") from None
        self.calendar = is_date(units) and calendar_of(name)
        start = self.named("forecast_reference_time")
        if text(name, "standard_name") == "forecast_period" and start and data.variables[start].size == 1:
            self.calendar = calendar_of(start)
            times = times + seconds_of(data.variables[start].values, text(start, "units"), self.calendar)
        self.explain(name, "the time", f"{units}{', calendar ' + self.calendar if self.calendar else ''}", values)
        return times.tolist()

    def _time_variable(self):
        """The variable of the times: dates as text, else a variable called time, else the axis itself, else a date."""

        def rank(name):
            variable, text = self.data.variables[name], self.data.text
            along = tuple(d for d in variable.dims if self.data.sizes[d] > 1 or d == self.time)
            if along != ((self.time,) if self.time else ()) and (self.data.sizes.get(self.time, 1) > 1 or along):
                return None
            standard, units = text(name, "standard_name"), text(name, "units")
            if variable.dtype.kind in "SU":
                return 0 if name in ("Times", "xtime") else None
            if standard in ("forecast_reference_time", "forecast_period"):
                return 4 if name == self.time else None
            if standard == "time" or name == "ocean_time":
                return 1
            if name == self.time:
                return 2
            return 3 if is_date(units) and (self.time or "time" in name.lower()) else None

        return min((name for name in self.data.variables if rank(name) is not None), key=rank, default=None)
