"""vdblic_import understands what files of the Earth sciences say, or refuses them by name: the same flow, said otherwise."""

import unittest

import numpy
import pyopenvdb as vdb

import earth_flows
from earth_flows import east, north
from imports import ImportHere, velocity_of


class EarthTest(ImportHere):
    def writes(self, file, name="f.nc", **options):
        earth_flows.write(self.folder / name, file, **options)

    def assert_sea(self, file, *options, middle=(10.875, 40.5), tolerance=1e-5, share=0.99):
        """A file becomes the flow of earth_flows. Returns the first volume's metadata."""
        self.writes(file)
        path = self.imports("f.nc", "-o", "v.%04d.vdb", *options)[0]
        values, active, positions = velocity_of(path)
        at = earth_flows.on_earth(positions, middle)
        self.assertGreaterEqual(active.mean(), share)
        self.assertGreater(active.sum(), 100)
        for slot, flow in enumerate((east, north)):
            numpy.testing.assert_allclose(values[active][..., slot], flow(*at)[active], atol=tolerance)
        return vdb.readMetadata(str(path))

    def assert_refused(self, file, *words, options=()):
        self.writes(file)
        message = self.fails(3, "vdblic_import", "f.nc", "-o", "v.%04d.vdb", *options)
        for word in words:
            self.assertIn(word, message)
        return message


class Units(EarthTest):
    def test_spellings(self):
        import sys  # pylint: disable=import-outside-toplevel
        from support import BIN  # pylint: disable=import-outside-toplevel

        sys.path.insert(0, str(BIN.parent / "python"))
        from vdblic_convert.units import converted  # pylint: disable=import-outside-toplevel,import-error

        for factor, wanted, *units in (
                (1, "m/s", "m s-1", "m.s-1", "m s^-1", "m s**-1", "m s^{-1}", "meters/second", "metre second-1", "m sec-1"),
                (0.01, "m/s", "cm/s", "cm s-1", "cm.s-1", "centimeter second-1"),
                (1 / 3.6, "m/s", "km/h", "km hr-1", "kph"),
                (1852 / 3600, "m/s", "knots", "kt", "kts", "kn"),
                (1 / 86400, "m/s", "m d-1", "m/day"),
                (0.3048, "m/s", "ft/s", "feet second-1"),
                (1000, "m", "km", "Kilometers", "1000 m"), (10, "m", "dam"), (1, "m", "gpm", "Meter"),
                (100, "Pa", "hPa", "mbar", "mb", "millibars"), (100 / 86400, "Pa/s", "mb/day"),
                (1, "m**2/s**2", "m2 s-2", "m^2/s^2", "J kg-1"), (numpy.pi / 180, "radian", "degrees", "arc_degree")):
            for unit in units:
                with self.subTest(unit):
                    self.assertAlmostEqual(converted(3.0, unit, wanted) / (3 * factor), 1, 6)
        self.assertAlmostEqual(converted(20.0, "degC", "K"), 293.15)
        for unit, wanted in ("ms-1", "m/s"), ("lattice", "m/s"), ("", "m/s"), ("1", "m/s"), ("C", "K"), ("rad", "m"):
            with self.subTest(unit), self.assertRaises(ValueError):
                converted(1.0, unit, wanted)
        with self.assertRaises(ValueError):
            converted(1.0, "months", "s")

    def test_components_and_axes(self):
        file = earth_flows.sea()
        file["u"][1] = file["u"][1] * 100
        file["u"][2]["units"] = "cm.s-1"
        file["depth"][1] = file["depth"][1] / 1000
        file["depth"][2]["units"] = "km"
        self.assert_sea(file)
        file["u"][2]["units"] = "furlong"
        self.assert_refused(file, "f.nc: 'u' is in 'furlong', which cannot be converted to m/s", "--attribute 'u:units=m/s'")
        del file["u"][2]["units"]
        self.assert_refused(file, "f.nc: 'u' has no units; say which: --attribute 'u:units=m/s'")
        self.assert_sea(file, "--attribute", "u:units=cm/s")

    def test_what_heights_are_computed_from(self):
        for name, unit, change in (
                ("z", "m2 s-2", lambda v: v), ("z", "km2 s-2", lambda v: v / 1e6), ("t", "degC", lambda v: v - 273.15),
                ("level", "Pa", lambda v: v * 100), ("level", "millibars", lambda v: v), ("w", "hPa/day", lambda v: v * 864)):
            with self.subTest(name, unit=unit):
                file = earth_flows.air()
                file[name][1], file[name][2]["units"] = change(file[name][1]), unit
                self.writes(file)
                path, = self.imports("f.nc", "-o", "v.%04d.vdb")
                values, active, positions = velocity_of(path)
                longitude, latitude, height = earth_flows.on_earth(positions, (10.875, 40.5))
                self.assertTrue(active.all())
                numpy.testing.assert_allclose(values[..., 0], east(longitude, latitude, height / 1000), atol=1e-5)
                numpy.testing.assert_allclose(values[..., 2], 0.02, rtol=1e-5)
                numpy.testing.assert_allclose(positions[0, 0, [0, -1], 2], (100, 4600), rtol=1e-6)
        file["z"][2]["units"] = "m"
        self.assert_refused(file, "'z' is in 'm', which cannot be converted to m2/s2")
        for name, standard in ("z", "geopotential"), ("t", "air_temperature"):
            file = earth_flows.air()
            del file[name][2]["standard_name"]
            self.assert_refused(file, f"'{name}' may be the {standard}, but has no standard_name")

    def test_ground(self):
        """Levels below the ground are masked by the surface pressure, in whatever unit it is."""
        for unit, value in ("Pa", 90000.0), ("hPa", 900.0):
            file = earth_flows.air()
            file["ps"] = [("time", "lat", "lon"), value + numpy.zeros((1, *earth_flows.SHAPE[1:])),
                          {"units": unit, "standard_name": "surface_air_pressure"}]
            self.writes(file)
            path, = self.imports("f.nc", "-o", "v.%04d.vdb")
            self.assertGreater(velocity_of(path)[2][0, 0, 0, 2], 1500)


