"""Units by pint, in the spellings of files: UDUNITS, which CF refers to, and models."""

import functools
import re

from .errors import needed

# Differences from pint: it reads mb as millibarn, and lacks spellings of meteorologists.
DEFINITIONS = ("millibar = 100 pascal = mbar = mb", "@alias meter = gpm = geopotential_meter = geopotential_metre",
               "@alias knot = kn", "@alias degree_Celsius = degree_C = degrees_C = deg_C = degrees_Celsius",
               "@alias degree = degrees_north = degrees_east = degree_north = degree_east = degree_E = degree_N = "
               "arc_degree = degrees_E = degrees_N")  # fmt: skip
DATES = "month", "year"  # as long as their calendar says, not as pint does


@functools.cache
def _registry():
    registry = needed("pint").UnitRegistry()
    for definition in DEFINITIONS:
        registry.define(definition)
    return registry


@functools.cache
def _parsed(unit):
    """A unit as a quantity of pint's or, where zero is not nothing, as its unit. Raises ValueError."""
    text = re.sub(r"[{}]", "", unit.strip()).replace("^", "**")
    text = re.sub(r"(?<=[A-Za-z])\.(?=[A-Za-z])|(?<=\d)\.(?=[A-Za-z])", " ", text)
    text = re.sub(r"(?<=[A-Za-z_])(?=[-+]?\d)", "**", text)
    if not re.search(r"[A-Za-z°%]", text):
        raise ValueError(unit)
    for words in text, text.lower():
        for parse in _registry().parse_units, _registry().parse_expression:
            try:
                parsed = parse(words)
                if not any(str(name) in DATES for name in getattr(parsed, "_units", ())):
                    return parsed if parse == _registry().parse_units else 1 * parsed
            except Exception:  # pylint: disable=broad-except  # pint also raises errors of Python's tokenizer
                continue
    raise ValueError(unit)


def converted(values, unit, wanted):
    """Values in another unit. Raises ValueError for a unit that is unknown or measures something else."""
    parsed = _parsed(unit)
    try:
        if hasattr(parsed, "magnitude"):
            return values * parsed.to(wanted).magnitude
        if str(parsed) == wanted:
            return values * 1.0
        return _registry().Quantity(values, parsed).to(wanted).magnitude
    except Exception as error:  # pylint: disable=broad-except
        raise ValueError(unit) from error


def measures(unit, *wanted):
    """Whether a unit can be converted to one of others."""
    for other in wanted:
        try:
            converted(1.0, unit, other)
            return True
        except ValueError:
            continue
    return False
