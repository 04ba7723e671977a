"""Textures of velocities, and velocities of known flows."""

from __future__ import annotations

import logging
import os
import pathlib
import tempfile
import warnings
from collections.abc import Iterable, Iterator, Sequence

import numpy

from . import _core
from .volumes import Grid, Volume, as_dictionaries

_LOG = logging.getLogger("vdblic")

Frame = Volume | Grid | numpy.ndarray | tuple[float, numpy.ndarray]


def advect(
    frames: str | os.PathLike | Iterable[Frame],
    *,
    frame_spacing: float | None = None,
    voxel_size: float | Sequence[float] = 1.0,
    method: str = "auflic",
    refine: int | Sequence[int] = 1,
    substeps: int = 1,
    life_span: int = 4,
    seed: int = 1,
    **parameters,
) -> Iterator[Volume]:
    """Yield the flow texture of every frame as it is finished: a Volume with `density`, `magnitude` and metadata.

    The textures are those of `vdblic_advect`, bit for bit.

    frames         the name of a file or a pattern such as 'v.%04d.vdb'; or any iterable of velocities: arrays
                   (x, y, z, 3) in world units per second, pairs (time, array), Grids or Volumes. An iterable is read
                   one frame ahead; frames count from 1.
    frame_spacing  seconds between frames; by default from the times, else 1/24
    voxel_size     of plain arrays: one length or three
    method         auflic, auflic-2004, uflic or lic
    refine         texture voxels along each axis in a voxel of the velocity: one number or three
    substeps       textures for each interval between frames
    life_span      of a seed, in frames
    parameters     what else the library's AdvectParams hold: frames, clamp_frames (of a pattern), velocity,
                   velocity_unit, velocity_scale, non_finite, carry, derived, mask, box, world_box, interpolation,
                   noise, preroll, lead_in, release_window, sample_spacing, tolerance, sharpen, noise_share, finish,
                   texture_name, scalars, precision

    Closing the iterator, an error in `frames` and Ctrl-C stop the run after the step in progress. Warnings are
    Python's, messages go to the logger `vdblic`. Any number of runs may go on at a time.
    """
    options = _checked(parameters)
    options |= {"method": method, "substeps": substeps, "life_span": life_span, "seed": seed}
    options["refine"] = [refine] * 3 if isinstance(refine, int) else list(refine)
    if frame_spacing is not None:
        options["frame_spacing"] = frame_spacing
    source = None
    if isinstance(frames, (str, os.PathLike)):
        options["input"] = os.fspath(frames)
    else:
        source = iter(frames)
    return _textures(options, source, voxel_size)


PARAMETERS = frozenset(
    "frames clamp_frames velocity velocity_unit velocity_scale non_finite carry derived mask box world_box"
    " interpolation noise preroll lead_in release_window sample_spacing tolerance sharpen noise_share finish"
    " texture_name scalars precision".split()
)


def _checked(parameters):
    for name in parameters:
        if name not in PARAMETERS:
            raise TypeError(f"advect() has no parameter '{name}'; it has {', '.join(sorted(PARAMETERS))}")
    return {name: value for name, value in parameters.items() if value is not None}


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
