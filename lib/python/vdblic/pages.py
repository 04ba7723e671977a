"""Streaks as a page: one HTML file that shows them in any browser."""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
import math
import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy

from . import _core
from .grids import Volume
from .paths import Paths
from .stills import still
from .surfaces import thinned
from .volumes import path_of

_FILES = Path(__file__).parent / "page"
_STEPS = 8191  # across each side of the box
_LEVELS = 254  # of a scalar; one more stands for no value
_UNITS = {"vorticity": "1/s", "q": "1/s²"}
_MAPS = "viridis", "turbo", "coolwarm", "fire", "ember", "ice", "ink", "gray"
_MODULES = "vector.js", "elements.js", "camera.js", "hand.js", "data.js", "scene.js", "pick.js", "clock.js", "page.js"
_SHADERS = "shade.frag", "lines.vert", "lines.frag", "box.vert", "box.frag", "solid.vert", "solid.frag", "ground.vert", "ground.frag"
_POLICY = "default-src 'none'; img-src data: blob:; base-uri 'none'; form-action 'none'"


class Page:
    """A page for browsers, .html, which a notebook shows in a frame that may run its script and nothing else."""

    def __init__(self, data: bytes) -> None:
        self.data = data

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it to an .html file, complete or not at all. Raises OSError if it cannot be written."""
        _core.check_extension(path_of(path), [".html"])
        _core.write_file(path_of(path), self.data)

    def __repr__(self) -> str:
        return f"<vdblic.Page {len(self.data)} bytes>"

    def _repr_html_(self) -> str:
        return (
            '<iframe title="The flow" sandbox="allow-scripts allow-downloads" style="width:100%;height:540px;border:0" '
            f'srcdoc="{html.escape(self.data.decode())}"></iframe>'
        )


def gathered(frames: Iterable[tuple[int, dict[str, Any], dict[str, Any]]]) -> tuple[Paths, list[float], dict[str, Any]]:
    """Paths of streaks, frame by frame: the paths, the frames' numbers and the metadata of the first.

    @param frames  in order: number, lines as read_lines() has them, metadata
    """
    paths = Paths(0)
    numbers: list[float] = []
    first: dict[str, Any] = {}
    for number, lines, metadata in frames:
        if not numbers:
            first = metadata
            told: Any = metadata.get("tail")
            paths.tail = float(told) if _is_number(told) and told > 0 else max([1.0, *lines["age"].tolist()[:100000]])
        paths.add(number, lines)
        numbers.append(float(number))
    return paths, numbers, first


def page(
    paths: Paths,
    title: str,
    frames: list[float],
    metadata: dict[str, Any],
    shown: Volume,
    say: Callable[[str], None],
    most: float = 25e6,
    solid: tuple[str, numpy.ndarray, numpy.ndarray] | None = None,
) -> bytes:
    """The page of paths.

    @param paths  finished  @param frames  in order  @param shown  a frame for the still  @param most  bytes of the page
    @param solid  its name for Renderer, points (n, 3) in world space, triangles (m, 3)
    """
    told: dict[str, Any] = {"title": title, "frames": frames, "tail": paths.tail, "steps": _STEPS}
    told |= {key: str(metadata[key]) for key in ("start", "length_unit") if key in metadata}
    told |= {key: float(metadata[key]) for key in ("time", "dt") if _is_number(metadata.get(key))}
    low, high = paths.points.min(axis=0), paths.points.max(axis=0)
    told |= {"low": low.tolist(), "high": high.tolist(), "stretch": _stretch(high - low)}
    told["radius"] = paths.radius * math.prod(told["stretch"]) ** (1 / 3)  # as vdblic_render has it
    told |= {"maps": {name: _colors(name) for name in _MAPS}}
    told["scalars"] = [_scale(name, values, told) for name, values in paths.scalars.items()]
    surface = _surface(*solid[1:], told) if solid else b""
    whole = len(paths.counts)
    options: dict[str, Any] = {"opacity_by": "q"} if shown.lines and "q" in shown.lines.scalars else {}
    if solid:
        options["solid"] = solid[0]
    picture = still(shown, most / 8, stretch=told["stretch"], **options)
    while True:
        data, told["lines"] = _zipped(_packed(paths, told) + surface), len(paths.counts)
        text = _assembled(told, data, picture)
        if len(text) <= most:
            break
        if len(paths.counts) < 2:
            raise _core.ParameterError(f"a page of {most:.0f} bytes holds no line; give it more")
        paths.chosen(_important(paths, 0.97 * most / len(text)))
    if len(paths.counts) < whole:
        say(f"the page shows {len(paths.counts)} of {whole} lines, the most important ones by {_measure(paths)}, to hold"
            f" {most / 1e6:.3g} MB; a larger `max_size` shows more")  # fmt: skip
    return text


def _is_number(value):
    return isinstance(value, (int, float)) and math.isfinite(value)


def _stretch(sides):
    """Factors that show what is flat: no side is less than a sixth of the longest."""
    return [max(1.0, sides.max() / 6 / side) if side > 0 else 1.0 for side in sides]


def _colors(name):
    """32 colours of a map, as #rrggbb."""
    linear = _core.colors_of(name, numpy.linspace(0, 1, 32, dtype=numpy.float32))
    display = numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * numpy.maximum(linear, 0) ** (1 / 2.4) - 0.055)
    return ["#" + bytes(color).hex() for color in numpy.rint(255 * numpy.clip(display, 0, 1)).astype(numpy.uint8)]


