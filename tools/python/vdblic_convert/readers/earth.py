"""From the Earth's coordinates to metres: longitude and latitude, pressure, vertical velocity in Pa/s."""

import numpy

from ..errors import needed

RADIUS = 6_371_229.0  # m, of the sphere that weather models use
GRAVITY = 9.80665  # m/s²
GAS_CONSTANT = 287.05  # J/(kg K), of dry air
# The standard atmosphere (ISO 2533): pressure [Pa], temperature [K] and
# height [m] at the base of a layer, and its lapse rate.
LAYERS = (
    (101325.0, 288.15, 0.0, -0.0065),
    (22632.06, 216.65, 11000.0, 0.0),
    (5474.889, 216.65, 20000.0, 0.001),
    (868.0187, 228.65, 32000.0, 0.0028),
)


def local_plane(longitude, latitude, middle=None, unordered=False):
    """Metres east and north of a middle, from degrees: y follows the meridians, x the parallel through the middle.

    The middle is a longitude and a latitude, by default of the data. Returns x, y, by how much lengths along x
    are too long off the middle at most (a factor), and the middle.
    """
    longitude = numpy.array(longitude, float)
    if not unordered:
        longitude = numpy.unwrap(longitude, period=360, axis=-1)
    latitude = numpy.asarray(latitude, float)
    own = [(value.min() + value.max()) / 2 for value in (longitude, latitude)]
    middle = middle or own
    longitude += 360 * numpy.round((middle[0] - own[0]) / 360)
    scale = numpy.cos(numpy.radians(middle[1]))
    x = RADIUS * scale * numpy.radians(longitude - middle[0])
    y = RADIUS * numpy.radians(latitude - middle[1])
    return x, y, scale / max(numpy.cos(numpy.radians(numpy.abs(latitude).max())), 1e-3), middle


def projected(longitude, latitude, middle):
    """Metres on a plane that touches the Earth in its middle, by the stereographic projection, from degrees (y, x).

    Returns x, y, by how much meridians are turned there against y [radians, counter-clockwise], and by what factor lengths
    are too long at most. Angles are true, and so are great circles through the middle, which are straight.
    """
    plane = needed("pyproj").Proj(proj="stere", lon_0=middle[0], lat_0=middle[1], R=RADIUS)
    factors = plane.get_factors(longitude, latitude)
    return *plane(longitude, latitude), numpy.radians(factors.meridian_convergence), factors.meridional_scale.max()


def standard_atmosphere(pressure):
    """Height [m] and temperature [K] of pressures [Pa] in the standard atmosphere."""
    pressure = numpy.asarray(pressure, float)
    for base, warmth, bottom, lapse in LAYERS:
        ratio = pressure / base
        here = warmth * ratio ** (-lapse * GAS_CONSTANT / GRAVITY)
        straight = -GAS_CONSTANT * warmth / GRAVITY * numpy.log(ratio)
        above = bottom + ((here - warmth) / lapse if lapse else straight)
        inside = pressure <= base
        height = numpy.where(inside, above, height) if bottom else above
        temperature = numpy.where(inside, here, temperature) if bottom else here
    return height, temperature


def upward_velocity(omega, pressure, temperature):
    """m/s from Pa/s, for air in hydrostatic balance."""
    return -omega * GAS_CONSTANT * temperature / (pressure * GRAVITY)
