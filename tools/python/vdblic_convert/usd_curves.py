"""Streaks as curves of USD (UsdGeomBasisCurves): linear, with a width, a colour and scalars at each vertex."""

import dataclasses

import numpy

from vdblic._core import colors_of, read_lines

from .errors import ParameterError
from .usd_text import attribute, identifier, prim, samples, tuple_of

_MAP = "viridis"
_MOST = 2 << 30  # bytes of text


@dataclasses.dataclass
class Curves:
    """The lines of a prim, and the box around it in world space, None without a streak."""

    lines: list
    box: list | None


def curves(name, files, settings, stop):
    """The curves of a sequence. @param files  number → path"""
    moments, size = {}, 0
    for number, path in sorted(files.items()):
        stop.check()
        moments[number], _ = read_lines(path)
        size += len(moments[number]["points"]) * (75 + 12 * len(moments[number]["scalars"]))
        if size > _MOST:
            raise ParameterError(
                f"the points of frames {min(files)} to {number} would make a layer of more than {_MOST >> 30} GB of text;"
                " choose fewer frames with --frames, or make fewer streaks with vdblic_advect --spacing"
            )
    shown = {number: moment for number, moment in moments.items() if len(moment["counts"])}
    box = None
    if shown:
        box = [numpy.min([m["points"].min(axis=0) - m["radius"].max() for m in shown.values()], axis=0)]
        box.append(numpy.max([m["points"].max(axis=0) + m["radius"].max() for m in shown.values()], axis=0))
    range_ = _range_of(shown.values())
    lines = ['uniform token type = "linear"', 'uniform token wrap = "nonperiodic"']
    lines += samples("float3[] extent", {number: _extent(moment) for number, moment in moments.items()})
    of = lambda make: {number: make(moment) for number, moment in moments.items()}
    lines += samples("int[] curveVertexCounts", of(lambda m: _numbers(m["counts"], "%d")))
    lines += samples("point3f[] points", of(lambda m: _tuples(m["points"])))
    lines += samples("vector3f[] velocities", of(lambda m: _tuples(_velocities(m, settings.rate))))
    lines += _primvar("float[] widths", "vertex", of(lambda m: _numbers(2 * m["radius"])))
    lines += _primvar("color3f[] primvars:displayColor", "vertex", of(lambda m: _tuples(_colors(m, range_))))
    lines += _primvar("float[] primvars:displayOpacity", "vertex", of(lambda m: _numbers(m["opacity"])))
    lines += _primvar("int[] primvars:id", "uniform", of(lambda m: _numbers(m["id"], "%d")))
    if any(m["source"].any() for m in shown.values()):
        lines += _primvar("int[] primvars:source", "uniform", of(lambda m: _numbers(m["source"], "%d")))
    lines += _primvar("float[] primvars:age", "vertex", of(lambda m: _numbers(m["age"])))
    taken = {"displayColor", "displayOpacity", "id", "source", "age"}
    for scalar in dict.fromkeys(name for m in moments.values() for name in m["scalars"]):
        none = numpy.zeros(0, numpy.float32)
        values = of(lambda m: _numbers(numpy.nan_to_num(m["scalars"].get(scalar, none))))
        lines += _primvar(f"float[] primvars:{identifier(scalar, taken)}", "vertex", values)
    if settings.stretch != (1, 1, 1):
        lines += attribute("double3 xformOp:scale", tuple_of(settings.stretch))
        lines += attribute("uniform token[] xformOpOrder", '["xformOp:scale"]')
    return Curves(prim("BasisCurves", name, lines), box)


def _primvar(declaration, interpolation, values):
    return [f'{declaration} (interpolation = "{interpolation}")', *samples(declaration, values)]


def _extent(moment):
    if not len(moment["points"]):
        return "[]"
    rim = moment["radius"].max()
    low, high = moment["points"].min(axis=0) - rim, moment["points"].max(axis=0) + rim
    return f"[{tuple_of(low)}, {tuple_of(high)}]"


def _velocities(moment, rate):
    """Where the particles of all points move [world units a second], by their path from point to point."""
    points, age = moment["points"], moment["age"].astype(float)
    forward = numpy.zeros_like(points)
    if len(points) > 1:
        time = age[:-1] - age[1:]
        within = time > 0  # the next point of the last one is another line's
        forward[:-1][within] = (points[1:] - points[:-1])[within] / time[within, None]
    heads = numpy.cumsum(moment["counts"]) - 1
    forward[heads] = forward[heads - 1]
    return forward * rate


def _range_of(moments):
    """The speeds that the colour map spans: all but the slowest and the fastest hundredth."""
    speeds = [m["scalars"]["magnitude"] for m in moments if "magnitude" in m["scalars"]]
    speeds = numpy.concatenate(speeds) if speeds else numpy.zeros(0)
    speeds = speeds[numpy.isfinite(speeds)]
    return tuple(numpy.quantile(speeds, (0.01, 0.99))) if len(speeds) else (0.0, 1.0)


def _colors(moment, range_):
    low, high = range_
    speeds = numpy.nan_to_num(moment["scalars"].get("magnitude", numpy.zeros(len(moment["points"]), numpy.float32)))
    share = (speeds - low) / (high - low) if high > low else numpy.full(len(speeds), 0.5)
    return colors_of(_MAP, share.astype(numpy.float32))


def _numbers(values, form="%.7g"):
    return f"[{', '.join([form] * len(values)) % tuple(values.tolist())}]"


def _tuples(rows):
    return f"[{', '.join(['(%.8g, %.8g, %.8g)'] * len(rows)) % tuple(rows.ravel().tolist())}]"
