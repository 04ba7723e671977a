"""NetCDF files of one flow, each with another way to say where its values are: what vdblic_import has to understand.

The flow is linear in longitude, latitude and height, so it is known everywhere. Files are described by a dict: axes and
fields by name, each with dimensions, values and attributes, which a test changes before it writes them.
"""

import netCDF4
import numpy

RADIUS = 6_371_229.0
SHAPE = 4, 6, 8  # levels, rows, columns
DEPTHS = numpy.array([5.0, 15, 25, 35])
TILTED = numpy.array([numpy.cos(numpy.radians(70)), 0, numpy.sin(numpy.radians(70))])  # an axis through 70 N, 0 E
OMEGA = 1e-5 * TILTED  # 1/s
HEIGHTS = numpy.array([0.0, 3000, 6000, 9000])


def east(longitude, latitude, height):
    return 0.4 + 0.05 * longitude - 0.02 * latitude + 0.01 * height


def north(longitude, latitude, height):
    return -0.2 + 0.03 * latitude + 0.004 * height + 0 * longitude


def sea(longitude=None, latitude=None, depths=DEPTHS):
    """A file of sea water on longitude, latitude and depth, for `write`."""
    longitude = 10 + 0.25 * numpy.arange(SHAPE[2]) if longitude is None else numpy.asarray(longitude)
    latitude = 40 + 0.2 * numpy.arange(SHAPE[1]) if latitude is None else numpy.asarray(latitude)
    at = (longitude % 360)[None, None, :], latitude[None, :, None], -depths[:, None, None]
    here = "depth", "lat", "lon"
    return {
        "lon": [("lon",), longitude, {"units": "degrees_east", "standard_name": "longitude", "axis": "X"}],
        "lat": [("lat",), latitude, {"units": "degrees_north", "standard_name": "latitude", "axis": "Y"}],
        "depth": [("depth",), depths, {"units": "m", "positive": "down", "standard_name": "depth", "axis": "Z"}],
        "time": [("time",), numpy.array([6.0]), {"units": "hours since 2020-02-29", "standard_name": "time"}],
        "u": [("time", *here), east(*at)[None], {"units": "m s-1", "standard_name": "eastward_sea_water_velocity"}],
        "v": [("time", *here), north(*at)[None], {"units": "m s-1", "standard_name": "northward_sea_water_velocity"}],
    }


def air(levels=(1000.0, 850, 700, 500)):
    """A file of winds on pressure levels, with geopotential, temperature and vertical velocity in Pa/s."""
    file, here = sea(), ("time", "level", "lat", "lon")
    levels = numpy.array(levels)
    height = 100.0 + 1500 * numpy.arange(len(levels))
    full = numpy.ones((1, len(levels), *SHAPE[1:]))
    at = file["lon"][1][None, None, :], file["lat"][1][None, :, None], height[:, None, None] / 1000
    for name, flow, kind in ("u", east, "eastward_wind"), ("v", north, "northward_wind"):
        file[name] = [here, flow(*at)[None], {"units": "m s-1", "standard_name": kind}]
    del file["depth"]
    put = lambda values: values.reshape(1, -1, 1, 1) * full
    file["level"] = [("level",), levels, {"units": "hPa", "positive": "down", "standard_name": "air_pressure"}]
    file["z"] = [here, put(height * 9.80665), {"units": "m2 s-2", "standard_name": "geopotential"}]
    file["t"] = [here, 270 * full, {"units": "K", "standard_name": "air_temperature"}]
    rise = {"units": "Pa s-1", "standard_name": "lagrangian_tendency_of_air_pressure"}
    file["w"] = [here, put(-0.02 * levels * 100 * 9.80665 / (287.05 * 270)), rise]  # 0.02 m/s upwards
    return file


