"""Whether a volume holds what the points of a gridded file do, by arithmetic alone: value, direction and place.

A file is known by its points, which a test takes from xarray, netCDF4 or a formula: places in metres (n, 3) and velocities
in m/s (n, 3), NaN where there is none.
"""

import numpy
import pyopenvdb as vdb

RADIUS = 6_371_229.0
COUNT = 1000


def plane(longitude, latitude):
    """Metres from the middle, y along the meridians; the longitudes of a row run on across any cut."""
    longitude = numpy.unwrap(longitude, period=360, axis=-1)
    middle = [(numpy.nanmin(a) + numpy.nanmax(a)) / 2 for a in (longitude, latitude)]
    return (RADIUS * numpy.cos(numpy.radians(middle[1])) * numpy.radians(longitude - middle[0]),
            RADIUS * numpy.radians(latitude - middle[1]))


def random_voxels(path, seed=1):
    """Positions and velocities of random active voxels, and the size of a voxel."""
    grid = vdb.read(str(path), "velocity")
    inside = [index for box in grid.citerOnValues() for index in numpy.ndindex(*(b - a + 1 for a, b in zip(box.min, box.max)))
              for index in [tuple(numpy.add(box.min, index))]]
    chosen = numpy.random.default_rng(seed).choice(len(inside), COUNT)
    read = grid.getConstAccessor()
    indices = [tuple(map(int, inside[number])) for number in chosen]
    return (numpy.array([grid.transform.indexToWorld(index) for index in indices]),
            numpy.array([read.getValue(index) for index in indices]), numpy.array(grid.transform.voxelSize()))


def assert_on_axes(path, axes, velocity, tolerance=1e-5):
    """The volume is what the axes x, y and z [m] and the velocities (z, y, x, 3) on them are between their points."""
    at, found, _ = random_voxels(path)
    for slot, axis in enumerate(axes):
        order = numpy.argsort(axis)
        axes = [*axes[:slot], axis[order], *axes[slot + 1:]]
        velocity = numpy.take(velocity, order, 2 - slot)
    expected = numpy.zeros_like(found)
    lows, shares = [], []
    for slot, axis in enumerate(axes):
        low = numpy.clip(numpy.searchsorted(axis, at[:, slot]) - 1, 0, max(len(axis) - 2, 0))
        gap = axis[low + 1] - axis[low] if len(axis) > 1 else 1
        lows.append(low)
        shares.append((at[:, slot] - axis[low]) / gap if len(axis) > 1 else 0 * at[:, slot])
    for corner in numpy.ndindex(2, 2, 2):
        share = numpy.prod([part if up else 1 - part for part, up in zip(shares, corner)], axis=0)
        place = [numpy.minimum(low + up, len(axis) - 1) for low, up, axis in zip(lows, corner, axes)]
        values = velocity[place[2], place[1], place[0]]
        expected += numpy.where(numpy.isfinite(values) | (share[:, None] > 2e-3), share[:, None] * values, 0)
    scale = numpy.nanmax(numpy.abs(velocity))
    numpy.testing.assert_allclose(found, expected, atol=tolerance * scale, rtol=0)
    for slot, axis in enumerate(axes):
        reach = numpy.diff(axis).max() if len(axis) > 1 else numpy.inf
        assert (at[:, slot] >= axis[0] - reach).all() and (at[:, slot] <= axis[-1] + reach).all()