class Up(EarthTest):
    def test_axes_that_are_understood(self):
        for name, values, told in (
                ("depth", 1, {"units": "m"}), ("Depth", 1, {"units": "meters", "long_name": "Depth"}),
                ("depth", 1, {"units": "m", "positive": "Down"}), ("lev", 1, {"units": "m", "standard_name": "depth"}),
                ("lev", 1, {"units": "m", "axis": "Z", "long_name": "ocean depth coordinate"}),
                ("st_ocean", 100, {"units": "centimeters", "positive": "down", "cartesian_axis": "Z"}),
                ("depth", -1, {"units": "m", "positive": "up"}), ("z", -1, {"units": "m"}),
                ("elevation", -1, {"units": "m", "POSITIVE": "UP"})):
            with self.subTest(name, values=values, **told):
                file = earth_flows.sea()
                _, depths, _ = file.pop("depth")
                file[name] = [(name,), values * depths, told]
                for component in "uv":
                    file[component][0] = ("time", name, "lat", "lon")
                self.assert_sea(file)

    def test_contradictions_and_what_is_missing(self):
        for name, values, told, words in (
                ("depth", 1, {}, "'depth' has no units"),
                ("depth", -1, {"units": "m"}, "it is a depth, and its values are negative"),
                ("depth", -1, {"units": "m", "positive": "down"}, "it is a depth, and its values are negative"),
                ("lev", -1, {"units": "m", "positive": "up", "standard_name": "depth"}, "it is a depth and positive up"),
                ("lev", 1, {"units": "m", "positive": "north"}, "'north' is no direction"),
                ("lev", 1, {"units": "m"}, "which way is up along 'lev'? nothing tells whether it is a height or a depth"),
                ("lev", 1, {"units": "m below sea surface", "positive": "down"}, "the vertical axis 'lev' (m below sea surface)"),
                ("pres", 1, {"units": "dbar", "standard_name": "sea_water_pressure"}, "which is none of air"),
                ("lev", 1, {"units": "m", "axis": "X", "positive": "up"}, "'lev' contradicts itself")):
            with self.subTest(name, **told):
                file = earth_flows.sea()
                _, depths, _ = file.pop("depth")
                file[name] = [(name,), values * depths, told]
                for component in "uv":
                    file[component][0] = ("time", name, "lat", "lon")
                message = self.assert_refused(file, "f.nc: ", words)
                self.assertIn(f"--attribute '{name}:", message)
        self.assert_sea(file, "--attribute", "lev:axis=Z", "lev:positive=down")

    def test_terms_of_formulas(self):
        file = earth_flows.sea()
        s = -numpy.array([0.1, 0.3, 0.6, 0.9])
        depth = 100 + 20 * numpy.arange(8) + numpy.zeros((6, 1))
        kind = {"standard_name": "ocean_sigma_coordinate", "formula_terms": "sigma: depth eta: zeta depth: h"}
        file["depth"] = [("depth",), s, kind | {"positive": "up"}]
        file["h"] = [("lat", "lon"), depth / 1000, {"units": "km"}]
        file["zeta"] = [("time", "lat", "lon"), 0 * depth[None] + 50, {"units": "cm"}]
        height = 0.5 + s[:, None, None] * (depth + 0.5)
        at = file["lon"][1], file["lat"][1][:, None], height
        file["u"][1], file["v"][1] = east(*at)[None], north(*at)[None]
        self.assert_sea(file, "--size", 16, 12, 40, share=0.5, tolerance=2e-3)
        for name, words in ("h", "name h (depth), which the file lacks"), ("zeta", "name zeta (eta), which the file lacks"):
            lacking = {key: value for key, value in file.items() if key != name}
            self.assert_refused(lacking, words)
        del kind["formula_terms"]
        file["depth"][2] = kind
        self.assert_refused(file, "the formula_terms of 'depth' name no sigma, which ocean_sigma_coordinate needs")


