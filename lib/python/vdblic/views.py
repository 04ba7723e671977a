"""Grids in a notebook: a line, and three slices through the middle."""

from __future__ import annotations

import base64
import html
from typing import Any

import numpy

from . import _core

_LARGEST = 256  # voxels along a side of a slice; longer sides are thinned out
_SHOWN = 200  # pixels of its longer side


def heading(text: str) -> str:
    """A line of text."""
    return f"<div><code>{html.escape(text)}</code></div>"


def slices(grid: Any, title: str) -> str:
    """A grid as HTML: its title, and the slices across z, y and x through the middle, of vectors their lengths."""
    if grid.ndim not in (3, 4) or 0 in grid.shape:
        return heading(title)
    cuts: list[Any] = []
    for across in 2, 1, 0:
        right, up = (axis for axis in range(3) if axis != across)
        index: list[Any] = [slice(None, None, 1 + size // _LARGEST) for size in grid.shape[:3]]
        index[across] = grid.shape[across] // 2
        lengths = grid.voxel_size * grid.shape[:3]
        cuts.append(("xyz"[right], "xyz"[up], *_cut(grid, tuple(index)), lengths[right], lengths[up]))
    finite = numpy.concatenate([values[shown] for _, _, values, shown, _, _ in cuts])
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    figures = "".join(_figure(cut, low, high) for cut in cuts)
    return f"{heading(f'{title} {low:.4g} to {high:.4g}')}<div>{figures}</div>"


def _cut(grid, index):
    """The values of a slice, rows from its top, and which of them are shown."""
    values = numpy.ma.asarray(grid.values[index]).astype(float)
    shown = ~numpy.ma.getmaskarray(values)
    values = values.filled(0)
    if values.ndim == 3:
        values, shown = numpy.linalg.norm(values, axis=2), shown.all(axis=2)
    shown &= numpy.isfinite(values)
    if grid.active is not None:
        shown &= numpy.ma.filled(grid.active, False)[index].astype(bool)
    return values.T[::-1], shown.T[::-1]


def _figure(cut, low, high):
    right, up, values, shown, width, height = cut
    share = (numpy.where(shown, values, low) - low) / (high - low or 1)
    colors = _core.colors_of("viridis", share.ravel()).reshape(*share.shape, 3)
    picture = numpy.concatenate([colors, numpy.ones((*share.shape, 1))], axis=2) * shown[..., None]
    data = base64.b64encode(_core.png(picture.astype(numpy.float32), (0.5, 0.5, 0.5))).decode()
    scale = _SHOWN / max(width, height)
    style = f"width:{max(width * scale, 1):.0f}px;height:{max(height * scale, 1):.0f}px;image-rendering:pixelated"
    return (
        '<figure style="display:inline-block;margin:4px">'
        f'<img src="data:image/png;base64,{data}" style="{style}"><figcaption>{right} → {up} ↑</figcaption></figure>'
    )
