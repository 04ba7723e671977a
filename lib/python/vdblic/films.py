"""Films, from velocities in a line."""

from __future__ import annotations

import base64
import datetime
import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy

from . import _core
from .frames import Frame, Frames, is_path, seconds_of, stored, waiting
from .parameters import checked, described
from .progress import Progress, Teller
from .volumes import Lengths, path_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import FilmOptions


class Film:
    """A film, .mp4, or a still, .png, which a notebook shows."""

    def __init__(self, data: bytes, kind: str = ".mp4") -> None:
        self.data, self.kind = data, kind

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it to a file of its kind."""
        _core.check_extension(path_of(path), [self.kind])
        _core.write_file(path_of(path), self.data)

    def __repr__(self) -> str:
        return f"<vdblic.Film {self.kind}, {len(self.data)} bytes>"

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.data).decode()
        if self.kind == ".png":
            return f'<img src="data:image/png;base64,{data}">'
        return f'<video controls loop autoplay muted src="data:video/mp4;base64,{data}"></video>'


def film(
    velocities: str | os.PathLike[str] | Iterable[Frame],
    output: str | os.PathLike[str] | None = None,
    *,
    voxel_size: Lengths = 1.0,
    layout: str | None = None,
    dt: float | datetime.timedelta | numpy.timedelta64 | None = None,
    progress: Progress = None,
    **options: Unpack[FilmOptions],
) -> Film:
    """Make a film, or a still of its middle frame, of velocities, as `vdblic_film` does. All that is not given is chosen
    from the data. It needs ffmpeg.

        vdblic.film(velocities, "flow.mp4", voxel_size=0.1)

    velocities, voxel_size, layout, progress   those of advect()
    output         an .mp4 or a .png; without it the film is only returned, for a notebook
    dt             seconds between velocities without times; by default 1/24
    options        of `vdblic_film`:

{parameters}
    Velocities in memory wait as files beside the output, and are removed. Raises ValueError, and OSError if the output
    cannot be written.
    """
    given = checked("film", options, OPTIONS)
    target = None if output is None else Path(os.fsdecode(path_of(output)))
    kind = ".mp4" if target is None else target.suffix
    if target is not None:
        _core.check_extension(path_of(target), [".mp4", ".png"])
    if is_path(velocities) and dt is not None:
        raise ValueError("`dt` is of velocities in memory; files tell their times")
    with Teller(progress, "film") as teller:
        if is_path(velocities) and target is not None:
            _core.film(path_of(velocities), path_of(target), given, teller)  # type: ignore[arg-type]
            return Film(target.read_bytes(), kind)
        if target is not None:
            _core.check_output(path_of(target))
        folder = None if target is None else target.parent
        with waiting(teller, folder) as place:
            pattern = velocities
            if not is_path(velocities):
                frames = Frames(velocities, voxel_size, layout)
                pattern = stored(frames, place, "velocity", dt=None if dt is None else seconds_of(dt))
            made = Path(place) / f"film{kind}"
            _core.film(path_of(pattern), path_of(made), given, teller)  # type: ignore[arg-type]
            data = made.read_bytes()
            if target is not None:
                os.replace(made, target)
    return Film(data, kind)


OPTIONS = described(film, _core.parameters("film"), without=("input", "output"))