class Directions(EarthTest):
    def mean(self, file, *options):
        self.writes(file)
        path, = self.imports("f.nc", "-o", "v.%04d.vdb", *options)
        values, active, _ = velocity_of(path)
        return values[active].mean(axis=0)

    def test_along_a_turned_grid(self):
        file = earth_flows.turned()
        numpy.testing.assert_allclose(self.mean(file), (0.5, 0, 0), atol=2e-3)
        for name, older in ("u", "x_sea_water_velocity"), ("v", "y_sea_water_velocity"):
            file[name][2]["standard_name"] = older
        numpy.testing.assert_allclose(self.mean(file), (0.5, 0, 0), atol=2e-3)
        for slot, name in enumerate("uv"):
            file[name][1][:] = (0.5, -0.1)[slot]
            file[name][2]["standard_name"] = ("eastward_sea_water_velocity", "northward_sea_water_velocity")[slot]
        numpy.testing.assert_allclose(self.mean(file), (0.5, -0.1, 0), atol=1e-6)
        for name in "uv":
            del file[name][2]["standard_name"]
        message = self.assert_refused(file, "is 'u' along the grid, which is turned by up to 40")
        self.assertIn("--attribute 'u:standard_name=x_wind' or 'u:standard_name=eastward_wind'", message)
        answers = "--attribute", "u:standard_name=eastward_wind", "v:standard_name=northward_wind"
        numpy.testing.assert_allclose(self.mean(file, *answers), (0.5, -0.1, 0), atol=1e-6)

    def test_on_a_projected_plane(self):
        import pyproj  # pylint: disable=import-outside-toplevel

        mapping = {"grid_mapping_name": "polar_stereographic", "latitude_of_projection_origin": 90.0, "standard_parallel": 70.0,
                   "straight_vertical_longitude_from_pole": 0.0, "false_easting": 0.0, "false_northing": 0.0,
                   "semi_major_axis": 6371000.0, "semi_minor_axis": 6371000.0}
        file = earth_flows.sea()
        x, y = 1000 + 10.0 * numpy.arange(8), -900 + 10.0 * numpy.arange(6)
        for name, values, kind in ("x", x, "projection_x_coordinate"), ("y", y, "projection_y_coordinate"):
            file[name] = [(name,), values, {"units": "km", "standard_name": kind}]
        file["crs"] = [(), numpy.array(0, "i4"), mapping]
        for name, speed in ("u", 0.6), ("v", 0.0):
            file[name][0], file[name][1] = ("time", "depth", "y", "x"), numpy.full((1, *earth_flows.SHAPE), speed)
            file[name][2]["grid_mapping"] = "crs"
        del file["lon"], file["lat"]
        self.writes(file)
        path, = self.imports("f.nc", "-o", "v.%04d.vdb")
        values, active, positions = velocity_of(path)
        to_earth = pyproj.Transformer.from_crs(pyproj.CRS.from_cf(mapping), pyproj.CRS.from_cf(mapping).geodetic_crs, always_xy=True)
        longitude, _ = to_earth.transform(positions[..., 0], positions[..., 1])
        angle = numpy.radians(longitude)  # of east against x, as this projection has it
        expected = 0.6 * numpy.stack([numpy.cos(angle), numpy.sin(angle), 0 * angle], axis=-1)
        numpy.testing.assert_allclose(values[active], expected[active], atol=2e-3)
        for name in "uv":
            del file[name][2]["grid_mapping"]
        self.assert_refused(file, "nothing tells where east is along its axes", "--attribute 'u:standard_name=x_wind'")
        for name, kind in ("u", "sea_water_x_velocity"), ("v", "sea_water_y_velocity"):
            file[name][2]["standard_name"] = kind
        numpy.testing.assert_allclose(self.mean(file), (0.6, 0, 0), atol=1e-6)