def _scale(name, values, told):
    """How a scalar is stored: asinh(value / bend) in even steps, so that rare large values leave steps to the others."""
    values = values[numpy.isfinite(values)]
    bend = float(numpy.median(abs(values))) if len(values) else 0.0
    bend = bend or (float(abs(values).max()) if len(values) else 0.0) or 1.0
    low, high = numpy.arcsinh([values.min() / bend, values.max() / bend]).tolist() if len(values) else (0.0, 1.0)
    shown = numpy.quantile(values, [0.01, 0.92, 0.99]).tolist() if len(values) else [0.0, 1.0, 1.0]
    unit = f"{told['length_unit']}/s" if name == "magnitude" and "length_unit" in told else _UNITS.get(name, "")
    return {"name": name, "unit": unit, "bend": bend, "low": low, "high": high, "shown": shown}


def _measure(paths):
    return "q" if "q" in paths.scalars else "chance"


def _important(paths, share):
    """Which lines to keep. Those of vortices by q; else an even choice, because ids are hashes."""
    if "q" in paths.scalars:
        begins = numpy.cumsum(paths.counts) - paths.counts
        rank = -numpy.maximum.reduceat(numpy.nan_to_num(paths.scalars["q"], nan=-numpy.inf), begins)
        kept = numpy.zeros(len(rank), bool)
        order = numpy.argsort(rank, kind="stable")
        points = numpy.cumsum(paths.counts[order])
        kept[order[: max(1, int(numpy.searchsorted(points, share * points[-1])))]] = True
        return kept
    order = numpy.argsort(paths.ids, kind="stable")
    kept = numpy.zeros(len(order), bool)
    kept[order[: max(1, int(share * len(order)))]] = True
    return kept


def _packed(paths, told):
    """The values of all points and lines, columns one after the other, as data.js reads them."""
    low, high = numpy.array(told["low"]), numpy.array(told["high"])
    sides = numpy.where(high > low, high - low, 1)
    columns = [numpy.rint((paths.points - low) / sides * _STEPS)[:, axis] for axis in range(3)]
    begin = min(paths.time.min(), told["frames"][0] - paths.tail)
    end = told["frames"][-1]
    tick = max((end - begin) / 60000, 1 / 256)
    told |= {"begin": begin, "tick": tick, "points": len(paths.time)}
    ticks = lambda times: numpy.rint((numpy.clip(times, begin, end + 4) - begin) / tick)
    columns.append(ticks(paths.time))
    lines = [paths.counts, 65535 * paths.own, ticks(paths.born), numpy.where(paths.gone < numpy.inf, ticks(paths.gone), 65535)]
    data = [_differences(column) for column in (*columns, *lines)]
    for scale in told["scalars"]:
        share = (numpy.arcsinh(paths.scalars[scale["name"]] / scale["bend"]) - scale["low"]) / (
            scale["high"] - scale["low"] or 1
        )
        steps = numpy.where(numpy.isfinite(share), numpy.rint(numpy.clip(share, 0, 1) * _LEVELS), 255).astype(numpy.uint8)
        data.append(numpy.diff(steps, prepend=steps[:1] * 0).tobytes())
    return b"".join(data)


def _surface(points, triangles, told):
    """The values of a solid's surface, columns one after the other, as data.js reads them."""
    points, triangles = thinned(points, triangles)
    low, high = points.min(axis=0), points.max(axis=0)
    steps = numpy.rint((points - low) / numpy.where(high > low, high - low, 1) * _STEPS)
    told["solid"] = {"points": len(points), "triangles": len(triangles), "low": low.tolist(), "high": high.tolist()}
    return b"".join(_differences(column) for column in (*steps.T, *triangles.T))


def _zipped(data):
    return base64.b64encode(gzip.compress(data, 6, mtime=0)).decode()


def _differences(values):
    """Whole numbers below 65536 as differences, positive ones even, their low bytes before their high ones."""
    steps = numpy.diff(values.astype(numpy.uint16), prepend=numpy.uint16(0)).view(numpy.int16)
    folded = ((steps << 1) ^ (steps >> 15)).view(numpy.uint16)
    return (folded & 255).astype(numpy.uint8).tobytes() + (folded >> 8).astype(numpy.uint8).tobytes()


def _caption(told):
    sides = (f"{high - low:.4g}" for low, high in zip(told["low"], told["high"]))
    return (
        f"{told['lines']} lines that follow the flow, from frame {told['frames'][0]:g} to {told['frames'][-1]:g}: each"
        f" moves with its bright end ahead. The box is {' × '.join(sides)} {told.get('length_unit', '')}".rstrip() + "."
    )


def _assembled(told, data, picture):
    """One file of all: modules one after the other, whose names differ, and a policy that allows nothing else."""
    read = lambda name: (_FILES / name).read_text(encoding="utf-8")
    modules = "\n".join(re.sub(r"(?m)^import [^;]*;\n|^export ", "", read(name)) for name in _MODULES)
    shaders = {name: read(name) for name in _SHADERS}
    script = f'"use strict";\n{{\nconst kShaders = {json.dumps(shaders)};\n{modules}\n}}'
    style = read("page.css")
    allowed = lambda text: f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
    policy = f"{_POLICY}; script-src {allowed(script)}; style-src {allowed(style)}"
    values = {
        "policy": policy,
        "title": html.escape(told["title"]),
        "style": style,
        "caption": html.escape(_caption(told)),
        "still": picture,
        "flow": json.dumps(told, allow_nan=False).replace("<", "\\u003c"),
        "data": data,
        "script": script,
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda match: values[match[1]], read("page.html")).encode()
