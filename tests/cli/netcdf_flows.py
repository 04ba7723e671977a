"""NetCDF files that hold a known flow, for the tests of vdblic_import: the one of flows.py, over a plane in metres."""

import netCDF4
import numpy

from flows import GRADIENT, MEAN

RADIUS = 6_371_229.0
GRAVITY = 9.80665
LENGTH = numpy.array([1e5, 1e5, 1e4])  # m, over which the flow changes as that of flows.py does over 1


def wind(positions, time=0.0):
    """The velocity [m/s] at positions [m] (..., 3)."""
    return (MEAN + positions / LENGTH @ GRADIENT.T) * (1 + time)


def plane(longitude, latitude):
    """Metres from the middle."""
    middle = [(a.min() + a.max()) / 2 for a in (longitude, latitude)]
    return (RADIUS * numpy.cos(numpy.radians(middle[1])) * numpy.radians(longitude - middle[0]),
            RADIUS * numpy.radians(latitude - middle[1]))


def positions_of(x, y, z):
    """Positions (z, y, x, 3) of axes, or of x, y on (y, x) and z on (z, y, x)."""
    shape = (len(z), *(x.shape if x.ndim == 2 else (len(y), len(x))))
    x = numpy.broadcast_to(x, shape) if x.ndim == 2 else numpy.broadcast_to(x[None, None, :], shape)
    y = numpy.broadcast_to(y, shape) if y.ndim == 2 else numpy.broadcast_to(y[None, :, None], shape)
    return numpy.stack([x, y, z if z.ndim == 3 else numpy.broadcast_to(z[:, None, None], shape)], axis=-1)


def create(path, **dimensions):
    data = netCDF4.Dataset(path, "w")
    for name, size in dimensions.items():
        data.createDimension(name, size)
    return data


def put(data, name, dimensions, values, **attributes):
    variable = data.createVariable(name, "f8", dimensions, fill_value=attributes.pop("fill_value", None))
    variable.setncatts(attributes)
    variable[:] = values


def write_pressure_levels(path, hours, omega=True):
    """Winds like those of a reanalysis: pressure levels, latitudes from north to south, Pa/s, packed times."""
    longitude, latitude = numpy.linspace(355, 365, 11) % 360, numpy.linspace(48.5, 45.5, 7)
    level = numpy.array([1000.0, 850, 700, 500, 300])
    x, y = plane(numpy.linspace(-5, 5, 11), latitude)
    height = 1000.0 + 2500 * numpy.arange(5)[:, None, None] + 40 * numpy.arange(11) + 10 * numpy.arange(7)[:, None]
    data = create(path, time=len(hours), level=5, latitude=7, longitude=11)
    put(data, "time", ("time",), hours, units="hours since 1999-12-31 18:00:00", calendar="standard")
    put(data, "longitude", ("longitude",), longitude, units="degrees_east")
    put(data, "latitude", ("latitude",), latitude, units="degrees_north")
    put(data, "level", ("level",), level, units="millibars")
    here, on = positions_of(x, y, height), ("time", "level", "latitude", "longitude")
    winds = numpy.array([wind(here, 0.1 * hour) for hour in hours])
    put(data, "u", on, winds[..., 0], units="m s**-1", standard_name="eastward_wind")
    put(data, "v", on, winds[..., 1], units="m s**-1", standard_name="northward_wind")
    temperature = 250 + 0 * winds[..., 2]
    density = level[:, None, None] * 100 / (287.05 * temperature)
    if omega:
        put(data, "w", on, -winds[..., 2] * density * GRAVITY, units="Pa s**-1",
            standard_name="lagrangian_tendency_of_air_pressure")
        put(data, "t", on, temperature, units="K", standard_name="air_temperature")
    put(data, "z", on, height[None] * GRAVITY + 0 * temperature, units="m**2 s**-2", standard_name="geopotential")
    data.close()


def write_heights(path, terrain=True):
    """Projected coordinates in km, heights in m, fill values below a slope, one step without a time."""
    x, y, z = numpy.linspace(100, 140, 9), numpy.linspace(-20, 20, 6), numpy.linspace(0, 4000, 5)
    data = create(path, z=5, y=6, x=9)
    put(data, "x", ("x",), x, units="km", standard_name="projection_x_coordinate")
    put(data, "y", ("y",), y, units="km", standard_name="projection_y_coordinate")
    put(data, "z", ("z",), z, units="m", positive="up")
    here = positions_of(1000 * x, 1000 * y, z)
    ground = here[..., 2] < (here[..., 0] - 1e5) / 10 if terrain else numpy.zeros(here.shape[:3], bool)
    winds = numpy.where(ground[..., None], -999, wind(here))
    for i, name in enumerate("uvw"):
        put(data, name, ("z", "y", "x"), winds[..., i], units="m/s", fill_value=-999.0)
    data.close()
    return ~ground.transpose(2, 1, 0)