class Horizontal(EarthTest):
    def test_longitudes_in_any_order(self):
        across = numpy.arange(356, 364, 0.5)
        for longitude in (across, across % 360, (across + 180) % 360 - 180, numpy.sort(across % 360),
                          numpy.sort((across + 180) % 360 - 180), across[::-1], numpy.append(across % 360, 363.5)):
            with self.subTest(first=longitude[0]):
                file = earth_flows.sea(longitude)
                known = earth_flows.sea(across)  # by true longitudes from 356 on, so that the flow is linear
                order = numpy.searchsorted(across, (longitude - 356) % 360 + 356 - 1e-6)
                for name in "uv":
                    file[name][1] = earth_flows.sea(across)[name][1] * 0 + known[name][1]
                at = across[None, None, :], file["lat"][1][None, :, None], -earth_flows.DEPTHS[:, None, None]
                for name, flow in ("u", east), ("v", north):
                    file[name][1] = flow(*at)[None][..., order]
                self.assert_sea(file, middle=(359.75 if longitude[0] >= 356 and longitude[-1] >= 356 else -0.25 + 360, 40.5))

    def test_a_repeated_column_is_dropped(self):
        file = earth_flows.sea(numpy.arange(-180, 180.1, 30))
        for name in "uv":
            file[name][1] = numpy.zeros((1, 4, 6, 13)) + numpy.arange(13) % 12
        self.writes(file)
        path, = self.imports("f.nc", "-o", "v.%04d.vdb")
        values, active, positions = velocity_of(path)
        self.assertEqual(active.shape[0], 12)
        numpy.testing.assert_array_equal(values[:, 0, 0, 0], numpy.arange(12))

    def test_fields_of_longitude_and_latitude(self):
        """Numbers of columns beside the fields are no places; a cut through the first column changes nothing."""
        for shift in 0, 350, -10.5:
            file = earth_flows.sea()
            lon, lat = numpy.meshgrid(file.pop("lon")[1] + shift, file.pop("lat")[1])
            for name, count in ("Y", 6), ("X", 8):
                file[name] = [(name,), numpy.arange(1, count + 1, dtype="i4"), {"axis": name}]
            file["Longitude"] = [("Y", "X"), (lon + 180) % 360 - 180, {"units": "degrees_east", "standard_name": "longitude"}]
            file["Latitude"] = [("Y", "X"), lat, {"units": "degrees_north", "standard_name": "latitude"}]
            for name in "uv":
                file[name][0] = ("time", "depth", "Y", "X")
                file[name][2]["coordinates"] = "Longitude Latitude"
            self.assert_sea(file, share=0.8)

    def test_faces_of_cells(self):
        """Components on the faces, whose axes have names and texts of their own (MITgcm)."""
        x, y, z = 500.0 * numpy.arange(10), 400.0 * numpy.arange(8), -10.0 * numpy.arange(6)
        axes = {"X": x[:-1] + 250, "Xp1": x, "Y": y[:-1] + 200, "Yp1": y, "Z": z - 5, "Zl": z}
        file = {name: [(name,), values, {"units": "meters"}] for name, values in axes.items()}
        for name in "Z", "Zl":
            file[name][2]["positive"] = "up"
        flow = lambda at: 0.1 + at @ numpy.array([[1e-5, 2e-5, 0], [0, -1e-5, 1e-5], [1e-3, 0, -1e-4]])
        for slot, (name, dims) in enumerate((("U", ("Z", "Y", "Xp1")), ("V", ("Z", "Yp1", "X")), ("W", ("Zl", "Y", "X")))):
            grid = numpy.stack(numpy.meshgrid(*(axes[d] for d in dims), indexing="ij")[::-1], axis=-1)
            file[name] = [dims, flow(grid)[..., slot], {"units": "m/s"}]
        self.writes(file, form="NETCDF3_CLASSIC")
        path, = self.imports("f.nc", "-o", "v.%04d.vdb")
        self.assertGreater(self.assert_flow(path, flow).sum(), 200)

    def test_what_axes_are(self):
        for unit, words in ("rad", "neither lengths nor longitude and latitude"), ("", "'x' has no units"):
            file = earth_flows.sea()
            for old, new in ("lon", "x"), ("lat", "y"):
                _, values, _ = file.pop(old)
                file[new] = [(new,), values, {"units": unit} if unit else {}]
            for name in "uv":
                file[name][0] = ("time", "depth", "y", "x")
            self.assert_refused(file, words, "--attribute 'x:units=m'")


