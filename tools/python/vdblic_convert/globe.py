"""Longitude, latitude and height as a sparse shell of Cartesian voxels around the Earth.

World space: the unit is 1,000 km, x leads to 0 degrees east on the equator, z to the north pole. A height z is at the
radius R + E z. Voxel centres are at whole multiples of the voxel's size, whatever part of the Earth the data are of.
"""

import dataclasses

import numpy

from .errors import InputError, ParameterError
from .readers.around import ROUNDED, eastward, goes_around, has_value, spacing, with_poles
from .readers.earth import RADIUS
from .resample import flow_at
from .target import Points, Target

UNIT = 1e6  # m
R = RADIUS / UNIT
SPEED, HEIGHT, RIM, SOLID = GRIDS = "speed", "height", "rim", "solid"
MARGIN = 2  # voxels beyond the data: those of an interpolation across the rim
LAYER = 3  # voxels of a single layer
BODY = 3  # voxels of the Earth below the shell: what is deeper, nobody sees


@dataclasses.dataclass
class Extent:
    """What is known of the data after the first look: degrees, and metres of height."""

    west: float
    south: float
    north: float
    width: float  # less than 360 for a region
    spacing: float
    curved: bool
    low: float
    high: float

    def is_whole(self):
        return self.width == 360 and self.south == -90 and self.north == 90

    def holds(self, longitude, latitude):
        """Whether places are within the data, and not on their edge."""
        off = 10.0**-ROUNDED
        south, north = self.south + off * (self.south > -90), self.north - off * (self.north < 90)
        east = longitude - self.west
        return (
            (self.width == 360 or (east >= off) & (east <= self.width - off)) & (latitude >= south) & (latitude <= north)
        )


@dataclasses.dataclass
class Box(Target):
    """The box around the shell: it exists for one grid at a time, while that is written."""

    bytes_of_voxel = 40
    mend = "--voxel-size"


@dataclasses.dataclass
class Spread:
    """Values of some voxels of a box, an array for those who ask for one."""

    values: numpy.ndarray
    index: numpy.ndarray
    shape: tuple

    def __array__(self, dtype=None, copy=None):
        whole = numpy.zeros((numpy.prod(self.shape), *self.values.shape[1:]), self.values.dtype)
        whole[self.index] = self.values
        return whole.reshape(*self.shape, *self.values.shape[1:])


