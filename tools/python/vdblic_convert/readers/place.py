"""Where the values of a field lie on the Earth or on a plane, and how its grid is turned against east."""

import dataclasses
import re

import numpy

from ..errors import InputError, needed
from ..units import measures
from .around import directions, goes_around
from .earth import local_plane, projected

LONGITUDE, LATITUDE = r"degrees?_?(east|e)", r"degrees?_?(north|n)"
STANDARD = {
    "X": ("longitude", "projection_x_coordinate", "grid_longitude"),
    "Y": ("latitude", "projection_y_coordinate", "grid_latitude"),
    "Z": r"(air_|sea_water_)?pressure|height.*|altitude|depth|geopotential_height|(ocean|atmosphere)_.*coordinate.*|.*"
    "model_level_number",
}
NAMES = {  # prefixes of axis names, for axes without attributes
    "X": r"x|lon|rlon|easting|i\b|ni\b|nx|west_east",
    "Y": r"y|lat|rlat|northing|j\b|nj\b|ny|south_north",
    "Z": r"z|dep|lev|height|alt|pres|plev|isobaric|k\b|st_ocean|sw_ocean|bottom_top|s_rho|s_w|sig|level",
}
PARAMETERS = "standard_parallel|scale_factor|(latitude|longitude)_of_(projection|central)|straight|grid_north|azimuth"
RIGHT = 1.01  # a factor of lengths that nobody needs to be told
STRAIGHT = 1.05  # the same that the plane along meridians may have, on which values stay as they are
TURNED = 0.005  # rad: a grid that is turned by less lies along the meridians


@dataclasses.dataclass
class Place:
    """x and y in metres, for a globe in degrees, axes or (y, x); `columns` puts a field's columns in their order, `torn` are points (y, x)
    whose cells the edge of the plane tears.

    `eastward` and `along` are two angles each against the world's x: the directions of east and north, and the
    directions of the grid's axes; None where they are unknown.
    """

    x: numpy.ndarray
    y: numpy.ndarray
    columns: object = dataclasses.field(default_factory=lambda: slice(None))
    torn: object = False
    eastward: tuple | None = None
    along: tuple | None = None
    in_degrees: bool = False


def axis_of(data, name):
    """X, Y or Z for a dimension; None if it is unknown. Raises InputError for contradictions."""
    known = name in data.variables and data.variables[name].ndim == 1
    text = data.text if known else lambda *_: ""
    unit, standard = text(name, "units"), text(name, "standard_name")
    by_unit = {"X": re.fullmatch(LONGITUDE, unit, re.I), "Y": re.fullmatch(LATITUDE, unit, re.I)}
    found = {axis for axis, match in by_unit.items() if match}
    found |= {axis for axis in "XY" if standard in STANDARD[axis]}
    found |= {"Z"} if re.fullmatch(STANDARD["Z"], standard) or text(name, "positive") or _is_pressure(unit) else set()
    declared = text(name, "axis").upper() or text(name, "cartesian_axis").upper()
    found |= {declared} & set("XYZ")
    if len(found) > 1:
        raise InputError(
            f"{data.path}: '{name}' contradicts itself: its units '{unit}', standard_name '{standard}', axis "
            f"'{declared}' and positive '{text(name, 'positive')}' are not of one axis; correct one by --attribute "
            f"'{name}:ATTRIBUTE=VALUE'"
        )
    if found:
        return found.pop()
    if match := re.match(r"([xyz])-coordinate", text(name, "long_name"), re.I):
        return match[1].upper()
    return next((axis for axis, names in NAMES.items() if re.match(names, name, re.I)), None)


def _is_pressure(unit):
    return bool(unit) and measures(unit, "Pa")


