"""Streaks as curves of USD (UsdGeomBasisCurves): linear, with a width, a colour and scalars at each vertex."""

import dataclasses

import numpy

from vdblic._core import colors_of, read_lines

from .errors import ParameterError
from .usd_layer import identifier, prim, stretched

_MAP = "viridis"
_MOST = 2 << 30  # bytes of text


@dataclasses.dataclass
class Curves:
    """The lines of a prim, and the boxes around it in world space, at most one a frame."""

    prim: list
    boxes: list


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
    boxes = {number: _box(moment) for number, moment in moments.items()}
    span, taken = _span(moments.values()), {"displayColor", "displayOpacity", "id", "source", "age"}
    of = lambda make: {number: make(moment) for number, moment in moments.items()}
    vertex = {
        "float[] widths": of(lambda m: _numbers(2 * m["radius"])),
        "color3f[] primvars:displayColor": of(lambda m: _tuples(_colors(m, span))),
        "float[] primvars:displayOpacity": of(lambda m: _numbers(m["opacity"])),
        "float[] primvars:age": of(lambda m: _numbers(m["age"])),
    }
    for scalar in dict.fromkeys(name for m in moments.values() for name in m["scalars"]):
        values = of(lambda m, scalar=scalar: _numbers(_scalar(m, scalar)))
        vertex[f"float[] primvars:{identifier(scalar, taken)}"] = values
    uniform = {"int[] primvars:id": of(lambda m: _numbers(m["id"], "%d"))}
    if any(m["source"].any() for m in moments.values()):
        uniform["int[] primvars:source"] = of(lambda m: _numbers(m["source"], "%d"))
    attributes = {
        "uniform token type": '"linear"',
        "uniform token wrap": '"nonperiodic"',
        "float3[] extent": {number: _tuples(box) if box is not None else "[]" for number, box in boxes.items()},
        "int[] curveVertexCounts": of(lambda m: _numbers(m["counts"], "%d")),
        "point3f[] points": of(lambda m: _tuples(m["points"])),
        "vector3f[] velocities": of(lambda m: _tuples(_velocities(m, settings.rate))),
    }
    interpolated = [
        f'{declaration} (interpolation = "{interpolation}")'
        for interpolation, declarations in (("vertex", vertex), ("uniform", uniform))
        for declaration in declarations
    ]
    lines = prim("BasisCurves", name, attributes | vertex | uniform | stretched(settings), [interpolated])
    return Curves(lines, [box for box in boxes.values() if box is not None])


def _scalar(moment, name):
    """A scalar of a moment; NaN where it has no value, and where its file lacks it."""
    return moment["scalars"].get(name, numpy.full(len(moment["points"]), numpy.nan, numpy.float32))


def _box(moment):
    if not len(moment["points"]):
        return None
    rim = moment["radius"].max()
    return numpy.array([moment["points"].min(axis=0) - rim, moment["points"].max(axis=0) + rim])


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


def _span(moments):
    """The speeds that the colour map spans: all but the slowest and the fastest hundredth."""
    speeds = numpy.concatenate([_scalar(moment, "magnitude") for moment in moments])
    speeds = speeds[numpy.isfinite(speeds)]
    return tuple(numpy.quantile(speeds, (0.01, 0.99))) if len(speeds) else (0.0, 1.0)


def _colors(moment, span):
    low, high = span
    speeds = numpy.nan_to_num(_scalar(moment, "magnitude"))
    share = (speeds - low) / (high - low) if high > low else numpy.full(len(speeds), 0.5)
    return colors_of(_MAP, share.astype(numpy.float32))


def _numbers(values, form="%.7g"):
    return f"[{', '.join([form] * len(values)) % tuple(values.tolist())}]"


def _tuples(rows):
    return f"[{', '.join(['(%.8g, %.8g, %.8g)'] * len(rows)) % tuple(rows.ravel().tolist())}]"
