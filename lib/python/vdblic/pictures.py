"""Pictures of textures."""

from __future__ import annotations

import numpy

from . import _core
from .parameters import checked, described
from .volumes import Volume, as_dictionaries


class Renderer:
    """Ray casts textures. Options are those of `vdblic_render`; what is not given is chosen from the first texture.

{parameters}
    One renderer keeps camera and colours over a sequence. Not for several threads at a time; each may have its own.
    """

    def __init__(self, **options):
        self._picture = _core.Picture(checked("Renderer", options, OPTIONS))

    def __call__(self, texture: Volume, frame: int | None = None) -> numpy.ndarray:
        """The picture of a texture: (height, width, 4), rows from the top, linear light, premultiplied alpha.

        It equals the pixels of `vdblic_render`'s .exr files.
        """
        number = texture.frame if frame is None else frame
        return self._picture.render(as_dictionaries(texture.grids), texture.metadata, 1 if number is None else number)


OPTIONS = described(Renderer, _core.parameters("picture"))


def displayed(picture: numpy.ndarray, background: tuple[float, float, float] = (0.04, 0.05, 0.07)) -> numpy.ndarray:
    """A picture over a background as screens show it: (height, width, 3), sRGB in bytes, for Pillow or Matplotlib."""
    behind = numpy.array(background, numpy.float32)
    linear = numpy.where(behind <= 0.04045, behind / 12.92, ((behind + 0.055) / 1.055) ** 2.4)
    light = numpy.clip(picture[..., :3] + (1 - picture[..., 3:]) * linear, 0, 1)
    srgb = numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return numpy.round(255 * srgb).astype(numpy.uint8)