class Layers(EarthTest):
    def test_one_level(self):
        for axis in True, False:
            for longitude in None, 10 + 0.25 * numpy.arange(8) ** 1.1:
                file = earth_flows.sea(longitude)
                for name in "uv":
                    file[name][0] = ("time", *["depth"][:axis], "lat", "lon")
                    file[name][1] = file[name][1][:, :1] if axis else file[name][1][:, 0]
                file["depth"][1] = file["depth"][1][:1]
                if not axis:
                    del file["depth"]
                self.writes(file)
                path, = self.imports("f.nc", "-o", "v.%04d.vdb")
                values, active, positions = velocity_of(path)
                self.assertEqual(active.shape, (8, 6, 1))
                numpy.testing.assert_allclose(positions[..., 2], -5.0 if axis else 0.0, atol=1e-6)
                middle = [(a.min() + a.max()) / 2 for a in (file["lon"][1], file["lat"][1])]
                longitude, latitude, _ = earth_flows.on_earth(positions, middle)
                numpy.testing.assert_allclose(values[..., 0][active], east(longitude, latitude, -5)[active], atol=2e-3)


class Dates(EarthTest):
    def dates(self, values, *options, **attributes):
        file = earth_flows.sea()
        file["time"][1], file["time"][2] = numpy.array(values), attributes
        for name in "uv":
            file[name][1] = numpy.repeat(file[name][1], len(values), axis=0)
        self.writes(file)
        found = [vdb.readMetadata(str(path)) for path in self.imports("f.nc", "-o", "v.%04d.vdb", *options)]
        return found[0].get("start"), [data["time"] for data in found]

    def test_calendars_and_spellings(self):
        day = 86400.0
        for values, start, times, told in (
                ([58, 59, 60], "2000-02-29T00:00:00", [0, day, 2 * day], {"units": "days since 2000-01-01", "calendar": "360_day"}),
                ([58, 59], "0001-02-28T00:00:00", [0, day], {"units": "days since 0001-01-01", "calendar": "noleap"}),
                ([365 * 1999 + 58, 365 * 1999 + 59], "2000-02-28T00:00:00", [0, day],
                 {"units": "days since 0001-01-01", "calendar": "365_day"}),
                ([31], "0000-02-01T00:00:00", [0], {"units": "days since 0000-01-01", "calendar": "standard"}),
                ([20200131.5, 20200201.25], "2020-01-31T12:00:00", [0, 64800], {"units": "day as %Y%m%d.%f"}),
                ([3242], "2008-11-16T00:00:00", [0], {"units": "days since 1-Jan-2000 00:00:0.0"}),
                ([12, 18], "2001-05-03T12:00:00", [0, 21600], {"Units": "hours since 2001-05-03 00:00:00 UTC"}),
                ([0, 2], None, [0, 7200], {"units": "hours"})):
            with self.subTest(**told):
                self.assertEqual(self.dates(values, **told), (start, times))
        for told in {"units": "months since 2000-01-01"}, {"units": "month as %Y%m.%f"}, {"units": "fortnights ago"}:
            with self.subTest(**told):
                file = earth_flows.sea()
                file["time"][2] = told
                self.assert_refused(file, f"the time axis 'time' is in '{told['units']}'")

    def test_forecasts(self):
        """A time that the file tells beside its axis of steps, and one that is the sum of reference and step."""
        for told in "valid_time", "period":
            file = earth_flows.sea()
            file["step"] = [("step",), numpy.array([0.0, 3, 6]), {"units": "hours", "standard_name": "forecast_period"}]
            reference = {"units": "seconds since 1970-01-01", "standard_name": "forecast_reference_time"}
            file["time"] = [(), numpy.array(1.7e9), reference]
            if told == "valid_time":
                file["valid_time"] = [("step",), 1.7e9 + 3600 * numpy.array([0.0, 3, 6]),
                                      {"units": "seconds since 1970-01-01", "standard_name": "time"}]
            for name in "uv":
                file[name][0], file[name][1] = ("step", *file[name][0][1:]), numpy.repeat(file[name][1], 3, axis=0)
            self.writes(file)
            found = [vdb.readMetadata(str(path)) for path in self.imports("f.nc", "-o", "v.%04d.vdb")]
            self.assertEqual([data["time"] for data in found], [0, 10800, 21600], told)
            self.assertEqual(found[0]["start"], "2023-11-14T22:13:20")


