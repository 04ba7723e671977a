"""Differences of volumes, and how well textures show their flow."""

from __future__ import annotations

import json
import os
import pathlib
import tempfile

from . import _core
from .volumes import Volume, write

Source = str | os.PathLike | Volume


def diff(
    a: Source,
    b: Source,
    *,
    frames: str | None = None,
    fail: float | None = None,
    relative: float | None = None,
    fail_percent: float | None = None,
    warn: float | None = None,
    ignored_metadata: list[str] | None = None,
) -> dict:
    """Compare two files, patterns or volumes as `vdblic_diff` does.

    Returns its report (docs/diff.md); report["verdict"] is same, warning or different.
    """
    options = _given(
        frames=frames,
        fail=fail,
        relative=relative,
        fail_percent=fail_percent,
        warn=warn,
        ignored_metadata=ignored_metadata,
    )
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        return json.loads(
            _core.diff(
                *(_path(source, pathlib.Path(folder) / name) for source, name in ((a, "a.vdb"), (b, "b.vdb"))), options
            )
        )


def coherence(
    velocity: str | os.PathLike,
    texture: str | os.PathLike,
    *,
    frames: str | None = None,
    velocity_grid: str | None = None,
    velocity_unit: str | None = None,
    velocity_scale: float | None = None,
    frame_spacing: float | None = None,
    texture_name: str | None = None,
    samples: int | None = None,
) -> dict:
    """Measure how a texture sequence moves with its flow, as `vdblic_coherence` does. Returns its report
    (docs/quality.md)."""
    options = _given(
        frames=frames,
        velocity=velocity_grid,
        velocity_unit=velocity_unit,
        velocity_scale=velocity_scale,
        frame_spacing=frame_spacing,
        texture_name=texture_name,
        samples=samples,
    )
    return json.loads(_core.coherence(os.fspath(velocity), os.fspath(texture), options))


def _given(**options):
    return {name: value for name, value in options.items() if value is not None}


def _path(source, scratch):
    if not isinstance(source, Volume):
        return os.fspath(source)
    write(scratch, source, compression="none")
    return str(scratch)