def write_wrf(path, dates):
    """Winds on the faces of cells and geopotential on the faces between levels, as WRF writes them."""
    nx, ny, nz, step = 8, 6, 5, 3000.0
    data = create(path, Time=len(dates), DateStrLen=19, bottom_top=nz, bottom_top_stag=nz + 1, south_north=ny,
                  south_north_stag=ny + 1, west_east=nx, west_east_stag=nx + 1)
    data.setncatts({"TITLE": " OUTPUT FROM WRF V4", "DX": step, "DY": step})
    times = data.createVariable("Times", "S1", ("Time", "DateStrLen"))
    times[:] = numpy.array([list(date) for date in dates], "S1")
    axis = lambda count: (numpy.arange(count) - 0.5) * step  # faces of cells whose centres count from 0
    centre = lambda count: numpy.arange(count) * step
    ground = lambda x: 100 + x / 50

    def positions(x, y, levels):
        """Positions on layers 800 m thick that follow the ground."""
        here = positions_of(x, y, numpy.asarray(levels, float))
        here[..., 2] = ground(here[..., 0]) + 800 * here[..., 2]
        return here

    mass, stag = numpy.arange(nz) + 0.5, numpy.arange(nz + 1)
    for name, here, kind, component in (
            ("U", positions(axis(nx + 1), centre(ny), mass), ("bottom_top", "south_north", "west_east_stag"), 0),
            ("V", positions(centre(nx), axis(ny + 1), mass), ("bottom_top", "south_north_stag", "west_east"), 1),
            ("W", positions(centre(nx), centre(ny), stag), ("bottom_top_stag", "south_north", "west_east"), 2)):
        put(data, name, ("Time", *kind), [wind(here, step)[..., component]
            for step in range(len(dates))], units="m s-1")
    faces = ("Time", "bottom_top_stag", "south_north", "west_east")
    height = positions(centre(nx), centre(ny), stag)[..., 2]
    put(data, "PHB", faces, [9.81 * height - 50] * len(dates))
    put(data, "PH", faces, [50 + 0 * height] * len(dates))
    put(data, "QVAPOR", ("Time", "bottom_top", "south_north", "west_east"), [0.01 + 0 * height[1:]] * len(dates))
    data.close()


def write_ocean(path, times, angle=0.0):
    """A ROMS-like file: s-levels over a sloping bottom, u and v on faces, land along one side."""
    nx, ny, nz = 9, 7, 6
    longitude, latitude = numpy.meshgrid(numpy.linspace(10, 10.5, nx), numpy.linspace(43, 43.4, ny))
    x, y = plane(longitude, latitude)
    depth = 500 + 200 * (x - x.min()) / numpy.ptp(x)
    s, surface, critical = (numpy.arange(nz) - nz + 0.5) / nz, 0.5 + 0 * x, 20.0
    stretching = -s**2
    level = (critical * s[:, None, None] + depth * stretching[:, None, None]) / (critical + depth)
    height = surface + (surface + depth) * level
    data = create(
    path,
    ocean_time=len(times),
    s_rho=nz,
    s_w=nz + 1,
    eta_rho=ny,
    xi_rho=nx,
    eta_u=ny,
    xi_u=nx - 1,
    eta_v=ny - 1,
     xi_v=nx)
    put(data, "ocean_time", ("ocean_time",), times, units="seconds since 2010-01-01")
    put(data, "s_rho", ("s_rho",), s, standard_name="ocean_s_coordinate_g2",
        formula_terms="s: s_rho C: Cs_r eta: zeta depth: h depth_c: hc")
    put(data, "Cs_r", ("s_rho",), stretching)
    put(data, "hc", (), critical)
    rho = ("eta_rho", "xi_rho")
    put(data, "h", rho, depth)
    put(data, "zeta", ("ocean_time", *rho), [surface] * len(times))
    put(data, "lon_rho", rho, longitude)
    put(data, "lat_rho", rho, latitude)
    put(data, "angle", rho, angle + 0 * depth)
    water = numpy.ones((ny, nx))
    water[:, 0] = 0
    put(data, "mask_rho", rho, water)
    here = positions_of(x, y, height)
    turn = numpy.array([[numpy.cos(angle), numpy.sin(angle), 0], [-numpy.sin(angle), numpy.cos(angle), 0], [0, 0, 1]])
    winds = numpy.array([wind(here, time / 3600) @ turn.T for time in times])  # along the grid
    u, v = (winds[..., 1:, 0] + winds[..., :-1, 0]) / 2, (winds[..., 1:, :, 1] + winds[..., :-1, :, 1]) / 2
    u[..., 0] = numpy.nan  # the face towards land
    put(data, "u", ("ocean_time", "s_rho", "eta_u", "xi_u"), numpy.ma.masked_invalid(u), fill_value=1e37)
    put(data, "v", ("ocean_time", "s_rho", "eta_v", "xi_v"), v)
    rise = winds[..., 2]
    faces = numpy.concatenate([rise[:, :1], (rise[:, 1:] + rise[:, :-1]) / 2, rise[:, -1:]], axis=1)
    put(data, "w", ("ocean_time", "s_w", *rho), faces)
    data.close()


