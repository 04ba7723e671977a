"""Differences of volumes, and how well textures show their flow."""

from __future__ import annotations

import json
import os
import pathlib
import tempfile

from . import _core
from .parameters import checked, described
from .volumes import Volume, write

Source = str | os.PathLike | Volume


def diff(a: Source, b: Source, /, **options) -> dict:
    """Compare two files, patterns or volumes as `vdblic_diff` does.

    Returns its report (docs/diff.md); report["verdict"] is same, warning or different.

{parameters}
    """
    options = checked("diff", options, DIFF_OPTIONS)
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        return json.loads(
            _core.diff(
                *(_path(source, pathlib.Path(folder) / name) for source, name in ((a, "a.vdb"), (b, "b.vdb"))), options
            )
        )


def coherence(velocity: str | os.PathLike, texture: str | os.PathLike, /, **options) -> dict:
    """Measure how a texture sequence moves with its flow, as `vdblic_coherence` does. Returns its report
    (docs/quality.md).

{parameters}
    """
    options = checked("coherence", options, COHERENCE_OPTIONS)
    return json.loads(_core.coherence(os.fspath(velocity), os.fspath(texture), options))


def _path(source, scratch):
    if not isinstance(source, Volume):
        return os.fspath(source)
    write(scratch, source, compression="none")
    return str(scratch)


DIFF_OPTIONS = described(diff, _core.parameters("diff"), without=("a", "b", "output", "skip_existing", "json"))
COHERENCE_OPTIONS = described(
    coherence, _core.parameters("coherence"), without=("input", "texture", "json", "plot", "fps")
)
