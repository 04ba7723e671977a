#!/usr/bin/env python3
"""How well pictures are filled: the box around the pixels that differ from the background.

    tests/bench/framing.py PICTURE.png...        pictures without annotations; several of one folder: a film's frames

Prints, for each picture and for all together, the box's width and height as shares of the picture's, and how far its
middle is from the picture's, in the same shares. A row's background is that of its first pixel. Pixels count that
differ from it by more than 16 of 255 in a channel.
"""

import sys

import numpy
from PIL import Image

LEAST = 16


def bounds(path):
    """Low and high corner of what is seen, as shares of the picture's size; None if nothing is."""
    pixels = numpy.asarray(Image.open(path).convert("RGB")).astype(int)
    seen = (abs(pixels - pixels[:, :1]) > LEAST).any(axis=2)
    if not seen.any():
        return None
    ends = [numpy.flatnonzero(seen.any(axis=axis)) for axis in (0, 1)]
    size = numpy.array(seen.shape[::-1])
    return numpy.array([end[0] for end in ends]) / size, numpy.array([end[-1] + 1 for end in ends]) / size


def row(name, low, high):
    width, height = high - low
    right, down = (low + high) / 2 - 0.5
    return f"{name:32} width {width:.2f}  height {height:.2f}  middle {right:+.2f} {down:+.2f}"


def main():
    found = []
    for path in sys.argv[1:]:
        box = bounds(path)
        print(row(path.rsplit("/", 1)[-1], *box) if box else f"{path}: nothing is seen")
        if box:
            found.append(box)
    if len(found) > 1:
        print(row("all", numpy.min([low for low, _ in found], axis=0), numpy.max([high for _, high in found], axis=0)))


if __name__ == "__main__":
    main()
