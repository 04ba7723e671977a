"""Heights in metres: axes that are heights, depths or pressures, and CF's dimensionless coordinates (appendix D)."""

import re

import numpy

from ..errors import InputError
from ..units import measures
from .earth import GRAVITY, standard_atmosphere

HEIGHTS = "geopotential_height", "altitude", "height_above_reference_ellipsoid", "height_above_mean_sea_level"
MOST_PRESSURE = 120_000  # Pa: more is not of air
# The terms that each coordinate needs.
TERMS = {
    "ocean_sigma_coordinate": ("sigma", "eta", "depth"),
    "ocean_s_coordinate": ("s", "eta", "depth", "a", "b", "depth_c"),
    "ocean_s_coordinate_g1": ("s", "C", "eta", "depth", "depth_c"),
    "ocean_s_coordinate_g2": ("s", "C", "eta", "depth", "depth_c"),
    "atmosphere_sigma_coordinate": ("sigma", "ps", "ptop"),
    "atmosphere_hybrid_sigma_pressure_coordinate": ("b", "ps"),
    "atmosphere_hybrid_height_coordinate": ("a", "b", "orog"),
    "atmosphere_ln_pressure_coordinate": ("p0", "lev"),
}
UNITS = dict.fromkeys(("eta", "depth", "depth_c", "orog"), "m") | dict.fromkeys(("ps", "ptop", "p0", "ap"), "Pa")


def formula(source, axis):
    """The standard name of a dimensionless coordinate, and its terms: term → variable. Raises InputError."""
    text = source.data.text
    kind = text(axis, "standard_name")
    terms = dict(re.findall(r"(\w+): *(\w+)", text(axis, "formula_terms")))
    needed = list(TERMS[kind])
    if kind == "atmosphere_hybrid_sigma_pressure_coordinate":
        needed += ["ap"] if "ap" in terms else ["a", "p0"]
    if kind == "atmosphere_hybrid_height_coordinate":
        terms = {("a" if term == "z" else term): name for term, name in terms.items()}
    for term in needed:
        if term not in terms:
            raise InputError(
                f"{source.path}: the formula_terms of '{axis}' name no {term}, which {kind} needs; say all of them: "
                f"--attribute '{axis}:formula_terms={text(axis, 'formula_terms') or 's: ' + axis} {term}: NAME'"
            )
        if terms[term] not in source.data.variables:
            raise InputError(
                f"{source.path}: the formula_terms of '{axis}' name {terms[term]} ({term}), which the file lacks"
            )
    return kind, terms


def by_formula(source, axis, step, needed=True, usual=None, columns=2, sigma=None):
    """Heights, or pressures in Pa, of a dimensionless coordinate; and whether they are pressures.

    `usual` are the units of terms that tell none, `columns` are the horizontal dimensions, `sigma` is the variable of
    the levels where its formula names another one.
    """
    kind, terms = formula(source, axis)
    terms = terms | ({"sigma": sigma} if sigma else {})
    levels = source.data.variables[axis].dims[:1]

    def term(name):
        values = source.variable(terms[name], step)
        wanted = UNITS.get(name) or ("m" if kind.endswith("height_coordinate") and name == "a" else None)
        along = source.data.variables[terms[name]].dims == levels
        values = source.placed(terms[name], values, True if along or values.ndim == 0 else needed)
        if wanted:
            values = source.in_unit(terms[name], values, wanted, (usual or {}).get(name, ""), f"the {name} of {axis}")
        return values.reshape(-1, *[1] * columns) if along else values

    if kind.startswith("ocean"):
        surface, depth = term("eta"), numpy.maximum(term("depth"), 1e-3)
        if kind == "ocean_sigma_coordinate":
            return surface + term("sigma") * (depth + surface), False
        s, critical = term("s"), term("depth_c")
        if kind == "ocean_s_coordinate":
            a, b = term("a"), term("b")
            stretching = (1 - b) * numpy.sinh(a * s) / numpy.sinh(a) + b * (
                numpy.tanh(a * (s + 0.5)) / (2 * numpy.tanh(a / 2)) - 0.5
            )
            return surface * (1 + s) + critical * s + (depth - critical) * stretching, False
        if kind == "ocean_s_coordinate_g2":
            return surface + (surface + depth) * (critical * s + depth * term("C")) / (critical + depth), False
        level = critical * s + (depth - critical) * term("C")
        return level + surface * (1 + level / depth), False
    if kind == "atmosphere_hybrid_height_coordinate":
        return term("a") + term("b") * term("orog"), False
    if kind == "atmosphere_ln_pressure_coordinate":
        return term("p0") * numpy.exp(-term("lev")), True
    if kind == "atmosphere_sigma_coordinate":
        return term("ptop") + term("sigma") * (term("ps") - term("ptop")), True
    offset = term("ap") if "ap" in terms else term("a") * term("p0")
    return offset + term("b") * term("ps"), True