def unit_vectors(longitude, latitude):
    """Outward, eastward and northward vectors."""
    lon, lat = numpy.radians(longitude), numpy.radians(latitude)
    zero = 0 * (lon + lat)
    return (numpy.stack([numpy.cos(lat) * numpy.cos(lon), numpy.cos(lat) * numpy.sin(lon), numpy.sin(lat) + zero], -1),
            numpy.stack([zero - numpy.sin(lon), zero + numpy.cos(lon), zero], -1),
            numpy.stack([-numpy.sin(lat) * numpy.cos(lon), -numpy.sin(lat) * numpy.sin(lon), numpy.cos(lat) + zero], -1))


def wind(longitude, latitude, heights=HEIGHTS, up=0.0, name="height"):
    """A file of the solid-body rotation OMEGA."""
    lon, lat, z = longitude[None, None, :], latitude[None, :, None], heights[:, None, None]
    out, east, north = unit_vectors(lon, lat)
    flow = numpy.cross(OMEGA, out) * (RADIUS + z)[..., None]
    here = (name, "lat", "lon")
    file = {
        "lon": [("lon",), longitude, {"units": "degrees_east"}], "lat": [("lat",), latitude, {"units": "degrees_north"}],
        name: [(name,), heights, {"units": "m", "standard_name": name, "positive": "down" if name == "depth" else "up"}],
        "u": [here, (flow * east).sum(-1), {"units": "m s-1", "standard_name": "eastward_wind"}],
        "v": [here, (flow * north).sum(-1), {"units": "m s-1", "standard_name": "northward_wind"}],
    }
    if len(heights) > 1:
        file["w"] = [here, up + 0 * flow[..., 0], {"units": "m s-1", "standard_name": "upward_air_velocity"}]
    return file


def turned(angle=0.7, shape=SHAPE):
    """Sea water at 60 degrees north on a grid of 10 km that is turned; it flows east with 0.5 m/s, along the grid's axes."""
    rows, columns = numpy.meshgrid(numpy.arange(shape[1]) - 2.5, numpy.arange(shape[2]) - 3.5, indexing="ij")
    x, y = (1e4 * (columns * numpy.cos(angle) - rows * numpy.sin(angle)),
            1e4 * (columns * numpy.sin(angle) + rows * numpy.cos(angle)))
    file, here = sea(), ("time", "depth", "j", "i")
    for name in "lon", "lat":
        del file[name]
    latitude = 60 + numpy.degrees(y / RADIUS)
    file["nav_lon"] = [("j", "i"), -20 + numpy.degrees(x / RADIUS / 0.5), {"units": "degrees_east"}]
    file["nav_lat"] = [("j", "i"), latitude, {"units": "degrees_north"}]
    full = numpy.ones((1, *shape))
    for name, part, kind in ("u", numpy.cos(angle), "sea_water_x_velocity"), ("v", -numpy.sin(angle), "sea_water_y_velocity"):
        file[name] = [here, 0.5 * part * full, {"units": "m/s", "standard_name": kind, "coordinates": "nav_lon nav_lat"}]
    return file


def tripolar(places, spin=OMEGA, columns=120, rows=96, halo=False):
    """A rotation on a grid with two north poles, 17 degrees from that of the Earth, which is folded between them.

    Its rows are confocal ellipses about the pole (z = f cosh(x + iy), seen from the south pole by a stereographic
    projection), so its angles against east are known: those of tanh. `places` are where u and v lie on a cell, counted from
    its corner in the south-west. With `halo` two columns and a row come twice, as in NEMO. Around the poles is land.
    """
    focus, step, files = 0.15, 2 * numpy.pi / columns, []
    for slot, (name, (x, y)) in enumerate(zip("uv", places)):
        i, j = numpy.meshgrid(numpy.arange(columns) + x, numpy.arange(rows)[::-1] + 1 - y)
        if halo:
            mirror = -i[-1:], j[-1:]
            i, j = numpy.concatenate([i, mirror[0]]), numpy.concatenate([j, mirror[1]])
            i, j = (numpy.concatenate([part[:, -1:], part, part[:, :1]], axis=1) for part in (i, j))
        zeta = step * (j + 1j * i)
        z, turn = focus * numpy.cosh(zeta), numpy.angle(numpy.tanh(zeta))
        turn[-1] += numpy.pi * halo  # the row that comes twice runs backwards
        longitude, latitude = numpy.degrees(numpy.angle(z)), 90 - 2 * numpy.degrees(numpy.arctan(abs(z)))
        out, east, north = unit_vectors(longitude, latitude)
        flow = numpy.cross(spin, out) * RADIUS
        along = (numpy.cos(turn), numpy.sin(turn)) if slot == 0 else (-numpy.sin(turn), numpy.cos(turn))
        values = (flow * east).sum(-1) * along[0] + (flow * north).sum(-1) * along[1]
        values[numpy.minimum(abs(z - focus), abs(z + focus)) < 0.06] = numpy.nan
        files.append({
            "nav_lon": [("y", "x"), longitude, {"units": "degrees_east"}], "nav_lat": [("y", "x"), latitude, {"units": "degrees_north"}],
            name: [("y", "x"), values, {"units": "m/s", "standard_name": f"sea_water_{'xy'[slot]}_velocity", "coordinates": "nav_lon nav_lat"}],
        })  # fmt: skip
    return files


