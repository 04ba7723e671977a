"""Longitude, latitude and height as a sparse shell of Cartesian voxels around the Earth.

World space: the unit is 1,000 km, x leads to 0 degrees east on the equator, z to the north pole. A height z is at the
radius R + E z. Voxel centres are at whole multiples of the voxel's size, whatever part of the Earth the data are of.
"""

import dataclasses

import numpy

from .errors import InputError, ParameterError
from .readers.around import ROUNDED, closing, directions, eastward, goes_around, has_value, poles_in, spacing, with_poles
from .readers.earth import RADIUS
from .resample import flow_at
from .target import Points, Target

UNIT = 1e6  # m
R = RADIUS / UNIT
SPEED, HEIGHT, RIM, SOLID = GRIDS = "speed", "height", "rim", "solid"
MARGIN = 2  # voxels beyond the data: those of an interpolation across the rim
LAYER = 3  # voxels of a single layer
BODY = 3  # voxels of the Earth below the shell: what is deeper, nobody sees
THICK = 0.05  # of its radius, to both sides, is a single layer of a turned grid: its cells are flat, the Earth is not


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

        `place` is in degrees, `z` an axis or (z, y, x), `velocity` names components along x, y and z. On a turned grid,
        (y, x), x, y and z are Cartesian in world space, and so are the components.
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
        else:
            out, *_ = axes = directions(longitude, latitude)
            arrays = {name: _vectors(values, velocity.index(name), axes) if name in velocity else values
                      for name, values in arrays.items()}  # fmt: skip
            rows, columns = closing(out, around)
            out = out[rows, columns]
            arrays = {name: values[:, rows, columns] for name, values in arrays.items()}
        if self._extent is None:
            curved = longitude.ndim > 1
            south, north = poles_in(out) if curved else (False, False)
            self._extent = Extent(
                west=0.0 if around else longitude.min(), south=-90.0 if south else latitude.min(),
                north=90.0 if north else latitude.max(),
                width=360.0 if around or south or north else numpy.ptp(longitude), curved=curved,
                spacing=_median_step(out) if curved and not around else spacing(longitude),
                low=heights.min(), high=heights.max(),
            )  # fmt: skip
        z = arrays.pop("", z)
        if self._margin and len(z) > 1:
            z, arrays = self._continued(z, arrays)
        if longitude.ndim == 1:
            return longitude, latitude, z * self._degrees, arrays
        radius = R + (self.exaggeration or 1.0) * z.reshape(*z.shape, *[1] * (3 - z.ndim)) / UNIT
        if len(z) == 1:
            radius = numpy.concatenate([radius * (1 - THICK), radius * (1 + THICK)])
            arrays = {name: numpy.repeat(values, 2, axis=0) for name, values in arrays.items()}
        return *(radius * part for part in numpy.moveaxis(out, -1, 0)), arrays

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
        out, *_ = axes = directions(longitude[flows], latitude[flows])
        if extent.curved:
            at = out * (R + self.exaggeration * query[flows] / UNIT)[:, None]
        else:
            at = numpy.stack([longitude, latitude, query * self._degrees], axis=1)[flows]
        points, seen = Points((len(flows), 1, 1), numpy.eye(4), at=at), []
        flow, carried, mask, met, _ = flow_at(source, step, names, carry, lambda f: seen.append(f) or points, where)
        known = numpy.ravel(mask)
        flow, there, axes = flow.reshape(-1, 3)[known].astype(float), flows[known], [axis[known] for axis in axes]
        if extent.curved:
            flow = numpy.stack([(flow * axes[i]).sum(axis=1) for i in (1, 2, 0)], axis=1)
            for slot, name in enumerate(names):
                if name in carried:
                    carried[name][mask] = flow[:, slot, None]
        speed = numpy.linalg.norm(flow, axis=1)
        world = self._cartesian(flow, axes, radius[there], query[there])
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
        empty = numpy.flatnonzero(~known & (radius[flows] <= self._high))
        if extent.curved:  # it has land where it has cells, while one along meridians fills its extent
            empty = empty[seen[0].holds(Points((len(empty), 1, 1), numpy.eye(4), at=at[empty]))]
        solid[flows[empty]] = True
        is_solid = numpy.asarray(self._spread(solid, slice(None)))
        grids[SOLID] = is_solid, is_solid, {"class": "fog volume"}
        east, north = flow[:, :2].mean(axis=0) if len(flow) else (0, 0)
        told = f"mean speed {speed.mean():.3g} m/s, of it {east:.3g} m/s eastward and {north:.3g} m/s northward"
        return grids, self._box, told if len(flow) else ""

    def metadata(self):
        return {"length_unit": "Mm", "exaggeration": float(self.exaggeration)}

    def _cartesian(self, flow, axes, radius, height):
        """World units a second from m/s eastward, northward and upward: angular speeds stay, heights grow E-fold."""
        out, east, north = axes
        stretch = (radius / (RADIUS + height))[:, None]
        return stretch * (flow[:, :1] * east + flow[:, 1:2] * north) + self.exaggeration / UNIT * flow[:, 2:] * out

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


def _vectors(field, slot, axes):
    """Cartesian vectors of a component (z, y, x), or of one eastward, northward and upward, (z, y, x, 3)."""
    out, east, north = axes
    if field.ndim == 3:
        return (field[..., None] * (east, north, out)[slot]).astype(numpy.float32)
    return (field[..., :1] * east + field[..., 1:2] * north + field[..., 2:] * out).astype(numpy.float32)


def _median_step(out):
    """The spacing of columns, in degrees, of directions (y, x, 3)."""
    return float(numpy.degrees(numpy.median(numpy.linalg.norm(numpy.diff(out, axis=1), axis=2))))


def _rounded_down(number):
    """A number with one digit: at least half of the number itself."""
    power = 10.0 ** numpy.floor(numpy.log10(number))
    return float(f"{numpy.floor(number / power) * power:.1g}")
