"""Pictures of textures."""

from __future__ import annotations

import dataclasses
import os
import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy

from . import _core
from .grids import Grid, Volume
from .parameters import checked, described
from .volumes import as_dictionaries, as_volume, path_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import PictureOptions


class Picture:
    """A picture of a texture, which a notebook shows.

    As an array it is what a screen shows: (height, width, 3), sRGB in bytes, as in `.png` files, for Matplotlib and
    Pillow. Light that is brighter than a screen follows a tone curve (docs/render.md).

    >>> picture = Picture(numpy.zeros((2, 3, 4)), background=(1, 0, 0))
    >>> numpy.asarray(picture)[0, 0].tolist(), picture
    ([255, 0, 0], <vdblic.Picture 3 × 2>)
    """

    def __init__(self, linear: Any, background: Sequence[float] = (0.04, 0.05, 0.07)) -> None:
        self.linear = numpy.asarray(linear, numpy.float32)
        """(height, width, 4): rows from the top, linear light, premultiplied alpha."""
        self.background = tuple(background)
        """Red, green and blue behind the picture, as displayed, 0 to 1; six numbers are those at the bottom and those
        at the top."""
        if self.linear.ndim != 3 or self.linear.shape[2] != 4:
            raise ValueError(f"`linear` has the shape {self.linear.shape}; a picture has (height, width, 4)")

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, 3)."""
        return (*self.linear.shape[:2], 3)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> numpy.ndarray:
        if copy is False:
            raise ValueError("a picture as displayed is made anew; `linear` is there")
        return numpy.asarray(_core.displayed(self.linear, self.background), dtype)

    def __repr__(self) -> str:
        return f"<vdblic.Picture {self.linear.shape[1]} × {self.linear.shape[0]}>"

    def _repr_png_(self) -> bytes | None:
        return _core.png(self.linear, self.background) if self.linear.size > 0 else None

    def save(self, path: str | os.PathLike[str], *, precision: str = "half") -> None:
        """Write the picture as displayed to a .png, or linear light with alpha to an .exr of `precision` half or float.

        The file appears complete or not at all. Raises OSError if it cannot be written.
        """
        _core.check_extension(path_of(path), [".png", ".exr"])
        is_exr = pathlib.Path(path).suffix == ".exr"
        data = _core.exr(self.linear, precision) if is_exr else _core.png(self.linear, self.background)
        _core.write_file(path_of(path), data)


class Renderer:
    """Ray casts textures. It has the options of `vdblic_render`; unset ones are chosen from the first texture.

{parameters}
    A list may stand for a text with commas, and tuples in it for colons: opacity=[(0, 0), (1, 0.5)],
    colors=[(0, "#102040"), (1, "#fff6d5")], annotate=["box", "axes"]. One number is both sides of a `size`.

    The options of files, of films and of further channels are left out:
    {others}.

    One renderer keeps camera and colours over a sequence; `with` frees what it holds. Not for several threads at a time;
    each may have its own. Raises ValueError naming the option that cannot be used.

    >>> Renderer(size=64, look="ink")
    vdblic.Renderer(size=64, look='ink')
    """

    def __init__(self, **options: Unpack[PictureOptions]) -> None:
        self._options = checked("Renderer", options, OPTIONS)
        self._picture: Any = _core.Picture(self._options)

    def __call__(self, texture: Volume | Grid | numpy.ndarray | Any, frame: int | None = None) -> Picture:
        """The picture of a texture.

        A Volume has the texture's grid among others. A Grid, an array (x, y, z) or a DataArray is the texture, whatever
        its name (as_volume() tells which data can be used). `linear` of the picture equals the pixels of
        `vdblic_render`'s .exr files, but annotations are drawn over it. Raises ValueError for data that are no texture.
        """
        if self._picture is None:
            raise ValueError("the renderer is closed")
        volume = texture if isinstance(texture, Volume) else self._volume(texture)
        number = volume.frame if frame is None else frame
        pixels = self._picture.render(as_dictionaries(volume), volume.metadata, 1 if number is None else number)
        return Picture(pixels, self._picture.background)

    def __repr__(self) -> str:
        return f"vdblic.Renderer({', '.join(f'{key}={value!r}' for key, value in self._options.items())})"

    def close(self) -> None:
        """Free its memory."""
        self._picture = None

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _volume(self, data: Any) -> Volume:
        volume = as_volume(data)
        if len(volume.grids) > 1:
            return volume
        grid = volume.grids[0]
        if grid.ndim != 3:
            raise ValueError(
                f"the texture has the shape {grid.shape}; a texture has (x, y, z), and advect() makes textures of "
                "velocities"
            )
        return Volume([dataclasses.replace(grid, name=self._picture.texture or "density")], volume.metadata)


OPTIONS = described(Renderer, _core.parameters("picture"), others=_core.parameters("render"))
