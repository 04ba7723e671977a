"""Textures of velocities, and velocities of known flows."""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Iterable, Iterator, Sequence

import numpy

from . import _core
from .parameters import checked, described
from .volumes import Grid, Volume, as_dictionaries

_LOG = logging.getLogger("vdblic")

Frame = Volume | Grid | numpy.ndarray | tuple[float, numpy.ndarray]


def advect(
    velocities: str | os.PathLike | Iterable[Frame], /, *, voxel_size: float | Sequence[float] = 1.0, **parameters
) -> Iterator[Volume]:
    """Yield the flow texture of every frame as it is finished: a Volume with `density`, `magnitude` and metadata.

    The textures are those of `vdblic_advect`, bit for bit.

    velocities     the name of a file or a pattern such as 'v.%04d.vdb'; or any iterable of velocities: arrays
                   (x, y, z, 3) in world units per second, pairs (time, array), Grids or Volumes. An iterable is read
                   one frame ahead; frames count from 1.
    voxel_size     of plain arrays: one length or three
    parameters     of `vdblic_advect`:

{parameters}
    Closing the iterator ends the run; Ctrl-C ends it before the next step. Warnings are Python's, messages go to the
    logger `vdblic`. Any number of runs may go on at a time.
    """
    lengths = numpy.broadcast_to(numpy.asarray(voxel_size, float), 3)
    if not (numpy.isfinite(lengths).all() and (lengths > 0).all()):
        raise ValueError(f"voxel_size {voxel_size} must be one length above 0, or three")
    options = checked("advect", parameters, PARAMETERS)
    source = None
    if isinstance(velocities, (str, os.PathLike)):
        options["input"] = os.fspath(velocities)
    else:
        source = iter(velocities)
    return _textures(options, source, lengths)


PARAMETERS = described(advect, _core.parameters("advect"), without=("input",))


def _textures(options, source, voxel_size):
    frames = None
    if source is not None:
        volumes = (_volume(frame, voxel_size, number) for number, frame in enumerate(source, 1))
        frames = ((as_dictionaries(volume.grids), volume.metadata) for volume in volumes)
    textures = _core.Textures(options, frames, _tell)
    while (texture := textures.next()) is not None:
        grids, metadata = texture
        yield Volume((Grid(**grid) for grid in grids), metadata)


def _tell(kind, message):
    if kind == "warned":
        warnings.warn(message, stacklevel=3)
    else:
        _LOG.info(message)


def _volume(frame, voxel_size, number):
    """A frame of any kind as a volume."""
    if isinstance(frame, Volume):
        return frame
    if isinstance(frame, Grid):
        return Volume([frame])
    time = None
    if isinstance(frame, tuple) and len(frame) == 2:
        time, frame = frame
    values = numpy.asarray(frame)
    if values.ndim != 4 or values.shape[3] != 3:
        raise ValueError(f"frame {number} has the shape {values.shape}; a velocity has (x, y, z, 3)")
    transform = numpy.diag([*numpy.broadcast_to(voxel_size, 3), 1.0])
    metadata = {} if time is None else {"time": float(time)}
    return Volume([Grid(values, transform=transform, name="velocity", metadata=metadata)])


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
