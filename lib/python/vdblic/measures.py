"""Differences of volumes, and how well textures show their flow."""

from __future__ import annotations

import json
import os
from typing import Any

from . import _core
from .grids import Volume
from .parameters import checked, described
from .volumes import as_dictionaries, path_of

Source = str | os.PathLike | Volume


def diff(a: Source, b: Source, /, **options: Any) -> dict[str, Any]:
    """Compare two files, patterns or volumes as `vdblic_diff` does; a volume with a volume or with one file.

    Returns its report (docs/measure.md), in which volumes are called a and b; report["verdict"] is same, warning or
    different. Raises ValueError for what cannot be read or compared.

{parameters}
    """
    options = checked("diff", options, DIFF_OPTIONS)
    compare = _core.diff_volumes if isinstance(a, Volume) or isinstance(b, Volume) else _core.diff
    return json.loads(compare(_source(a), _source(b), options))


def coherence(velocity: str | os.PathLike, texture: str | os.PathLike, /, **options: Any) -> dict[str, Any]:
    """Measure how a texture sequence moves with its flow, as `vdblic_coherence` does. Returns its report
    (docs/measure.md).

{parameters}
    """
    options = checked("coherence", options, COHERENCE_OPTIONS)
    return json.loads(_core.coherence(path_of(velocity), path_of(texture), options))


def _source(source):
    """A path, or the grids and the metadata of a volume."""
    return (as_dictionaries(source.grids), source.metadata) if isinstance(source, Volume) else path_of(source)


DIFF_OPTIONS = described(diff, _core.parameters("diff"), without=("a", "b", "output", "skip_existing", "json"))
COHERENCE_OPTIONS = described(
    coherence, _core.parameters("coherence"), without=("input", "texture", "json", "plot", "fps")
)