class Globe:
    """The shell, chosen by the first step. Readers hand the fields that they place in degrees to closed()."""

    def __init__(self, exaggeration=None, voxel=None):
        self.exaggeration, self.voxel = exaggeration, voxel
        self._extent = self._box = self._index = None
        self._margin = 0.0  # metres of height
        self._degrees = 1.0  # a metre's: VTK finds places quickly where cells are about as high as wide

    # What readers call.

    def closed(self, place, z, fields, velocity):
        """Fields (z, y, x[, 3]) continued across the seam, over the poles and beyond the rims; x, y and z in degrees.

        `place` is in degrees, `z` an axis or (z, y, x), `velocity` names components along x, y and z.
        """
        longitude, latitude, around = place.x, place.y, goes_around(place.x)
        valid = numpy.any([has_value(field) for field in fields.values()], axis=0)
        heights = numpy.broadcast_to(z.reshape(-1, 1, 1) if z.ndim == 1 else z, valid.shape)
        heights = heights[valid] if valid.any() else heights
        arrays = fields if z.ndim == 1 else fields | {"": z}  # heights of columns are closed as fields are
        if longitude.ndim == 1:
            longitude, columns = eastward(longitude, around)
            rows = numpy.argsort(latitude)
            latitude = latitude[rows]
            arrays = {name: values[:, rows][:, :, columns] for name, values in arrays.items()}
            latitude, arrays = with_poles(latitude, longitude, arrays, velocity) if around else (latitude, arrays)
        elif around:
            turn = 360.0 if longitude[0, -1] > longitude[0, 0] else -360.0
            wrap = lambda values: numpy.concatenate([values[..., -1:], values, values[..., :1]], axis=-1)
            longitude, latitude = wrap(longitude), wrap(latitude)
            longitude[:, 0] -= turn
            longitude[:, -1] += turn
            ends = numpy.r_[-1, 0 : place.x.shape[-1], 0]
            arrays = {name: values[:, :, ends] for name, values in arrays.items()}
        if self._extent is None:
            self._extent = Extent(
                west=longitude.min(), south=latitude.min(), north=latitude.max(), curved=longitude.ndim > 1,
                width=360.0 if around else numpy.ptp(longitude), spacing=spacing(longitude),
                low=heights.min(), high=heights.max(),
            )  # fmt: skip
        z = arrays.pop("", z)
        if self._margin and len(z) > 1:
            z, arrays = self._continued(z, arrays)
        return longitude, latitude, z * self._degrees, arrays

    @staticmethod
    def lacks_degrees(path):
        return InputError(
            f"{path}: --globe takes grids on longitude and latitude, by CF or as ROMS has them, and finds none; leave it "
            "out, or say which axes those are: --attribute 'x:units=degrees_east' 'y:units=degrees_north'"
        )

    def _continued(self, z, fields):
        """One level more below and above, in which the flow goes on."""
        lowest, highest = (0, -1) if z[0].mean() < z[-1].mean() else (-1, 0)
        below = z[lowest] - self._margin
        above = numpy.zeros_like(below) + max(z.max(), self._extent.high) + 2 * self._margin
        ends = (below, above) if lowest == 0 else (above, below)
        pad = lambda values: numpy.concatenate([values[:1], values, values[-1:]])
        return numpy.concatenate([ends[0][None], z, ends[1][None]]), {name: pad(field) for name, field in fields.items()}

    # What the tool calls.

    def choose(self, source, names):
        """Look at the first step and choose the voxels. Returns what to tell. Raises InputError, ParameterError."""
        source.parts(0, names, names)
        extent = self._extent
        if extent is None:
            raise self.lacks_degrees(source.path)
        voxel = self.voxel = self.voxel or R * numpy.radians(extent.spacing)
        depth = (extent.high - extent.low) / UNIT
        if not self.exaggeration:
            self.exaggeration = _rounded_down(R / 10 / depth) if depth else 1.0
        if depth:
            self._low, self._high = (R + self.exaggeration * height / UNIT for height in (extent.low, extent.high))
            self._margin = 1.001 * MARGIN * voxel * UNIT / self.exaggeration
            self._degrees, rim = numpy.degrees(self.exaggeration / RADIUS), MARGIN * voxel
        else:
            middle, rim = R + self.exaggeration * extent.low / UNIT, voxel * (LAYER - 1) / 2
            self._low, self._high = middle - voxel / 2, middle + voxel / 2
        self._bottom, self._top = self._low - rim, self._high + rim
        if self._bottom < R / 4:
            raise ParameterError(
                f"--exaggerate {self.exaggeration:g} puts {extent.low:g} m at a radius of {self._low:.3g}, where the "
                f"Earth's is {R:.3g} [1000 km]; choose a smaller one"
            )
        self._box = self._box_around()
        self._box.check()
        self._index = self._voxels()
        shell = f"that of {extent.low:g} to {extent.high:g} m is {100 * (self._high - self._low) / R:.2g} % of the "
        size = " x ".join(map(str, self._box.size))
        return f"a shell in {size} voxels of {voxel:.4g}, in units of 1000 km; {shell}" + (
            f"Earth's radius, because heights are exaggerated {self.exaggeration:g} times"
            if depth
            else f"Earth's radius: a single layer is {LAYER} voxels thick with its margin"
        )

    def grids(self, source, step, names, carry, where):
        """The arrays of a step by grid name, each with its mask (x, y, z) and metadata; the box; and what to tell."""
        radius, longitude, latitude = self._places()
        flows, extent = numpy.flatnonzero(radius >= self._bottom), self._extent
        height = (radius - R) / self.exaggeration * UNIT
        query = numpy.full(len(height), extent.low) if extent.low == extent.high else height
        at = numpy.stack([longitude, latitude, query * self._degrees], axis=1)[flows]
        flow, carried, mask, met, _ = flow_at(
            source, step, names, carry, lambda _: Points((len(flows), 1, 1), numpy.eye(4), at=at), where
        )
        known = numpy.ravel(mask)
        flow, there = flow.reshape(-1, 3)[known].astype(float), flows[known]
        speed = numpy.linalg.norm(flow, axis=1)
        world = self._cartesian(flow, longitude[there], latitude[there], radius[there], query[there])
        inside = numpy.minimum(radius - self._low, self._high - radius)[there]
        scalars = {SPEED: (speed, "m/s"), RIM: (inside, "Mm")}
        if extent.low < extent.high:
            scalars[HEIGHT] = height[there], "m"
        active = numpy.asarray(self._spread(numpy.ones(len(there), bool), there))
        grids = {"velocity": (self._spread(world.astype(numpy.float32), there), active, {})}
        for name, (values, unit) in scalars.items():
            grids[name] = self._spread(values.astype(numpy.float32), there), active, {"unit": unit}
        for name, values in carried.items():
            grids[name] = self._spread(values[mask] if values.shape[3] > 1 else values[mask][:, 0], there), active, {}
        solid = radius < self._low  # hides the lower margin
        if not extent.curved:  # there is no telling land from what lies beyond a turned grid
            solid[flows] |= ~known & (radius[flows] <= self._high)
        is_solid = numpy.asarray(self._spread(solid, slice(None)))
        grids[SOLID] = is_solid, is_solid, {"class": "fog volume"}
        east, north = flow[:, :2].mean(axis=0) if len(flow) else (0, 0)
        told = f"mean speed {speed.mean():.3g} m/s, of it {east:.3g} m/s eastward and {north:.3g} m/s northward"
        return grids, self._box, told if len(flow) else ""

    def metadata(self):
        return {"length_unit": "Mm", "exaggeration": float(self.exaggeration)}

    def _cartesian(self, flow, longitude, latitude, radius, height):
        """World units a second from m/s eastward, northward and upward: angular speeds stay, heights grow E-fold."""
        east, north, up = flow.T
        stretch = radius / (RADIUS + height)
        east, north, up = east * stretch, north * stretch, up * self.exaggeration / UNIT
        cos_lon, sin_lon = (wave(numpy.radians(longitude)) for wave in (numpy.cos, numpy.sin))
        cos_lat, sin_lat = (wave(numpy.radians(latitude)) for wave in (numpy.cos, numpy.sin))
        outward = up * cos_lat - north * sin_lat
        return numpy.stack(
            [outward * cos_lon - east * sin_lon, outward * sin_lon + east * cos_lon, north * cos_lat + up * sin_lat],
            axis=1,
        )

    def _box_around(self):
        """The box of voxels around the part of the shell that the data cover."""
        extent, steps = self._extent, 181
        longitude = numpy.radians(numpy.linspace(extent.west, extent.west + extent.width, 2 * steps)[:, None])
        latitude = numpy.radians(numpy.linspace(extent.south, extent.north, steps))
        latitude = numpy.append(latitude, 0.0) if extent.south < 0 < extent.north else latitude
        around = numpy.stack([numpy.cos(latitude) * numpy.cos(longitude), numpy.cos(latitude) * numpy.sin(longitude),
                              numpy.sin(latitude) + 0 * longitude], axis=-1).reshape(-1, 3)  # fmt: skip
        between = self._top * numpy.radians(max(extent.width / steps / 2, numpy.ptp(latitude) / steps)) ** 2 / 8
        corners = numpy.concatenate([around * self._top, around * (self._bottom - BODY * self.voxel)]) / self.voxel
        low = numpy.floor(corners.min(axis=0) - between / self.voxel).astype(int)
        high = numpy.ceil(corners.max(axis=0) + between / self.voxel).astype(int)
        matrix = numpy.diag([self.voxel] * 3 + [1.0])
        return Box(tuple(map(int, high - low + 1)), matrix, tuple(map(int, low)))

    def _voxels(self):
        """Numbers in the box, z fastest, of the voxels of shell and body, found plane by plane."""
        x, y, z = ((numpy.arange(n) + first) * self.voxel for n, first in zip(self._box.size, self._box.first))
        square, extent, found = y[:, None] ** 2 + z**2, self._extent, []
        for i, here in enumerate(x):
            radius = numpy.sqrt(square + here**2)
            index = numpy.flatnonzero((radius <= self._top) & (radius >= self._bottom - BODY * self.voxel))
            index += i * square.size
            found.append(index if extent.is_whole() else index[extent.holds(*self._places(index)[1:])])
        return numpy.concatenate(found)

    def _places(self, index=None):
        """Radius, and longitude and latitude in degrees, of voxels; by default of all."""
        x, y, z = (
            (at + first) * self.voxel
            for at, first in zip(numpy.unravel_index(self._index if index is None else index, self._box.size), self._box.first)
        )
        west = self._extent.west
        longitude = west + (numpy.degrees(numpy.arctan2(y, x)) - west) % 360
        latitude = numpy.degrees(numpy.arctan2(z, numpy.hypot(x, y)))
        return numpy.sqrt(x * x + y * y + z * z), longitude, latitude

    def _spread(self, values, which):
        return Spread(values, self._index[which], self._box.size)


def _rounded_down(number):
    """A number with one digit: at least half of the number itself."""
    power = 10.0 ** numpy.floor(numpy.log10(number))
    return float(f"{numpy.floor(number / power) * power:.1g}")
