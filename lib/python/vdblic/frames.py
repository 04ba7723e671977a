"""An iterator over velocities of any kind as frames."""

from __future__ import annotations

import contextlib
import dataclasses
import datetime
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy

from . import layouts
from .grids import Grid, Volume
from .labelled import clock, is_labelled, moments
from .progress import Teller, without_files
from .volumes import Lengths, as_volume, lengths_of, write

Frame = Any  # data for as_volume(), or (time, data)


class Frames:
    """A single-pass iterable of velocities as volumes, numbered from 1. `count` is their number, 0 if it is unknown."""

    def __init__(self, velocities: Any, voxel_size: Lengths, layout: str | None) -> None:
        self._frames, self.count = _of(velocities, layouts.checked(layout))
        self._of_one = FrameReader(voxel_size, layout)

    def __iter__(self) -> Iterator[Volume]:
        for frame in self._frames:
            is_timed = isinstance(frame, tuple) and len(frame) == 2
            yield self._of_one(*reversed(frame)) if is_timed else self._of_one(frame)


class FrameReader:
    """Makes volumes of velocities and their times, one by one. Errors name the frame's number."""

    def __init__(self, voxel_size: Lengths, layout: str | None, origin: Sequence[int] = (0, 0, 0)) -> None:
        self._lengths, self._layout = lengths_of(voxel_size), layouts.checked(layout)
        if numpy.shape(origin) != (3,) or numpy.any(numpy.asarray(origin) % 1):
            raise ValueError(f"`origin` cannot be {origin!r:.100}; it is 3 whole numbers")
        self._origin = [int(index) for index in origin]
        self._number = 0
        self._first: Any = None
        self.stamp = ""

    def go_on(self, first: str, last: str) -> None:
        """Continue the numbers at the last frame, and count dates from the first. @param first, last  stamps"""
        self._number = int(last.split()[1]) - 1
        if "T" in first:
            self._first = numpy.datetime64(first.split()[-1])

    def __call__(self, velocity: Any, time: Any = None) -> Volume:
        self._number += 1
        if self._number == 1:
            self._first = time
        try:
            self.stamp = f"velocity {self._number} at {_text_of(time)}"
            volume = as_volume(velocity, voxel_size=self._lengths, layout=self._layout)
            of_time = {} if time is None else clock(time, self._first)
        except ValueError as error:
            raise ValueError(f"frame {self._number}: {error}") from None
        shapes = [grid.shape for grid in volume.grids]
        if len(shapes) == 1 and len(shapes[0]) == 3:
            raise ValueError(f"frame {self._number} has the shape {shapes[0]}; a velocity has (x, y, z, 3)")
        return Volume(map(self._placed, volume.grids), volume.metadata | of_time)

    def _placed(self, grid: Grid) -> Grid:
        if not any(self._origin):
            return grid
        x, y, z = (int(index) + more for index, more in zip(grid.origin, self._origin))
        return dataclasses.replace(grid, origin=(x, y, z))


def _text_of(time):
    """The exact time as a word."""
    if time is None:
        return "no time"
    if isinstance(time, (datetime.datetime, numpy.datetime64)):
        return str(numpy.datetime64(time) + numpy.timedelta64(0, "s"))
    return str(clock(time)["time"])


def _of(velocities, layout):
    """An iterator over the frames, and their number."""
    if is_labelled(velocities):
        return moments(velocities)
    axes = getattr(velocities, "ndim", 0)
    if isinstance(velocities, (Mapping, Grid)) or axes == 4:
        return iter([velocities]), 1
    if axes == 5:
        return layouts.times(velocities, layout)
    try:
        return iter(velocities), len(velocities) if hasattr(velocities, "__len__") else 0
    except TypeError:
        raise TypeError(f"`velocities` cannot be {velocities!r}; it is a name of files or an iterable") from None


def is_path(data: Any) -> bool:
    """Whether data are a path or a pattern."""
    return isinstance(data, (str, os.PathLike))


@contextlib.contextmanager
def waiting(teller: Teller, parent: Path | None = None) -> Iterator[str]:
    """A folder in which frames wait as files, which messages do not name."""
    with tempfile.TemporaryDirectory(prefix=".vdblic-", dir=parent) as folder:
        teller.folder = folder
        try:
            yield folder
        except ValueError as error:
            told = without_files(str(error), folder)
            if told == str(error):
                raise
            raise ValueError(told) from None


def stored(
    volumes: Iterable[Volume], folder: str, name: str, *, dt: float | None = None, by_frame: bool = False
) -> str:
    """Write volumes into a folder. Returns the pattern. Raises ValueError if there are none.

    dt         seconds between frames without a time
    by_frame   whether to number files by `frame`, where volumes have it; else from 1 on
    """
    pattern, number = str(Path(folder) / f"{name}.%06d.vdb"), 0
    for number, volume in enumerate(volumes, 1):
        frame = volume.frame if by_frame and volume.frame is not None else number
        time = {} if dt is None or volume.time is not None else {"time": (number - 1) * dt}
        write(pattern % frame, volume, time)
    if number == 0:
        raise ValueError(f"there is no {name}")
    return pattern


def seconds_of(duration: Any) -> float:
    """A duration of Python or NumPy, or a number of seconds. Raises ValueError."""
    if hasattr(duration, "total_seconds"):
        return float(duration.total_seconds())
    return float(clock(numpy.asarray(duration)[()])["time"])
