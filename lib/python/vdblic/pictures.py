"""Pictures of textures."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy

from . import _core
from .grids import Grid, Volume
from .parameters import checked, described
from .volumes import as_dictionaries, as_volume


class Picture(numpy.ndarray):
    """A picture, (height, width, 4): rows from the top, linear light, premultiplied alpha.

    A notebook shows it over its `background`: red, green and blue as displayed, 0 to 1; six numbers are those at the
    bottom and those at the top.
    """

    background: Sequence[float] = (0.04, 0.05, 0.07)

    def __array_finalize__(self, source: Any) -> None:
        self.background = getattr(source, "background", Picture.background)

    def __array_wrap__(self, computed: Any, *_: Any) -> Any:
        """What is computed from a picture is a plain array or number."""
        return numpy.asarray(computed)[()]

    def _repr_png_(self) -> bytes | None:
        is_picture = self.ndim == 3 and self.shape[2] == 4 and self.size > 0 and self.dtype.kind == "f"
        return _core.png(self, self.background) if is_picture else None


class Renderer:
    """Ray casts textures. It has the options of `vdblic_render`; unset ones are chosen from the first texture.

{parameters}
    A list may stand for a text with commas, and tuples in it for colons: opacity=[(0, 0), (1, 0.5)],
    colors=[(0, "#102040"), (1, "#fff6d5")], annotate=["box", "axes"].

    The options of files, of films and of further channels are left out:
    {others}.

    One renderer keeps camera and colours over a sequence. Not for several threads at a time; each may have its own.
    Raises ValueError naming the option that cannot be used.
    """

    def __init__(self, **options: Any) -> None:
        self._picture = _core.Picture(checked("Renderer", options, OPTIONS))

    def __call__(self, texture: Volume | Grid | numpy.ndarray | Any, frame: int | None = None) -> Picture:
        """The picture of a texture: (height, width, 4), rows from the top, linear light, premultiplied alpha.

        A Volume has the texture's grid among others. A Grid, an array (x, y, z) or a DataArray is the texture, whatever
        its name (as_volume() tells which data can be used). The picture equals the pixels of `vdblic_render`'s .exr
        files, but annotations are drawn over it. Raises ValueError for data that are no texture.
        """
        volume = texture if isinstance(texture, Volume) else self._volume(texture)
        number = volume.frame if frame is None else frame
        pixels = self._picture.render(as_dictionaries(volume.grids), volume.metadata, 1 if number is None else number)
        picture = pixels.view(Picture)
        picture.background = tuple(self._picture.background)
        return picture

    def _volume(self, data: Any) -> Volume:
        volume = as_volume(data)
        if len(volume.grids) > 1:
            return volume
        grid = volume.grids[0]
        if numpy.ndim(grid.values) != 3:
            raise ValueError(
                f"the texture has the shape {grid.values.shape}; a texture has (x, y, z), and advect() makes textures "
                "of velocities"
            )
        return Volume([dataclasses.replace(grid, name=self._picture.texture or "density")], volume.metadata)


OPTIONS = described(Renderer, _core.parameters("picture"), others=_core.parameters("render"))


def displayed(picture: numpy.ndarray, background: Sequence[float] | None = None) -> numpy.ndarray:
    """A picture over a background as screens show it: (height, width, 3), sRGB in bytes, for Pillow or Matplotlib.

    Light that is brighter than a screen follows a tone curve, as in `.png` files (docs/render.md). It takes
    annotations along, which are drawn into the picture.

    background   red, green and blue as displayed, 0 to 1, or those at the bottom and at the top; by default
                 the picture's
    """
    if picture.ndim != 3 or picture.shape[2] != 4:
        raise ValueError(f"`picture` has the shape {picture.shape}; a picture has (height, width, 4)")
    if background is None:
        background = getattr(picture, "background", Picture.background)
    return _core.displayed(picture, background)
