"""Fields on longitude and latitude, (z, y, x[, 3]), that go around the Earth: their seam and their poles."""

import numpy

ROUNDED = 9  # decimals of a degree


def has_value(field):
    return numpy.isfinite(field) if field.ndim == 3 else numpy.isfinite(field).all(axis=3)


def spacing(longitude):
    return float(numpy.median(numpy.abs(numpy.diff(longitude, axis=-1))))


def goes_around(longitude):
    """Whether longitudes, an axis or (y, x), reach so far that only the seam is left between their ends."""
    row = longitude if longitude.ndim == 1 else longitude[len(longitude) // 2]
    return len(row) > 2 and abs(row[-1] - row[0]) + 1.5 * spacing(row) >= 360


def directions(longitude, latitude):
    """Unit vectors (..., 3) outward, eastward and northward at places in degrees."""
    lon, lat = numpy.radians(longitude), numpy.radians(latitude)
    cos_lon, sin_lon, cos_lat, sin_lat = numpy.cos(lon), numpy.sin(lon), numpy.cos(lat), numpy.sin(lat)
    return (numpy.stack([cos_lat * cos_lon, cos_lat * sin_lon, sin_lat], axis=-1),
            numpy.stack([-sin_lon, cos_lon, 0 * lat], axis=-1),
            numpy.stack([-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat], axis=-1))  # fmt: skip


def poles_in(point):
    """Whether the south and the north pole may lie in a cell of a grid of directions (y, x, 3)."""
    steps = [numpy.linalg.norm(numpy.diff(point, axis=axis), axis=2).max(initial=0) for axis in (0, 1)]
    return tuple(numpy.linalg.norm(point - (0, 0, pole), axis=2).min() <= max(steps) for pole in (-1, 1))


def closing(point, around):
    """The rows and columns that close a grid of directions (y, x, 3), as indices (y, x) each.

    A grid that goes around has its first column again after the last. Where its first or last row is folded, so that
    one half lies along the other, as between the two north poles of ocean models, that row follows once more, turned.
    """
    count = point.shape[1]
    columns = numpy.arange(count + around) % count
    rows, order = list(range(len(point))), [columns] * len(point)
    for end, next_to in ((0, 1), (len(point) - 1, len(point) - 2)) if around and len(point) > 1 else ():
        row, step = point[end], numpy.linalg.norm(point[end] - point[next_to], axis=1)
        for pivot in numpy.flatnonzero(numpy.linalg.norm(row - row[0], axis=1) <= 1.5 * step[0]):
            across = numpy.linalg.norm(row - row[(pivot - numpy.arange(count)) % count], axis=1)
            if (across <= 1.5 * step).all() and (across > 0.01 * step).any():
                at = 0 if end == 0 else len(rows)
                rows.insert(at, end)
                order.insert(at, (pivot - columns) % count)
                break
    return numpy.repeat(numpy.array(rows)[:, None], len(columns), axis=1), numpy.array(order)


def eastward(longitude, around):
    """Longitudes from west to east, those around the Earth from 0 on with a column more at both ends; and the columns."""
    if not around:
        columns = numpy.argsort(longitude)
        return longitude[columns] - 360 * numpy.floor(longitude[columns[0]] / 360), columns
    longitude = numpy.round(longitude, ROUNDED) % 360
    columns = numpy.argsort(longitude)
    columns = numpy.r_[columns[-1], columns, columns[0]]
    longitude = longitude[columns]
    longitude[0] -= 360
    longitude[-1] += 360
    return longitude, columns


def with_poles(latitude, longitude, fields, velocity):
    """Rows at the poles where the data stop short of them: of vectors the mean vector, of numbers the mean."""
    for end, pole in (0, -90.0), (-1, 90.0):
        gap = abs(pole - latitude[end])
        if not 1e-6 < gap <= 1.01 * abs(latitude[end] - latitude[end + 1 if end == 0 else end - 1]):
            continue
        latitude = numpy.insert(latitude, 0 if end == 0 else len(latitude), pole)
        fields = {name: _with_pole(name, values, longitude, end, pole, velocity) for name, values in fields.items()}
    return latitude, fields


def _with_pole(name, field, longitude, end, pole, velocity):
    slot = velocity.index(name) if name in velocity else 2
    if field.ndim == 3 and slot < 2:  # the mean of eastward vectors has a northward component elsewhere
        field = numpy.stack([field if axis == slot else 0 * field for axis in range(3)], axis=-1)
    ring = field[:, end]
    inner = ring[:, 1:-1]  # each longitude once
    known = numpy.isfinite(inner)
    mean = lambda values: numpy.where(known.any(axis=1), numpy.nansum(values, axis=1) / numpy.maximum(
        numpy.count_nonzero(known, axis=1), 1), numpy.nan)  # fmt: skip
    if field.ndim == 3:
        row = numpy.broadcast_to(mean(inner)[:, None], ring.shape)
    else:
        sign = numpy.sign(pole)  # at a pole north is against the meridian of the place, or along it
        turned = lambda vector, angle: numpy.stack([
            vector[..., 0] * numpy.cos(angle) + sign * vector[..., 1] * numpy.sin(angle),
            vector[..., 1] * numpy.cos(angle) - sign * vector[..., 0] * numpy.sin(angle), vector[..., 2]], axis=-1)  # fmt: skip
        angle = numpy.radians(longitude)
        whole = mean(turned(inner, -angle[1:-1]))
        row = turned(numpy.broadcast_to(whole[:, None], ring.shape), angle)
    parts = [row[:, None], field] if end == 0 else [field, row[:, None]]
    return numpy.concatenate(parts, axis=1)