def ordered(longitude):
    """Longitudes [degrees] without jumps at a cut, (x) or (y, x), and the order of columns by which they rise or fall.

    Columns that repeat others are left out.
    """
    longitude = numpy.unwrap(longitude, period=360, axis=-1)
    if longitude.ndim == 2:
        first = numpy.unwrap(longitude[:, 0], period=360)
        longitude += (first - longitude[:, 0])[:, None]
    row = longitude if longitude.ndim == 1 else longitude[len(longitude) // 2]
    steps = numpy.diff(row)
    if len(row) > 2 and ((steps > 0).all() or (steps < 0).all() or longitude.ndim == 2 and abs(steps).max() < 20):
        once = numpy.abs(row - row[0]) < 360 - 0.01 * numpy.abs(steps).mean()
        return longitude[..., once], numpy.flatnonzero(once)
    around = numpy.round(row % 360, 9)
    _, order = numpy.unique(around, return_index=True)
    gaps = numpy.diff(around[order], append=around[order[0]] + 360)
    order = numpy.roll(order, -1 - int(numpy.argmax(gaps)))
    return numpy.unwrap(longitude[..., order], period=360, axis=-1), order


def angles(longitude, latitude):
    """Directions, against east, of a grid's rows and columns, at its points (y, x); degrees to radians.

    They follow chords through the sphere, also across a seam; along meridians and parallels of any pole these are the
    tangents.
    """
    out, east, north = directions(longitude, latitude)
    seam = int(goes_around(longitude))
    wide = numpy.concatenate([out[:, -1:], out, out[:, :1]], axis=1) if seam else out
    turns = []
    for axis in 1, 0:
        along = numpy.gradient(wide, axis=axis, edge_order=min(2, wide.shape[axis] - 1))[:, seam : seam + out.shape[1]]
        turns.append(numpy.arctan2((along * north).sum(axis=-1), (along * east).sum(axis=-1)))
    return tuple(turns)


def horizontal(source, field, dimensions):
    """The Place of a field on dimensions (z, y, x). Raises InputError where the file does not tell it."""
    data, names = source.data, (dimensions[2], dimensions[1])
    have = all(name in data.variables and data.variables[name].ndim == 1 for name in names)
    units = [data.text(name, "units") for name in names] if have else []
    coordinates = lambda unit, role: [source.in_unit(name, source.place(name, 0), unit, role=role) for name in names]
    on_earth = have and all(re.fullmatch(kind, unit, re.I) for kind, unit in zip((LONGITUDE, LATITUDE), units))
    if on_earth and not any(data.text(name, "standard_name").startswith("grid_") for name in names):
        return _on_earth(source, *(source.place(name, 0) for name in names), names)
    lonlat = _longitude_latitude(source, field, dimensions[1:])
    for other in source.c_grid.others(dimensions[1:]):
        if lonlat is None and (found := _longitude_latitude(source, field, other)) and min(found[0].shape) > 1:
            found = [numpy.unwrap(numpy.unwrap(found[0], period=360), period=360, axis=0), found[1]]
            lonlat = [source.c_grid.moved(values, other, dimensions[1:], data.sizes) for values in found]
    mapping = data.text(field, "grid_mapping").partition(":")[0]
    mapping = mapping if mapping in data.variables else ""
    if have and all(unit and measures(unit, "m") for unit in units):
        x, y = coordinates("m", "an axis")
        place = Place(x, y, along=(0.0, numpy.pi / 2))
        if lonlat is None and mapping:
            lonlat = _unprojected(data, mapping, x, y)
        if lonlat is not None:
            turn = angles(numpy.unwrap(lonlat[0], period=360), lonlat[1])[0] + (numpy.pi if x[0] > x[-1] else 0)
            place.eastward = -turn, numpy.pi / 2 - turn
        if lonlat is not None and source.globe:
            place = _on_earth(source, *lonlat, names)
            place.along = turn[:, place.columns], turn[:, place.columns] + numpy.pi / 2
        return place
    if lonlat is None and mapping and units and all(unit and measures(unit, "degree") for unit in units):
        lonlat = _unprojected(data, mapping, *coordinates("degree", "a turned axis"), degrees=True)
    if lonlat is not None:
        return _on_earth(source, *lonlat, names)
    if not have:
        raise InputError(f"{source.path}: the axes {dimensions[1]} and {dimensions[2]} have no coordinates")
    is_angle = [re.match("lon|lat", data.text(name, "standard_name") or name, re.I) is not None for name in names]
    for name, unit, angle in zip(names, units, is_angle):  # radians, or no angle at all
        if not unit and (not angle or abs(source.place(name, 0)).max() < 7):
            kind = ("degrees_east" if axis_of(data, name) == "X" else "degrees_north") if angle else "m"
            raise InputError(f"{source.path}: '{name}' has no units; say which: --attribute '{name}:units={kind}'")
    if all(is_angle) and all(axis_of(data, name) in "XY" for name in names):
        degrees = [source.in_unit(n, source.place(n, 0), "degree", "degrees", f"an axis, {n}") for n in names]
        return _on_earth(source, *degrees, names)
    told = " and ".join(f"'{name}' ({unit or 'no units'})" for name, unit in zip(names, units))
    raise InputError(
        f"{source.path}: the axes {told} are neither lengths nor longitude and latitude; say what they are: "
        f"--attribute '{names[0]}:units=m' or '{names[0]}:units=degrees_east', and so '{names[1]}'"
    )


def _on_earth(source, longitude, latitude, names):
    longitude, latitude, lost = _completed(numpy.array(longitude, float), numpy.array(latitude, float))
    longitude, columns = ordered(longitude)
    turn, torn = (0.0, numpy.pi / 2), False
    if longitude.ndim == 2:
        latitude, torn = latitude[:, columns], lost[:, columns]
        turn = angles(longitude, latitude)
        if torn.any():
            count = numpy.count_nonzero(torn)
            source.notes().append(f"{count} points at 0 degrees east and north are left out: they have no coordinates")
    elif names[0] not in source.explained:
        for name, values in zip(names, (longitude, latitude)):
            source.explain(name, "an axis on the Earth", "degrees", values)
    if source.globe:
        return Place(longitude, latitude, columns, torn, (0.0, numpy.pi / 2), turn, True)
    x, y, source.middle, north, told = on_plane(longitude, latitude, source.middle)
    source.notes().extend(told)
    if longitude.ndim == 2 and north is None:
        lost, torn = torn, torn.copy()
        for axis in 0, 1:
            apart = numpy.abs(numpy.diff(longitude, axis=axis)) > 120
            torn |= numpy.pad(apart, [(0, 1) if i == axis else (0, 0) for i in range(2)])
        if (torn & ~lost).any():
            count = numpy.count_nonzero(torn & ~lost)
            source.notes().append(f"{count} points by a pole are left out: the plane tears their cells")
    north = 0.0 if north is None else north
    return Place(x, y, columns, torn, (north, north + numpy.pi / 2), (turn[0] + north, turn[1] + north))


def _completed(longitude, latitude):
    """Longitude and latitude, (y, x) with places for points that have none, and where these are.

    Models write 0 for both on land that they leave out. The places are between those of neighbours.
    """
    lost = (longitude == 0) & (latitude == 0) if longitude.ndim == 2 else numpy.zeros(1, bool)
    if numpy.count_nonzero(lost) < 2 or lost.all():
        return longitude, latitude, lost & False
    known, place = numpy.flatnonzero(~lost.all(axis=1)), numpy.arange(longitude.shape[1])
    for row in known[lost[known].any(axis=1)]:
        there = numpy.flatnonzero(~lost[row])
        longitude[row] = numpy.interp(place, there, numpy.unwrap(longitude[row, there], period=360))
        latitude[row] = numpy.interp(place, there, latitude[row, there])
    nearest = known[numpy.abs(numpy.arange(len(lost))[:, None] - known).argmin(axis=1)]
    return longitude[nearest], latitude[nearest], lost


def on_plane(longitude, latitude, middle=None):
    """Metres from a middle, of degrees: axes along the meridians where lengths are then right, else projected, (y, x).

    The middle is a longitude, a latitude, and whether the plane is projected, by default of the data. Returns x, y, the
    middle, how meridians are turned against y if it is projected [radians], else None, and what to tell.
    """
    x, y, stretch, own = local_plane(longitude, latitude, middle and middle[:2])
    if not middle:
        out = directions(*(numpy.meshgrid(longitude, latitude) if longitude.ndim == 1 else (longitude, latitude)))[0]
        centre = out.mean(axis=(0, 1))
        centre /= numpy.linalg.norm(centre)
        middle = *own, stretch > STRAIGHT and not goes_around(longitude) and (out @ centre).min() > 0
        if middle[2]:
            middle = numpy.degrees(numpy.arctan2(centre[1], centre[0])), numpy.degrees(numpy.arcsin(centre[2])), True
    if not middle[2]:
        told = f"on the plane, lengths from west to east are too long by a factor of up to {stretch:.3g}; --globe has true ones"
        return x, y, middle, None, [told] * bool(stretch > RIGHT)
    if longitude.ndim == 1:
        longitude, latitude = numpy.meshgrid(longitude, latitude)
    x, y, north, factor = projected(longitude, latitude, middle)
    told = f"the plane is a stereographic projection about {middle[0]:.4g} degrees east, {middle[1]:.4g} degrees north"
    told += f", in which lengths are too long by a factor of up to {factor:.3g}" * bool(factor > RIGHT)
    return x, y, middle, north, [told]


def _longitude_latitude(source, field, dimensions):
    """Longitude and latitude (y, x) of a field: the variables that it names, else variables on its dimensions."""
    text, variables = source.data.text, source.data.variables
    declared = re.sub(r"\w+:", " ", text(field, "coordinates")).split() + [field]
    candidates = sorted(variables, key=lambda name: name not in declared)
    candidates = [name for name in candidates if variables[name].dims[-2:] == dimensions and variables[name].ndim < 4]
    found = []
    for kind, standard, start in (LONGITUDE, "longitude", "lon"), (LATITUDE, "latitude", "lat"): 
        def is_it(name, kind=kind, standard=standard, start=start):
            said, unit = text(name, "standard_name"), text(name, "units")
            return said == standard or not said and (
                re.fullmatch(kind, unit, re.I) or not unit and re.search(start, name, re.I)
            )

        name = next(filter(is_it, candidates), None)
        if name is None:
            return None
        values = source.place(name, 0)
        if not text(name, "units") and abs(values).max() < 7:
            raise InputError(f"{source.path}: '{name}' has no units; say which: --attribute '{name}:units=degrees'")
        found.append(source.in_unit(name, values, "degree", "degrees", standard))
    return [values.reshape(-1, *values.shape[-2:])[0] for values in found]


def _unprojected(data, mapping, x, y, degrees=False):
    """Longitude and latitude (y, x) of coordinates in metres, or of degrees, by the grid mapping. Raises InputError."""
    pyproj = needed("pyproj")
    try:
        told = {name.lower(): value for name, value in data.variables[mapping].attrs.items()}
        crs = pyproj.CRS.from_cf(told)
        assumed = [name for name in crs.to_cf() if re.match(PARAMETERS, name) and name not in told]
        if assumed:
            raise ValueError(f"it lacks {assumed[0]}; say it: --attribute '{mapping}:{assumed[0]}=NUMBER'")
        to_earth = pyproj.Transformer.from_crs(crs, crs.geodetic_crs, always_xy=True)
    except (pyproj.exceptions.ProjError, KeyError, ValueError, TypeError) as error:
        raise InputError(f"{data.path}: the grid mapping '{mapping}' is not understood: {error}") from None
    if crs.is_geographic != degrees:
        raise InputError(
            f"{data.path}: the grid mapping '{mapping}' is not of axes in {'degrees' if degrees else 'metres'}"
        )
    return to_earth.transform(*numpy.meshgrid(x, y))
