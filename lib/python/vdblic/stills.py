"""A still of streaks, small enough to stand in a page."""

from __future__ import annotations

import base64
import struct
import zlib
from typing import Any

import numpy

from .grids import Volume
from .pictures import Renderer

_SIZES = (960, 540), (800, 450), (640, 360), (480, 270), (320, 180)
_MOST = 150_000.0  # bytes


def still(volume: Volume, most: float = _MOST, **options: Any) -> str:
    """A picture of a volume as the address of an image that holds it.

    @param most  bytes of the address, of which the smallest may have more  @param options  of Renderer
    """
    for size in _SIZES:
        picture = numpy.asarray(Renderer(size=size, samples=2, **options)(volume))
        address = "data:image/png;base64," + base64.b64encode(_png(*_with_palette(picture))).decode()
        if len(address) <= min(most, _MOST):
            break
    return address


def _with_palette(picture):
    """The 256 most frequent of 4096 colours, (256, 3), and which of them each pixel is nearest to."""
    coarse = picture.astype(int) >> 4
    bins = coarse[..., 0] << 8 | coarse[..., 1] << 4 | coarse[..., 2]
    used, of_pixel, counts = numpy.unique(bins, return_inverse=True, return_counts=True)
    of_pixel = of_pixel.ravel()
    means = numpy.stack([numpy.bincount(of_pixel, picture[..., i].ravel()) / counts for i in range(3)], axis=1)
    kept = means[numpy.argsort(-counts, kind="stable")[:256]]
    nearest = ((means[:, None] - kept) ** 2).sum(axis=2).argmin(axis=1)
    palette = numpy.zeros((256, 3), numpy.uint8)
    palette[: len(kept)] = numpy.rint(kept)
    return palette, nearest[of_pixel].reshape(bins.shape).astype(numpy.uint8)


def _png(palette, pixels):
    """An image with a palette (ISO/IEC 15948)."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = numpy.pad(pixels, ((0, 0), (1, 0)))  # a filter of none before each
    head = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8, 3, 0, 0, 0)
    parts = (b"IHDR", head), (b"PLTE", palette.tobytes()), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts)
