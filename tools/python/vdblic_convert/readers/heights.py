"""Heights in metres: axes that are heights, depths or pressures, and CF's dimensionless coordinates (appendix D)."""

import inspect
import re

import numpy

from ..errors import InputError
from ..units import measures
from .earth import GRAVITY, standard_atmosphere

HEIGHTS = "geopotential_height", "altitude", "height_above_reference_ellipsoid", "height_above_mean_sea_level"
MOST_PRESSURE = 120_000  # Pa: more is not of air
UNITS = dict.fromkeys(("eta", "depth", "depth_c", "orog", "z"), "m") | dict.fromkeys(("ps", "ptop", "p0", "ap"), "Pa")


def _s(s, eta, depth, a, b, depth_c):
    stretching = (1 - b) * numpy.sinh(a * s) / numpy.sinh(a) + b * (
        numpy.tanh(a * (s + 0.5)) / (2 * numpy.tanh(a / 2)) - 0.5
    )
    return eta * (1 + s) + depth_c * s + (depth - depth_c) * stretching


def _s_g1(s, C, eta, depth, depth_c):  # pylint: disable=invalid-name
    level = depth_c * s + (depth - depth_c) * C
    return level + eta * (1 + level / depth)


TERMS = {  # the formula of each coordinate; its arguments are CF's terms
    "ocean_sigma_coordinate": lambda sigma, eta, depth: eta + sigma * (depth + eta),
    "ocean_s_coordinate": _s,
    "ocean_s_coordinate_g1": _s_g1,
    "ocean_s_coordinate_g2": lambda s, C, eta, depth, depth_c: (
        eta + (eta + depth) * (depth_c * s + depth * C) / (depth_c + depth)
    ),
    "atmosphere_sigma_coordinate": lambda sigma, ps, ptop: ptop + sigma * (ps - ptop),
    "atmosphere_hybrid_sigma_pressure_coordinate": lambda a, p0, b, ps: a * p0 + b * ps,
    "atmosphere_hybrid_height_coordinate": lambda z, b, orog: z + b * orog,
    "atmosphere_ln_pressure_coordinate": lambda p0, lev: p0 * numpy.exp(-lev),
}


def by_formula(source, axis, step, needed=True, usual=None, columns=2, sigma=None):
    """Heights, or pressures in Pa, of a dimensionless coordinate; and whether they are pressures. Raises InputError.

    `usual` are the units of terms that tell none, `columns` are the horizontal dimensions, `sigma` is the variable of
    the levels where its formula names another one.
    """
    text, data = source.data.text, source.data
    kind, told = text(axis, "standard_name"), text(axis, "formula_terms")
    terms, compute = dict(re.findall(r"(\w+): *(\w+)", told)), TERMS[kind]
    if "hybrid_height" in kind and "a" in terms:
        terms["z"] = terms["a"]
    if "ap" in terms and "hybrid_sigma" in kind:
        compute = lambda ap, b, ps: ap + b * ps
    levels, values = data.variables[axis].dims[:1], {}
    for term in inspect.signature(compute).parameters:
        if term not in terms:
            shown = "a" if term == "z" else term
            raise InputError(
                f"{source.path}: the formula_terms of '{axis}' name no {shown}, which {kind} needs; say all of them: "
                f"--attribute '{axis}:formula_terms={told or 's: ' + axis} {shown}: NAME'"
            )
        name = sigma if sigma and term == "sigma" else terms[term]
        if name not in data.variables:
            raise InputError(f"{source.path}: the formula_terms of '{axis}' name {name} ({term}), which the file lacks")
        found, along = source.variable(name, step), data.variables[name].dims == levels
        found = source.placed(name, found, True if along or found.ndim == 0 else needed)
        if term in UNITS:
            found = source.in_unit(name, found, UNITS[term], (usual or {}).get(term, ""), f"the {term} of {axis}")
        found = numpy.maximum(found, 1e-3) if term == "depth" else found
        values[term] = found.reshape(-1, *[1] * columns) if along else found
    return compute(**values), kind.startswith("atmosphere") and "height" not in kind


def vertical(source, field, dimensions, step, there):
    """Heights in metres, an axis or (z, y, x), and pressures in Pa where they are the axis.

    `there` is the mask of values that need a height.
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
    if axis not in data.variables:
        raise InputError(
            f"{source.path}: the vertical axis '{axis}' has no coordinates; add them, as a variable '{axis}' in metres with "
            "positive: up or down"
        )
    if unit and not measures(unit, "m"):
        raise InputError(
            f"{source.path}: the vertical axis '{axis}' ({unit or 'no unit'}) is neither a height, a depth nor a "
            "pressure, and there is no geopotential; add a variable with the standard_name geopotential_height, or say "
            f"what the axis is: --attribute '{axis}:units=m'"
        )
    return along_axis(source, axis, dimensions), None


def z_by_variable(source, dimensions, full, step, there):
    """Heights from a geopotential or a height, on the field's dimensions or on half levels; else None."""
    on_pressure = measures(source.data.text(dimensions[0], "units") or "1", "Pa")
    name = source.named(*HEIGHTS, "geopotential", dimensions=full)
    if name is None and on_pressure:
        name = source.helper(("geopotential",), ("m**2/s**2", "m"), full)
    if name is None:
        return _half_levels(source, dimensions, step)
    values = source.placed(name, source.field(name, step, dimensions), there)
    if source.data.text(name, "standard_name") == "geopotential":
        return source.in_unit(name, values, "m**2/s**2", role="the geopotential") / GRAVITY
    return source.in_unit(name, values, "m", role="the height")


def _half_levels(source, dimensions, step):
    """Means of the heights between levels (HHL), which are one more than the levels."""
    sizes = source.data.sizes
    for name in source.data.variables:
        space, is_height = source.long(name), source.data.text(name, "standard_name") in HEIGHTS
        if is_height and (*space[1:],) == dimensions[1:] and sizes[space[0]] == sizes[dimensions[0]] + 1:
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