def write_c_grid(folder, hours, pattern="{}.nc"):
    """Sea water as NEMO writes it: a file for each component, on its own faces of the cells."""
    nx, ny, levels = 9, 7, numpy.array([0.0, 10, 25, 50, 90])
    columns, rows = numpy.meshgrid(numpy.arange(nx), numpy.arange(ny))
    middle = None
    for name, east, north, depth, kind in (
            ("U", 0.5, 0, (levels[1:] + levels[:-1]) / 2, "sea_water_x_velocity"),
            ("V", 0, 0.5, (levels[1:] + levels[:-1]) / 2, "sea_water_y_velocity"),
            ("W", 0, 0, levels[:-1], "upward_sea_water_velocity")):
        longitude, latitude = -170 - 0.1 * nx + 0.2 * (columns + east), 40 + 0.1 * (rows + north)
        middle = middle or [(a.min() + a.max()) / 2 for a in (longitude, latitude)]
        x = RADIUS * numpy.cos(numpy.radians(middle[1])) * numpy.radians(longitude - middle[0])
        y = RADIUS * numpy.radians(latitude - middle[1])
        data = create(folder / pattern.format(name), time_counter=len(hours), depth=len(depth), y=ny, x=nx)
        put(data, "time_counter", ("time_counter",), hours, units="hours since 1990-01-01")
        put(data, "depth", ("depth",), depth, units="m", positive="down")
        put(data, "nav_lon", ("y", "x"), (longitude + 180) % 360 - 180, units="degrees_east")
        put(data, "nav_lat", ("y", "x"), latitude, units="degrees_north")
        here = positions_of(x, y, -depth)
        put(data, f"vel{name}", ("time_counter", "depth", "y", "x"), [wind(here, hour)[..., "UVW".index(name)]
            for hour in hours], units="m/s", standard_name=kind, coordinates="nav_lon nav_lat")
        data.close()


def write_b_grid(path):
    """Sea water as POP writes it: in centimetres, u and v at the corners of the cells, w in the middle above."""
    nx, ny, levels = 9, 7, numpy.array([0.0, 10, 25, 50, 90])
    columns, rows = numpy.meshgrid(numpy.arange(nx), numpy.arange(ny))
    data = create(path, z_t=4, z_w=4, nlat=ny, nlon=nx)
    middle = None
    for kind, shift in ("U", 0.5), ("T", 0):
        longitude, latitude = 20 + 0.2 * (columns + shift), 40 + 0.1 * (rows + shift)
        put(data, f"{kind}LONG", ("nlat", "nlon"), longitude, units="degrees_east")
        put(data, f"{kind}LAT", ("nlat", "nlon"), latitude, units="degrees_north")
        middle = middle or [(a.min() + a.max()) / 2 for a in (longitude, latitude)]
        x = RADIUS * numpy.cos(numpy.radians(middle[1])) * numpy.radians(longitude - middle[0])
        y = RADIUS * numpy.radians(latitude - middle[1])
        axis, depth = ("z_t", (levels[1:] + levels[:-1]) / 2) if kind == "U" else ("z_w", levels[:-1])
        put(data, axis, (axis,), 100 * depth, units="centimeters", positive="down")
        for i, name in enumerate(("UVEL", "VVEL", "WVEL")):
            if (kind == "U") == (i < 2):
                put(data, name, (axis, "nlat", "nlon"), 100 * wind(positions_of(x, y, -depth))[..., i],
                    units="centimeter/s", coordinates=f"{kind}LONG {kind}LAT {axis}")
    data.close()