class Meshes(EarthTest):
    def test_fvcom(self):
        """Each cell has one value: that of the triangle and the layer in which a voxel is."""
        file, lon, lat = earth_flows.fvcom()
        self.writes(file)
        path, = self.imports("f.nc", "-o", "v.%04d.vdb", "--size", 21, 23, 9)
        self.assertEqual(vdb.readMetadata(str(path))["start"], "2020-05-31T12:00:00")
        values, active, positions = velocity_of(path)
        self.assertGreater(active.mean(), 0.95)
        x, y = earth_flows.plane(lon, lat, (-122.4, 37.7))
        middle = numpy.stack([x.mean(axis=1), y.mean(axis=1)], axis=-1)
        for voxel in numpy.random.default_rng(3).choice(numpy.argwhere(active), 300):
            at = positions[tuple(voxel)]
            inside = [i for i in range(len(x)) if self.is_inside(at, x[i], y[i])]
            layer = min(int(-at[2] / 10), 2)
            expected = file["u"][1][0, layer, inside]
            near = abs(middle[inside] - at[:2]).sum(axis=1)
            if len(inside) == 1 and near.min() > 100:
                self.assertLess(abs(expected - values[tuple(voxel)][0]).min(), 0.08)

    @staticmethod
    def is_inside(at, x, y):
        sides = [(x[i - 1] - x[i]) * (at[1] - y[i]) - (y[i - 1] - y[i]) * (at[0] - x[i]) for i in range(3)]
        return min(sides) > 0 or max(sides) < 0

    def test_hexagons(self):
        self.writes(earth_flows.mpas())
        path, = self.imports("f.nc", "-o", "v.%04d.vdb", "--size", 30, 25, 8)
        values, active, positions = velocity_of(path)
        longitude, latitude, height = earth_flows.on_earth(positions, (6.125, 45.6))
        self.assertGreater(active.mean(), 0.5)
        numpy.testing.assert_allclose(values[active][:, 0], east(longitude, latitude, height / 1000)[active], atol=1e-5)
        numpy.testing.assert_allclose(values[active][:, 1], north(longitude, latitude, height / 1000)[active], atol=1e-5)
        file = earth_flows.mpas()
        del file["cellsOnVertex"]
        self.assert_refused(file, "nothing tells which nodes its cells join")


class Told(EarthTest):
    def test_explanations(self):
        self.writes(earth_flows.sea())
        done = self.run_tool("vdblic_import", "f.nc", "-o", "v.%04d.vdb", "--explain")
        for words in ("'depth' is the height or depth: 5, 35 m, downward", "'lon' is an axis on the Earth: 10, 11.75 degrees",
                      "'time' is the time: 6, 6 hours since 2020-02-29, calendar standard", "'u' is component x: "):
            self.assertIn(words, done.stderr)
        self.assertRegex(done.stderr, r"169.1 x 133.4 x 0.04 km; the mean flow is \(.*\), .* degrees from x towards y, .*"
                         "2020-02-29T06:00:00; z is up")

    def test_mistaken_answers(self):
        self.writes(earth_flows.sea())
        for words, answer in (("no variable 'w'", "w:units=m/s"), ("is not NAME:ATTRIBUTE=VALUE", "u=m/s")):
            self.assertIn(words, self.fails(2, "vdblic_import", "f.nc", "-o", "v.%04d.vdb", "--attribute", answer))

    def test_groups(self):
        import netCDF4  # pylint: disable=import-outside-toplevel

        file = earth_flows.sea()
        axes = {name: value for name, value in file.items() if name not in "uv"}
        self.writes(axes)
        with netCDF4.Dataset(self.folder / "f.nc", "a") as data:
            group = data.createGroup("model/output")
            for name in "uv":
                variable = group.createVariable(name, "f8", file[name][0])
                variable.setncatts(file[name][2])
                variable[:] = file[name][1]
        path, = self.imports("f.nc", "-o", "v.%04d.vdb")
        self.assertAlmostEqual(velocity_of(path)[0][0, 0, -1, 0], east(10, 40, -5), 5)


if __name__ == "__main__":
    unittest.main()
