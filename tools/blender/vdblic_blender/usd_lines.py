"""Lines of a layer that vdblic_export wrote (.usda), read frame by frame: older Blenders make no curves of USD.

Such a layer has one value or one frame's sample a line, so that any frame is found without the others.
"""

import bisect
import dataclasses
import pathlib
import re

import numpy

_DECLARED = re.compile(rb"\s*(?:uniform )?\w+(?:\[\])? ([\w:]+)(\.timeSamples)? = ")
_SAMPLE = re.compile(rb"\s*(-?\d+): ")
_HEAD = re.compile(rb'\s*(upAxis|startTimeCode|endTimeCode) = "?([-\w.]+)')
_FEW = 1 << 12  # characters of a line in which its name is looked for
_ALL = None  # the frame of a value without samples


class LayerError(ValueError):
    """A layer without lines to show; the message names the file and the mend."""


@dataclasses.dataclass
class Moment:
    """The lines of a frame: points a line, and of each point place, radius and scalars by name."""

    counts: numpy.ndarray
    points: numpy.ndarray
    radius: numpy.ndarray
    scalars: dict


class Layer:
    """Where a layer has the values of its lines. Raises LayerError, OSError."""

    def __init__(self, path):
        self.path = str(path)
        self._places = {}  # name → {frame: (offset, length)}
        self._head = {}
        with open(path, "rb") as file:
            self._scan(file)
        if "points" not in self._places:
            raise LayerError(f"{path}: no lines; write a layer of streaks as lines with vdblic_export -o flow.usda")
        self.frames = sorted(frame for frame in self._places["points"] if frame is not _ALL)

    def _scan(self, file):
        name, here, within = "", 0, False
        for line in file:
            start = line[:_FEW]
            if b" def " in start or start.startswith(b"def "):
                if within:
                    return
                within = b"BasisCurves" in start
            elif not within and (told := _HEAD.match(start)):
                self._head[told[1].decode()] = told[2].decode()
            elif within and (declared := _DECLARED.match(start)):
                name = declared[1].decode()
                if not declared[2]:
                    self._places[name] = {_ALL: (here + declared.end(), len(line) - declared.end())}
            elif within and (sample := _SAMPLE.match(start)):
                self._places.setdefault(name, {})[int(sample[1])] = here + sample.end(), len(line) - sample.end()
            here += len(line)

    @property
    def is_y_up(self):
        return self._head.get("upAxis") == "Y"

    @property
    def span(self):
        """The first and the last frame."""
        told = [int(float(self._head[key])) for key in ("startTimeCode", "endTimeCode") if key in self._head]
        return (self.frames[0], self.frames[-1]) if self.frames else (*told, told[-1])[:2] if told else (1, 1)

    @property
    def scale(self):
        return tuple(self._numbers("xformOp:scale", _ALL)) if "xformOp:scale" in self._places else (1, 1, 1)

    def sample_at(self, frame):
        """The frame that is shown at a frame: the last one that is not later, else the first."""
        return self.frames[max(bisect.bisect_right(self.frames, frame) - 1, 0)] if self.frames else _ALL

    def moment(self, sample):
        """The lines of a frame of sample_at(). Raises LayerError, OSError."""
        try:
            counts = self._numbers("curveVertexCounts", sample).astype(int)
            points = self._numbers("points", sample).reshape(-1, 3)
            radius = self._numbers("widths", sample) / 2
        except KeyError as missing:
            raise LayerError(f"{self.path}: its lines have no {missing} at frame {sample}; write it again") from None
        scalars = {"displayOpacity": "primvars:displayOpacity"}
        vertex = (name for name in self._places if name.startswith("primvars:"))
        scalars |= {name.partition(":")[2]: name for name in vertex if not name.startswith("primvars:display")}
        found = {name: self._numbers(key, sample) for name, key in scalars.items() if sample in self._places.get(key, ())}
        if counts.sum() != len(points) or len(radius) != len(points) or (counts < 1).any():
            raise LayerError(f"{self.path}: its lines do not have the points of frame {sample}; write it again")
        return Moment(counts, points, radius, {name: values for name, values in found.items() if len(values) == len(points)})

    def _numbers(self, name, sample):
        offset, length = self._places[name][sample]
        with open(self.path, "rb") as file:
            file.seek(offset)
            text = file.read(length).partition(b" (interpolation")[0].rstrip().rstrip(b",").translate(None, b"[]() ")
        return numpy.fromstring(text, numpy.float32, sep=",") if text else numpy.zeros(0, numpy.float32)


def layer_of(path, _known={}):
    """A layer that was read before, unless the file changed since. Raises LayerError, OSError."""
    stamp = pathlib.Path(path).stat()
    key = stamp.st_mtime_ns, stamp.st_size
    if _known.get(path, (None,))[0] != key:
        _known[path] = key, Layer(path)
    return _known[path][1]