def write(path, file, form="NETCDF4", attributes=None):
    path.unlink(missing_ok=True)  # a reader may still hold the one before
    with netCDF4.Dataset(path, "w", format=form) as data:
        data.setncatts(attributes or {})
        for dims, values, _ in file.values():
            for name, size in zip(dims, numpy.shape(values)):
                if name not in data.dimensions:
                    data.createDimension(name, size)
        for name, (dims, values, told) in file.items():
            values = numpy.asarray(values)
            variable = data.createVariable(name, values.dtype if values.dtype.kind in "iS" else "f8", dims)
            variable.setncatts(told)
            variable[...] = values


def plane(longitude, latitude, middle):
    """Metres from a middle."""
    return (RADIUS * numpy.cos(numpy.radians(middle[1])) * numpy.radians(longitude - middle[0]),
            RADIUS * numpy.radians(latitude - middle[1]))


def on_earth(positions, middle):
    """Longitude, latitude and height of positions in metres from a middle."""
    scale = numpy.cos(numpy.radians(middle[1]))
    return (middle[0] + numpy.degrees(positions[..., 0] / RADIUS / scale),
            middle[1] + numpy.degrees(positions[..., 1] / RADIUS), positions[..., 2])


def fvcom(levels=3, size=6, units=True):
    """FVCOM: triangles over a square of the sea that is 30 m deep; the velocity is in their middles."""
    lon, lat = (grid.ravel() for grid in numpy.meshgrid(numpy.linspace(-122.6, -122.2, size), numpy.linspace(37.5, 37.9, size)))
    corner = (size * numpy.arange(size - 1)[:, None] + numpy.arange(size - 1)).ravel()
    triangles = numpy.concatenate([corner[:, None] + (0, 1, size), corner[:, None] + (1, size + 1, size)])
    sigma = -(numpy.arange(levels) + 0.5) / levels
    middle = lon[triangles].mean(axis=1), lat[triangles].mean(axis=1)
    z = 30 * sigma[:, None]
    terms = {"standard_name": "ocean_sigma_coordinate", "formula_terms": "sigma: siglay eta: zeta depth: h", "positive": "up"}
    speed = {"units": "meters s-1"} if units else {}
    put = lambda values: (values + 0 * middle[0])[None]
    file = {
        "lon": [("node",), lon, {"units": "degrees_east", "standard_name": "longitude"}],
        "lat": [("node",), lat, {"units": "degrees_north", "standard_name": "latitude"}],
        "siglay": [("siglay", "node"), sigma[:, None] + 0 * lon, terms],
        "siglev": [("siglev", "node"), -numpy.linspace(0, 1, levels + 1)[:, None] + 0 * lon, terms],
        "h": [("node",), 30 + 0 * lon, {"units": "m"}],
        "zeta": [("time", "node"), 0 * lon[None], {"units": "m"}],
        "nv": [("three", "nele"), (triangles.T + 1).astype("i4"), {}],
        "time": [("time",), numpy.array([59000.5]), {"units": "days since 1858-11-17 00:00:00"}],
    }
    for name, flow, kind in ("u", east, "eastward"), ("v", north, "northward"):
        told = speed | {"standard_name": f"{kind}_sea_water_velocity"}
        file[name] = [("time", "siglay", "nele"), put(flow(*middle, z)), told]
    return file, lon[triangles], lat[triangles]