def vertical(source, field, dimensions, step, there):
    """Heights in metres, an axis or (z, y, x), and pressures in Pa where they are the axis.

    `there` tells where values are that need a height.
    """
    axis, data = dimensions[0], source.data
    unit, full = data.text(axis, "units"), data.variables[field].dims
    z = z_by_variable(source, dimensions, full, step, there)
    pressure = None
    if data.text(axis, "standard_name") in TERMS and (z is None or data.text(axis, "formula_terms")):
        values, is_pressure = by_formula(source, axis, step, there.any(axis=0))
        if not is_pressure:
            return (values if z is None else z), None
        pressure = values
    elif unit and measures(unit, "Pa"):
        pressure = source.in_unit(axis, source.place(axis, 0), "Pa", role="the pressure")
    if pressure is not None:
        if data.text(axis, "standard_name") == "sea_water_pressure" or pressure.max() > MOST_PRESSURE:
            raise InputError(
                f"{source.path}: '{axis}' is a pressure of up to {pressure.max():g} Pa, which is none of air; depths "
                f"in the sea are not computed from it; if a decibar may count as a metre: --attribute '{axis}:units=m' "
                f"'{axis}:standard_name=depth'"
            )
        if z is None:
            source.notes().append("heights are those of the standard atmosphere, because there is no geopotential")
            z = standard_atmosphere(pressure)[0]
        return z, pressure
    if z is not None:
        return z, None
    if axis not in data.variables or unit and not measures(unit, "m"):
        raise InputError(
            f"{source.path}: the vertical axis '{axis}' ({unit or 'no unit'}) is neither a height, a depth nor a "
            "pressure, and there is no geopotential; add a variable with the standard_name geopotential_height, or say "
            f"what the axis is: --attribute '{axis}:units=m'"
        )
    return along_axis(source, axis, dimensions), None


def z_by_variable(source, dimensions, full, step, there):
    """Heights by a geopotential or by heights on the field's own dimensions, or on those between them; else None."""
    on_pressure = measures(source.data.text(dimensions[0], "units") or "1", "Pa")
    find = (
        (lambda *a: source.helper(*a, full)) if on_pressure else lambda names, _: source.named(*names, dimensions=full)
    )
    name = source.named(*HEIGHTS, dimensions=full) or find(("geopotential",), ("m**2/s**2", "m"))
    if name is None:
        return _half_levels(source, dimensions, step)
    values = source.placed(name, source.field(name, step, dimensions), there)
    if source.data.text(name, "standard_name") == "geopotential":
        return source.in_unit(name, values, "m**2/s**2", role="the geopotential") / GRAVITY
    return source.in_unit(name, values, "m", role="the height")


def _half_levels(source, dimensions, step):
    """Means of the heights between levels (HHL), which are one more than the levels."""
    sizes = source.data.sizes
    for name, variable in source.data.variables.items():
        space = [d for d in variable.dims if sizes[d] > 1 and d != source.time]
        if (
            source.data.text(name, "standard_name") in HEIGHTS
            and len(space) == 3
            and tuple(space[1:]) == dimensions[1:]
            and sizes[space[0]] == sizes[dimensions[0]] + 1
        ):
            values = source.in_unit(name, source.place(name, step), "m", role="the height between levels")
            return (values[1:] + values[:-1]) / 2
    return None


def heights_of_axis(source, axis):
    """The heights of an axis, which may be a pressure of the standard atmosphere."""
    if measures(source.data.text(axis, "units") or "1", "Pa"):
        pressure = source.in_unit(axis, source.place(axis, 0), "Pa", role="the pressure")
        return numpy.atleast_1d(standard_atmosphere(pressure)[0])
    return numpy.atleast_1d(along_axis(source, axis))


def along_axis(source, axis, dimensions=()):
    """The heights of an axis of heights or depths. Raises InputError where it does not tell which way is up."""
    values, text = source.place(axis, 0), source.data.text
    heights = source.in_unit(axis, values, "m", role="the height or depth")
    positive, standard = text(axis, "positive").lower(), text(axis, "standard_name")
    if positive not in ("", "up", "down"):
        raise _unclear(source, axis, f"'{positive}' is no direction")
    words = f"{standard} {axis} {text(axis, 'long_name')}".lower()
    deep, high = "depth" in words, re.search("height|altitude|elevation", words)
    if standard == "depth" and positive == "up" or positive == "down" and re.match("height|altitude", standard):
        raise _unclear(source, axis, f"it is a {standard} and positive {positive}")
    if not positive and deep and high:
        raise _unclear(source, axis, "it is called a depth and a height")
    if (positive == "down" or not positive and deep) and (values < 0).any() and not (values > 0).any():
        raise _unclear(source, axis, "it is a depth, and its values are negative")
    if positive or deep or high:
        down = positive == "down" or not positive and deep
    elif (values <= 0).all() and (values < 0).any() or set(map(str.lower, dimensions)) == set("xyz"):
        down = False  # below 0, or x, y and z as geometry has them
        source.notes().append(f"'{axis}' is taken as upward; --attribute '{axis}:positive=down' turns it")
    else:
        raise _unclear(source, axis, "nothing tells whether it is a height or a depth")
    source.explained[axis] += ", downward" if down else ", upward"
    return heights * (-1 if down else 1)


def _unclear(source, axis, why):
    return InputError(
        f"{source.path}: which way is up along '{axis}'? {why}; say it: --attribute '{axis}:positive=up' or "
        f"'{axis}:positive=down', with '{axis}:standard_name=height' or depth where that is wrong"
    )
