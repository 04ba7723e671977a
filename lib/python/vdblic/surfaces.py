"""The surface of a solid, small enough to stand in a page."""

from __future__ import annotations

import numpy

_MOST = 60_000  # triangles
_POINTS = 65_536  # whose numbers the page stores in 16 bits


def thinned(points: numpy.ndarray, triangles: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    """A surface with fewer triangles, if it has too many: points in a cell of a lattice become one at their mean.

    @param points  (n, 3)  @param triangles  (m, 3), numbers of points
    """
    cells, made = 256.0, (points, triangles)
    while len(made[0]) > _POINTS or len(made[1]) > _MOST:
        low, sides = points.min(axis=0), numpy.ptp(points, axis=0)  # each by itself: terrain is flat
        cell = ((points - low) / numpy.where(sides > 0, sides, 1) * cells).astype(numpy.int64)
        _, of, counts = numpy.unique(cell @ [1 << 40, 1 << 20, 1], return_inverse=True, return_counts=True)
        means = numpy.stack([numpy.bincount(of, points[:, axis]) / counts for axis in range(3)], axis=1)
        corners = of[triangles]
        a, b, c = corners.T
        made = means, corners[(a != b) & (b != c) & (c != a)]
        cells *= 0.8
    return made