def mpas(rows=7, columns=8, levels=3):
    """MPAS: hexagons by their centres, which are the nodes of a mesh of triangles; levels of 500 m."""
    j, i = (grid.ravel() for grid in numpy.meshgrid(numpy.arange(rows), numpy.arange(columns), indexing="ij"))
    lon, lat = 5 + 0.3 * (i + 0.5 * (j % 2)), 45 + 0.2 * j
    number = lambda row, column: row * columns + column
    triangles = []
    for row in range(rows - 1):
        for column in range(columns - 1):
            a, b, c, d = (number(row + up, column + on) for up, on in ((0, 0), (0, 1), (1, 0), (1, 1)))
            triangles += [[a, b, d], [a, d, c]] if row % 2 else [[a, b, c], [b, d, c]]
    height = 500.0 * (numpy.arange(levels) + 0.5) / 1000
    file = {
        "lonCell": [("nCells",), numpy.radians(lon), {"units": "rad"}],
        "latCell": [("nCells",), numpy.radians(lat), {"units": "rad"}],
        "cellsOnVertex": [("nVertices", "vertexDegree"), (numpy.array(triangles) + 1).astype("i4"), {}],
        "zgrid": [("nCells", "nVertLevelsP1"), 500.0 * numpy.arange(levels + 1) + 0 * lon[:, None], {"units": "m"}],
        "xtime": [("Time", "StrLen"), numpy.array([list("2014-09-10_06:00:00")], "S1"), {}],
    }
    for name, flow in ("uReconstructZonal", east), ("uReconstructMeridional", north):
        values = flow(lon[:, None], lat[:, None], height)
        file[name] = [("Time", "nCells", "nVertLevels"), values[None], {"units": "m s^{-1}"}]
    return file


def c_grid(padding, given, curved=True, angle=0.0):
    """Cells by SGRID: u on the faces towards x, v on those towards y; only `given`, "face" or "node", has coordinates."""
    before, after = {"none": (0, 0), "low": (1, 0), "high": (0, 1), "both": (1, 1)}[padding]
    counts, places = {"x": 9, "y": 7}, {}
    for axis, count in counts.items():
        places[axis + "n"] = numpy.arange(count) - count / 2
        places[axis + "c"] = numpy.arange(count - 1 + before + after) + 0.5 - before - count / 2

    def put(x, y):
        x, y = places[x][None, :], places[y][:, None]
        return (10 + 0.25 * (x * numpy.cos(angle) - y * numpy.sin(angle)),
                40 + 0.2 * (x * numpy.sin(angle) + y * numpy.cos(angle)))

    file, end = sea(), given[0].replace("f", "c")
    del file["lon"], file["lat"]
    padded = [f"{axis}c: {axis}n (padding: {padding})" for axis in "xy"]
    file["grid"] = [(), numpy.array(0, "i4"), {
        "cf_role": "grid_topology", "topology_dimension": 2, "node_dimensions": "xn yn", "face_dimensions": " ".join(padded),
        "edge1_dimensions": f"xn {padded[1]}", "edge2_dimensions": f"{padded[0]} yn"}]
    here = put(f"x{end}", f"y{end}")
    for slot, (name, unit) in enumerate((("lon", "degrees_east"), ("lat", "degrees_north"))):
        if curved:
            file[name] = [(f"y{end}", f"x{end}"), here[slot], {"units": unit}]
        else:
            axis = "xy"[slot] + end
            file[axis] = [(axis,), here[slot].mean(axis=slot), {"units": unit}]
    for name, dims, flow in ("u", ("yc", "xn"), east), ("v", ("yn", "xc"), north):
        at = put(dims[1], dims[0])
        file[name] = [("depth", *dims), flow(*at, -DEPTHS[:, None, None]), {"units": "m/s"}]
    return file, put("xn", "yc")
