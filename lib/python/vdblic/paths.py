"""Pathlines of streaks over a whole sequence, gathered from the tails of its frames."""

from __future__ import annotations

from typing import Any

import numpy

_SEAM = 0.02  # frames; ages are stored more exactly
_FADE = 1.5  # frames that fading in and out takes, as the method `streaks` has it
_SURE = 0.5  # share of its head's opacity from which a point tells that


class Paths:
    """Each moment of a streak's path is kept once, with the scalars of the first frame that has it.

    Attributes after finish(), of points, a path's one after the other: `points` (world space), `time` [frames], `scalars`;
    of paths: `ids`, `counts`, `own` (opacity of the head), `born` and `gone` (begin of fading in and end of fading out;
    infinite where it does neither).
    """

    def __init__(self, tail: float) -> None:
        self.tail, self.radius = tail, 0.0
        self._ids, self._ends, self._paths = (numpy.empty(0, kind) for kind in (numpy.int32, float, numpy.int64))
        self._made: list[Any] = []  # ids of paths
        self._count = 0
        self._kept: list[Any] = []
        self._heads: list[Any] = []
        self._own: list[Any] = []

    def add(self, frame: float, lines: dict[str, Any]) -> None:
        """Add the streaks of a frame; frames come in order."""
        ids, counts, age = lines["id"], lines["counts"], lines["age"].astype(float)
        if not len(ids):
            return
        self.radius = max(self.radius, float(lines["radius"].max()))
        last = numpy.cumsum(counts) - 1
        time = frame - age
        end, path = self._known(ids)
        joined = time[last - counts + 1] <= end + _SEAM
        path = numpy.where(joined, path, self._count + numpy.cumsum(~joined) - 1)
        self._count += int((~joined).sum())
        self._made.append(ids[~joined])
        of_point = numpy.repeat(numpy.arange(len(ids)), counts)
        new = ~joined[of_point] | (time > end[of_point] + _SEAM)
        scalars = {name: values[new] for name, values in lines["scalars"].items()}
        self._kept.append((path[of_point][new], time[new], lines["points"][new], scalars))
        share = 1 - age / self.tail
        sure = share > _SURE
        self._own.append((path[of_point][sure], lines["opacity"][sure] / share[sure]))
        heads = age[last] < _SEAM
        self._heads.append((path[heads], numpy.full(heads.sum(), float(frame)), lines["opacity"][last][heads]))
        self._ids, self._ends, self._paths = ids, numpy.maximum(time[last], numpy.where(joined, end, -numpy.inf)), path

    def _known(self, ids):
        """Of each line when the one of its number ended in the frame before, and its path."""
        if not len(self._ids):
            return numpy.full(len(ids), -numpy.inf), numpy.zeros(len(ids), numpy.int64)
        at = numpy.minimum(numpy.searchsorted(self._ids, ids), len(self._ids) - 1)
        return numpy.where(self._ids[at] == ids, self._ends[at], -numpy.inf), self._paths[at]

    def finish(self) -> Paths:
        path, time, self.points = (numpy.concatenate([kept[i] for kept in self._kept]) for i in range(3))
        order = numpy.lexsort((time, path))
        self.time, self.points, self.counts = time[order], self.points[order], numpy.bincount(path, minlength=self._count)
        self.scalars = {}
        for name in dict.fromkeys(name for kept in self._kept for name in kept[3]):
            missing = lambda kept: numpy.full(len(kept[0]), numpy.nan, numpy.float32)
            values = numpy.concatenate([kept[3].get(name, missing(kept)) for kept in self._kept])
            self.scalars[name] = values[order]
        self.ids = numpy.concatenate(self._made)
        self.own = numpy.zeros(self._count)
        for of, opacity in self._own:
            numpy.maximum.at(self.own, of, opacity)
        self.own = numpy.clip(self.own, 0.02, 1)
        self._fades()
        return self

    def _fades(self):
        of, frame, opacity = (numpy.concatenate([heads[i] for heads in self._heads]) for i in range(3))
        self.born, self.gone = numpy.full(self._count, -numpy.inf), numpy.full(self._count, numpy.inf)
        share = opacity / self.own[of]
        first, last = numpy.full(self._count, -1), numpy.full(self._count, -1)
        first[of[::-1]], last[of] = numpy.arange(len(of))[::-1], numpy.arange(len(of))
        several = (first >= 0) & (last > first)
        came = (frame[first] > frame.min()) | several & (share[first] < share[last])
        dim = (first >= 0) & (share[first] < 0.95) & came
        self.born[dim] = (frame - _FADE * share)[first[dim]]
        dim = several & (share[last] < 0.95) & (self.born < frame[last] - _FADE)
        self.gone[dim] = (frame + _FADE * share)[last[dim]]

    def chosen(self, paths: Any) -> Paths:
        """Those of the paths that a mask chooses, in place."""
        points = numpy.repeat(paths, self.counts)
        self.points, self.time = self.points[points], self.time[points]
        self.scalars = {name: values[points] for name, values in self.scalars.items()}
        for name in "ids", "counts", "own", "born", "gone":
            setattr(self, name, getattr(self, name)[paths])
        return self
