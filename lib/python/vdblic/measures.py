"""Differences of volumes, and how well textures show their flow."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Union

from . import _core
from .frames import Frame, Frames, is_path, stored, waiting
from .grids import Volume
from .parameters import checked, described
from .progress import Progress, Teller
from .volumes import Lengths, as_dictionaries, as_volume, path_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import CoherenceOptions, DiffOptions

Source = Union[str, os.PathLike[str], Volume]


def diff(a: Source, b: Source, /, *, progress: Progress = None, **options: Unpack[DiffOptions]) -> dict[str, Any]:
    """Compare two files, patterns or volumes as `vdblic_diff` does; a volume with a volume or with one file.

    Returns its report (docs/measure.md), in which volumes are called a and b; report["verdict"] is same or
    different. Raises ValueError for data that cannot be read or compared. `progress` is that of advect().

{parameters}
    """
    given = checked("diff", options, DIFF_OPTIONS)
    if isinstance(a, Volume) or isinstance(b, Volume):
        return json.loads(_core.diff_volumes(_source(a), _source(b), given))  # type: ignore[no-any-return]
    with Teller(progress, "diff", "frames") as teller:
        return json.loads(_core.diff(path_of(a), path_of(b), given, teller))  # type: ignore[no-any-return]


def coherence(
    velocities: str | os.PathLike[str] | Iterable[Frame],
    textures: str | os.PathLike[str] | Iterable[Any],
    /,
    *,
    voxel_size: Lengths = 1.0,
    layout: str | None = None,
    progress: Progress = None,
    **options: Unpack[CoherenceOptions],
) -> dict[str, Any]:
    """Measure how a texture sequence moves with its flow, as `vdblic_coherence` does. Returns its report
    (docs/measure.md).

    velocities, voxel_size, layout, progress   those of advect()
    textures       those of advect(), or names of files. Both sequences in memory are written to a temporary folder

{parameters}
    """
    given = checked("coherence", options, COHERENCE_OPTIONS)
    with Teller(progress, "coherence", "frames") as teller, waiting(teller) as folder:
        if not is_path(velocities):
            velocities = stored(Frames(velocities, voxel_size, layout), folder, "velocity")
        if not is_path(textures):
            given_textures = [textures] if isinstance(textures, Volume) else textures
            textures = stored(
                (as_volume(texture, voxel_size=voxel_size, layout=layout) for texture in given_textures),  # type: ignore
                folder,
                "texture",
                by_frame=True,
            )
        report = _core.coherence(path_of(velocities), path_of(textures), given, teller)  # type: ignore[arg-type]
    return json.loads(report)  # type: ignore[no-any-return]


def _source(source):
    """A path, or the grids and the metadata of a volume."""
    return (as_dictionaries(source), source.metadata) if isinstance(source, Volume) else path_of(source)


DIFF_OPTIONS = described(diff, _core.parameters("diff"), without=("a", "b", "output", "skip_existing", "json"))
COHERENCE_OPTIONS = described(coherence, _core.parameters("coherence"), without=("input", "textures", "json"))
