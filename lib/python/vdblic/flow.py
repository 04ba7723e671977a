"""Textures of velocities, and velocities of known flows."""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy

from . import _core, layouts
from .grids import Grid, Volume
from .labelled import clock, is_labelled, moments
from .parameters import checked, described
from .volumes import as_dictionaries, as_volume, lengths_of

_LOG = logging.getLogger("vdblic")

Frame = Any  # what as_volume() takes, or (time, of it)
_OF_FILES = "frames", "clamp_frames", "lead_in"


def advect(
    velocities: str | os.PathLike[str] | Iterable[Frame],
    /,
    *,
    voxel_size: float | Sequence[float] = 1.0,
    layout: str | None = None,
    **parameters: Any,
) -> Iterator[Volume]:
    """Yield the flow texture of every frame as it is finished: a Volume with `density`, `magnitude` and metadata.

    The textures are those of `vdblic_advect`, bit for bit.

    velocities     the name of a file or a pattern such as 'v.%04d.vdb'; or any iterable of velocities in world units
                   per second: arrays (x, y, z, 3), Grids, Volumes, data of xarray and VTK (as_volume() tells which), or
                   pairs of a time in seconds or a date, and one of these. An iterable is read one frame ahead; frames
                   count from 1. One of these by itself is one frame; data of xarray have a frame for each time, and
                   so has an array with an axis for it
    voxel_size     of arrays without coordinates: one length or three
    layout         order of the axes of arrays by the letters t, x, y, z and c (components, last unless they are named):
                   'zyx', 'tzyx', 'cxyz'. By default (x, y, z, 3); an array over time must tell
    parameters     of `vdblic_advect`; a list may stand for a text with commas: frames=[1, 2, 5]. Those of output files
                   and checkpoints are left out:

{parameters}
    Errors in parameters are raised at once, those in a frame when it is taken, with its number. Closing the iterator
    ends the run; Ctrl-C ends it before the next step. Warnings are Python's, messages go to the logger `vdblic`.
    Any number of runs may go on at a time.
    """
    lengths = lengths_of(voxel_size)
    options = checked("advect", parameters, PARAMETERS)
    frames = None
    if isinstance(velocities, (str, os.PathLike)):
        options["input"] = os.fspath(velocities)
    else:
        if given := [key for key in _OF_FILES if key in options]:
            raise ValueError(f"`{given[0]}` selects files; leave it out, and give the frames that are to be used")
        frames = _members(_frames(velocities, layouts.checked(layout)), lengths, layout)
    return _textures(_core.Textures(options, frames, _tell))


PARAMETERS = described(advect, _core.parameters("advect"), without=("input",))


def _textures(textures):
    while (texture := textures.next()) is not None:
        grids, metadata = texture
        yield Volume((Grid(**grid) for grid in grids), metadata)


def _tell(kind, message):
    if kind == "warned":
        warnings.warn(message, stacklevel=3)
    else:
        _LOG.info(message)


def _frames(velocities, layout):
    """The frames of velocities of any kind."""
    if is_labelled(velocities):
        return moments(velocities)
    axes = getattr(velocities, "ndim", 0)
    if isinstance(velocities, (Mapping, Grid)) or axes == 4:
        return iter([velocities])
    if axes == 5:
        return layouts.times(velocities, layout)
    try:
        return iter(velocities)
    except TypeError:
        raise TypeError(f"`velocities` cannot be {velocities!r}; it is a name of files or an iterable") from None


def _members(frames, voxel_size, layout):
    """The grids and the metadata of each frame, as the library's side takes them."""
    first = None
    for number, frame in enumerate(frames, 1):
        time = None
        if isinstance(frame, tuple) and len(frame) == 2:
            time, frame = frame
            first = time if number == 1 else first
        try:
            volume = as_volume(frame, voxel_size=voxel_size, layout=layout)
            of_time = {} if time is None else clock(time, first)
        except ValueError as error:
            raise ValueError(f"frame {number}: {error}") from None
        shapes = [numpy.shape(grid.values) for grid in volume.grids]
        if len(shapes) == 1 and len(shapes[0]) == 3:
            raise ValueError(f"frame {number} has the shape {shapes[0]}; a velocity has (x, y, z, 3)")
        yield as_dictionaries(volume.grids), volume.metadata | of_time


def synth(
    flow: str, size: Sequence[int], frames: Iterable[int], *, dt: float = 1 / 24, voxel_size: float = 0.1
) -> Iterator[Volume]:
    """Yield the velocity of an analytic, unsteady flow for each frame number, as `vdblic_synth` writes it.

    Frame 1 is at time 0. A name that does not exist gives a ValueError with all names.
    """
    for frame in frames:
        time = (frame - 1) * dt
        grid = Grid(**_core.synth(flow, tuple(size), time, voxel_size))
        grid.metadata |= {"frame": frame, "time": time, "dt": dt}
        yield Volume([grid])
