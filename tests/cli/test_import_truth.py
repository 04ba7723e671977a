"""vdblic_import against xarray and arithmetic at random points: flows that are linear in nothing, in files as models cut them."""

import unittest

import netCDF4
import numpy
import pyopenvdb as vdb

import earth_flows
import netcdf_flows
import truth
from imports import ImportHere


class TruthTest(ImportHere):
    def setUp(self):
        super().setUp()
        self.random = numpy.random.default_rng(3)

    def sea(self, longitude, latitude, **units):
        """A file of random values on longitude, latitude and depth, two times."""
        file = earth_flows.sea(longitude, latitude)
        for name in "uv":
            shape = 2, len(earth_flows.DEPTHS), len(latitude), len(longitude)
            file[name][1] = self.random.normal(size=shape)
            file[name][2] |= units
        file["time"][1] = numpy.array([6.0, 30])
        return file

    def imported(self, file, *options):
        earth_flows.write(self.folder / "f.nc", file)
        return self.imports("f.nc", "-o", "v.%04d.vdb", *options)

    def assert_random(self, file, longitude, *options, scale=1):
        """The second step, against xarray's reading."""
        import xarray  # pylint: disable=import-outside-toplevel

        path = self.imported(file, *options)[1]
        with xarray.open_dataset(self.folder / "f.nc", decode_times=False) as data:
            order = numpy.argsort(numpy.where(data.lon < longitude, data.lon + 360, data.lon))
            u, v = (data[name][1].values[..., order] * scale for name in "uv")
            x, y = truth.plane(numpy.where(data.lon < longitude, data.lon + 360, data.lon)[order], data.lat.values)
            truth.assert_on_axes(path, [x, y, -data.depth.values], numpy.stack([u, v, 0 * u], axis=-1), 2e-3)
        self.assertEqual(vdb.readMetadata(str(path))["time"], 86400)
        self.assertEqual(vdb.readMetadata(str(path))["start"], "2020-02-29T06:00:00")


class Axes(TruthTest):
    def test_even_and_uneven_axes(self):
        latitude = numpy.cumsum(numpy.linspace(0.2, 0.5, 9)) + 30
        for longitude in 10 + 0.25 * numpy.arange(12), numpy.float32(-125.92 + 0.08 * numpy.arange(26)).astype(float):
            self.assert_random(self.sea(longitude, latitude), -180)
            self.assert_random(self.sea(longitude, latitude[::-1]), -180)

    def test_longitudes_across_a_cut_and_units(self):
        latitude = 40 + 0.5 * numpy.arange(8)
        longitude = numpy.r_[-180:-172.0:0.5, 172:180:0.5]
        self.assert_random(self.sea(longitude, latitude, units="cm s-1"), 0, scale=0.01)

    def test_degrees_in_single_precision_are_even(self):
        """HYCOM's steps of 0.04 degrees are uneven by the rounding of numbers only."""
        longitude, latitude = numpy.float32(-125.92 + 0.08 * numpy.arange(26)), numpy.float32(47 + 0.04 * numpy.arange(52))
        file = self.sea(longitude.astype(float), latitude.astype(float))
        earth_flows.write(self.folder / "f.nc", file)
        done = self.run_tool("vdblic_import", "f.nc", "-o", "v.%04d.vdb", "--size", 26, 52, 4)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in "uv":  # land at one side
            file[name][1] = file[name][1][:, :1]
            file[name][1][..., :13] = numpy.nan
        file["depth"][1] = file["depth"][1][:1]
        earth_flows.write(self.folder / "f.nc", file)
        done = self.run_tool("vdblic_import", "f.nc", "-o", "v.%04d.vdb")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("of the cells have a voxel", done.stderr)
        self.assertEqual(vdb.read(str(self.folder / "v.0001.vdb"), "velocity").activeVoxelCount(), 13 * 52)

    def test_coordinates_of_another_name_than_their_dimension(self):
        file = earth_flows.sea()
        for name, dimension in ("lon", "longitude"), ("lat", "latitude"), ("depth", "level"):
            file[name][0] = (dimension,)
        for name in "uv":
            file[name][0] = ("time", "level", "latitude", "longitude")
        path, = self.imported(file)
        at, found, _ = truth.random_voxels(path)
        place = earth_flows.on_earth(at, (10.875, 40.5))
        numpy.testing.assert_allclose(found[:, 0], earth_flows.east(*place), atol=1e-5)

    def test_an_axis_that_is_none_of_space_or_time(self):
        file = earth_flows.sea()
        for name in "uv":
            file[name][0] = ("member", "depth", "lat", "lon")
            file[name][1] = numpy.repeat(file[name][1], 2, axis=0)
        earth_flows.write(self.folder / "f.nc", file)
        message = self.fails(3, "vdblic_import", "f.nc", "-o", "v.vdb")
        self.assertIn("the axis 'member' of 'u' is of no known kind; say it", message)
        self.assertIn("keep one: ncks -d member,0", message)


class Curved(TruthTest):
    def test_a_turned_global_grid(self):
        """A grid in degrees about another pole: components along it, at its points against the exact direction."""
        columns, rows = numpy.meshgrid(numpy.arange(0, 360, 10.0), numpy.arange(-60, 61, 10.0))
        turned, pole = numpy.radians([columns, rows]), numpy.radians(60)  # the pole lies at 180 E, 60 N
        x, y, z = numpy.cos(turned[1]) * numpy.cos(turned[0]), numpy.cos(turned[1]) * numpy.sin(turned[0]), numpy.sin(turned[1])
        x, z = x * numpy.sin(pole) - z * numpy.cos(pole), x * numpy.cos(pole) + z * numpy.sin(pole)
        longitude, latitude = numpy.degrees(numpy.arctan2(y, x)), numpy.degrees(numpy.arcsin(z))
        to_pole = numpy.radians(180 - longitude)  # the bearing of the pole from each point
        bearing = numpy.arctan2(numpy.sin(to_pole) * numpy.cos(pole), numpy.cos(numpy.radians(latitude)) * numpy.sin(pole)
                                - numpy.sin(numpy.radians(latitude)) * numpy.cos(pole) * numpy.cos(to_pole))
        flow = 3 * numpy.cos(turned[1]), numpy.sin(turned[0])
        east = flow[0] * numpy.cos(bearing) + flow[1] * numpy.sin(bearing)
        north = flow[1] * numpy.cos(bearing) - flow[0] * numpy.sin(bearing)
        file = {"lon": [("j", "i"), longitude, {"units": "degrees_east"}], "lat": [("j", "i"), latitude, {"units": "degrees_north"}]}
        for name, values, kind in ("u", flow[0], "x_wind"), ("v", flow[1], "y_wind"):
            told = {"units": "m/s", "standard_name": kind, "coordinates": "lon lat"}
            file[name] = [("j", "i"), values + 0 * longitude, told]
        path, = self.imported(file, "--size", 90, 60, 1)
        longitude = numpy.unwrap(longitude, period=360, axis=1)  # as the plane has them
        longitude += (numpy.unwrap(longitude[:, 0], period=360) - longitude[:, 0])[:, None]
        x, y = truth.plane(longitude, latitude)
        grid, close = vdb.read(str(path), "velocity"), []
        read, level = grid.getConstAccessor(), grid.transform.indexToWorld(grid.evalActiveVoxelBoundingBox()[0])[2]
        for place in numpy.ndindex(longitude.shape):
            index = tuple(round(number) for number in grid.transform.worldToIndex((x[place], y[place], level)))
            if read.isValueOn(index):
                value = read.getValue(index)
                close.append(numpy.hypot(value[0] - east[place], value[1] - north[place]))
        self.assertGreater(len(close), 150)
        self.assertLess(numpy.median(close), 0.25)
        self.assertLess(numpy.percentile(close, 95), 1)  # a wrong angle is a speed of 3


class CGrids(TruthTest):
    """SGRID: what lies on edges has no coordinates; it is half way between those of the cells' middles or corners."""

    def test_every_padding(self):
        for padding in "none", "low", "high", "both":
            for given in "face", "node":
                for curved in True, False:
                    with self.subTest(padding, given=given, curved=curved):
                        file, edges = earth_flows.c_grid(padding, given, curved)
                        path, = self.imported(file)
                        at, found, _ = truth.random_voxels(path)
                        place = earth_flows.on_earth(at, [(part.min() + part.max()) / 2 for part in edges])
                        numpy.testing.assert_allclose(found[:, 0], earth_flows.east(*place), atol=1e-5)
                        numpy.testing.assert_allclose(found[:, 1], earth_flows.north(*place), atol=1e-5)

    def test_a_turned_grid(self):
        """Components are along it: one of 0.5 along its rows points to its angle."""
        file, _ = earth_flows.c_grid("both", "face", angle=0.6)
        for name, speed in ("u", 0.5), ("v", 0.0):
            file[name][1] = speed + 0 * file[name][1]
        path, = self.imported(file)
        _, found, _ = truth.random_voxels(path)
        turn = numpy.arctan2(0.2 * numpy.sin(0.6), 0.25 * numpy.cos(0.6) * numpy.cos(numpy.radians(40)))
        numpy.testing.assert_allclose(found[:, :2], 0.5 * numpy.array([[numpy.cos(turn), numpy.sin(turn)]] * len(found)), atol=0.01)

    def test_contradictions(self):
        for key, value, words in (
                ("face_dimensions", "xc: xn (padding: none) yc: yn (padding: both)",
                 "the grid contradicts itself about the padding of 'xc'"),
                ("edge2_dimensions", "xc: xn (padding: middle) yn", "'middle' is no padding, which is none, low, high or both"),
                ("edge1_dimensions", "xn yc: yn (padding: low)", "7 nodes along 'yn' and the padding 'low' make 7 places along "
                 "'yc', which has 8; correct it: --attribute 'grid:edge1_dimensions=xn yc: yn (padding: low)'")):
            with self.subTest(words):
                file, _ = earth_flows.c_grid("both", "face")
                file["grid"][2][key] = value
                earth_flows.write(self.folder / "f.nc", file)
                self.assertIn(words, self.refuses(3, "f.nc", "-o", "v.vdb"))
        file, _ = earth_flows.c_grid("both", "face")
        file["grid"][2] = {key: str(value).replace("both", "low") for key, value in file["grid"][2].items()}
        file["grid"][2]["edge1_dimensions"] = "xn yc"
        earth_flows.write(self.folder / "f.nc", file)
        self.assertIn("9 nodes along 'xn' and the padding 'low' make 9 places along 'xc', which has 10",
                      self.refuses(3, "f.nc", "-o", "v.vdb"))


def kept(path, new, sizes, change=None):
    """A copy of a NetCDF file without the ends of dimensions; `change` alters variables: name, values, attributes."""
    with netCDF4.Dataset(path) as whole, netCDF4.Dataset(new, "w") as cut:
        for name, size in whole.dimensions.items():
            cut.createDimension(name, sizes.get(name, len(size)))
        for name, variable in whole.variables.items():
            told = {key: variable.getncattr(key) for key in variable.ncattrs() if key != "_FillValue"}
            values = variable[tuple(slice(sizes.get(d, len(whole.dimensions[d]))) for d in variable.dimensions)]
            values, told = change(name, values, told) if change else (values, told)
            made = cut.createVariable(name, values.dtype, variable.dimensions)
            made.setncatts(told)
            made.set_auto_maskandscale(False)
            made[...] = values


class Roms(TruthTest):
    def assert_same(self, name, share):
        """f.nc and another file are one flow, at a share of the voxels."""
        path = self.imports("f.nc", "-o", "v.vdb", "--size", 30, 24, 20)[0]
        other = vdb.read(str(self.imports(name, "-o", "w.vdb", "--like", path)[0]), "velocity")
        read = other.getConstAccessor()
        apart = [numpy.abs(numpy.subtract(voxel.value, read.getValue(voxel.min))).max()
                 for voxel in vdb.read(str(path), "velocity").citerOnValues() if read.isValueOn(voxel.min)]
        self.assertGreater(len(apart), 1000)
        self.assertLess(numpy.quantile(apart, share), 1e-3)

    def test_a_cut_with_as_many_faces_as_cells(self):
        """As tools cut files: the face after each cell; of the last cells it is missing."""
        netcdf_flows.write_ocean(self.folder / "f.nc", [0], angle=0.4)
        kept(self.folder / "f.nc", self.folder / "cut.nc", {"xi_rho": 8, "xi_v": 8, "eta_rho": 6, "eta_u": 6})
        middle = self.imports("cut.nc", "-o", "c.vdb")
        self.assertTrue(middle)
        kept(self.folder / "f.nc", self.folder / "same.nc", {"xi_rho": 8, "xi_v": 8, "eta_rho": 6, "eta_u": 6, "xi_u": 7, "eta_v": 5})
        (self.folder / "f.nc").unlink()
        (self.folder / "same.nc").rename(self.folder / "f.nc")
        self.assert_same("cut.nc", 0.6)  # but for the last cells

    def test_rows_and_columns_of_any_name(self):
        netcdf_flows.write_ocean(self.folder / "f.nc", [0])
        kept(self.folder / "f.nc", self.folder / "other.nc", {})
        with netCDF4.Dataset(self.folder / "other.nc", "r+") as data:
            for name in "rho", "u", "v":
                data.renameDimension(f"xi_{name}", f"swap_{name}")
                data.renameDimension(f"eta_{name}", f"xi_{name}")
                data.renameDimension(f"swap_{name}", f"eta_{name}")
        self.assert_same("other.nc", 1)

    def test_a_valid_range_of_unpacked_values(self):
        """Of the type of the scale, so of unpacked values (NetCDF Users Guide); of short numbers it is of those."""
        netcdf_flows.write_ocean(self.folder / "f.nc", [0])

        def packed(name, values, told):
            if name != "Cs_r":
                return values, told
            numbers = numpy.rint(values * 30000).astype("i2")
            return numbers, told | {"scale_factor": 1 / 30000, "valid_min": low, "valid_max": high}

        for low, high in (-1.0, 0.0), (numpy.int16(-30000), numpy.int16(0)):
            kept(self.folder / "f.nc", self.folder / "p.nc", {}, packed)
            self.assert_same("p.nc", 0.9)
        low, high = numpy.int16(-1), numpy.int16(0)
        kept(self.folder / "f.nc", self.folder / "p.nc", {}, packed)
        self.assertIn("'Cs_r', which gives other values their place, lacks", self.fails(3, "vdblic_import", "p.nc", "-o", "w.vdb"))


class Meshes(TruthTest):
    def triangles(self):
        file, lon, lat = earth_flows.fvcom()
        return file, lon, lat

    def test_cells_by_their_corners(self):
        """As ICON has them: bounds of longitude and latitude, in radians, on a level of pressure."""
        _, lon, lat = self.triangles()
        middle = lon.mean(axis=1), lat.mean(axis=1)
        file = {"p": [("p",), numpy.array([1e5, 8.5e4]), {"units": "Pa", "standard_name": "air_pressure", "positive": "down"}]}
        for name, kind, values, corners in ("clon", "longitude", middle[0], lon), ("clat", "latitude", middle[1], lat):
            file[name] = [("cell",), numpy.radians(values), {"units": "radian", "standard_name": kind, "bounds": name + "_bnds"}]
            file[name + "_bnds"] = [("cell", "vertices"), numpy.radians(corners), {}]
        for name, flow in ("u", earth_flows.east), ("v", earth_flows.north):
            values = flow(*middle, 0 * middle[0])
            file[name] = [("p", "cell"), numpy.stack([values, values]), {"units": "m/s", "coordinates": "clon clat"}]
        del file["p"][2]["positive"]
        earth_flows.write(self.folder / "f.nc", {name.replace("cell", "ncells"): [
            tuple(d.replace("cell", "ncells") for d in part[0]), *part[1:]] for name, part in file.items()})
        path, = self.imports("f.nc", "-o", "v.vdb", "--size", 40, 40, 2)
        at, found, _ = truth.random_voxels(path)
        place = earth_flows.on_earth(at, (-122.4, 37.7))
        numpy.testing.assert_allclose(found[:, 0], earth_flows.east(place[0], place[1], 0 * at[:, 2]), atol=0.01)
        self.assertAlmostEqual(at[:, 2].min(), (110.9 * 3 + 1457.3) / 4 - 673.2, delta=400)

    def test_models(self):
        """SCHISM and FESOM as they name what UGRID describes; a number of the first node that is no integer."""
        file, lon, lat = self.triangles()
        nodes = {name: file[name] for name in ("lon", "lat", "time")}
        x, y = file["lon"][1], file["lat"][1]
        z = numpy.linspace(-30, 0, 4) + 0 * x[:, None]
        velocity = numpy.stack([earth_flows.east(x[:, None], y[:, None], z), earth_flows.north(x[:, None], y[:, None], z)], axis=-1)
        schism = {
            "SCHISM_hgrid_node_x": [("nSCHISM_hgrid_node",), x, {"units": "degrees_east"}],
            "SCHISM_hgrid_node_y": [("nSCHISM_hgrid_node",), y, {"units": "degrees_north"}],
            "SCHISM_hgrid_face_nodes": [("nSCHISM_hgrid_face", "four"), numpy.concatenate(
                [file["nv"][1].T, numpy.full((lon.shape[0], 1), -1, "i4")], axis=1), {}],
            "zcor": [("time", "nSCHISM_hgrid_node", "nSCHISM_vgrid_layers"), z[None], {}],
            "hvel": [("time", "nSCHISM_hgrid_node", "nSCHISM_vgrid_layers", "two"), velocity[None], {"units": "m/s"}],
            "time": nodes["time"]}
        fesom = {"lon": [("nod2",), x, {"units": "degree"}], "lat": [("nod2",), y, {"units": "degree"}],
                 "elements": [("n3", "elem"), file["nv"][1], {}],
                 "nz": [("nz",), numpy.linspace(30, 0, 4), {"units": "m", "positive": "down"}], "time": nodes["time"]}
        ugrid = {"mesh": [(), numpy.array(0, "i4"), {"cf_role": "mesh_topology", "topology_dimension": 2,
                          "node_coordinates": "lon lat", "face_node_connectivity": "faces"}],
                 "faces": [("face", "three"), file["nv"][1].T, {"start_index": 1.0}],
                 "lon": [("node",), x, {"units": "degrees_east"}], "lat": [("node",), y, {"units": "degrees_north"}],
                 "z": [("layer", "node"), z.T, {"units": "m", "positive": "up"}]}
        for i, name in enumerate("uv"):
            fesom[name] = [("time", "nod2", "nz"), velocity[None, ..., i], {"units": "m/s"}]
            ugrid[name] = [("layer", "node"), velocity[..., i].T, {"units": "m/s"}]
        for kind, model in ("SCHISM", schism), ("FESOM", fesom), ("UGRID", ugrid):
            with self.subTest(kind):
                earth_flows.write(self.folder / "f.nc", model)
                path, = self.imports("f.nc", "-o", "v.vdb", "--size", 30, 30, 20)
                at, found, _ = truth.random_voxels(path)
                place = earth_flows.on_earth(at, (-122.4, 37.7))
                numpy.testing.assert_allclose(found[:, 0], earth_flows.east(*place), atol=1e-4)
                numpy.testing.assert_allclose(found[:, 1], earth_flows.north(*place), atol=1e-4)


class Fesom(TruthTest):
    """Random velocities at FESOM's nodes on levels, or in its triangles in layers, against interpolation by hand."""

    def setUp(self):
        super().setUp()
        file, _, _ = earth_flows.fvcom(size=5)
        self.lon, self.lat, self.triangles = file["lon"][1], file["lat"][1], file["nv"][1].T - 1
        self.depths = numpy.array([2.0, 6, 12, 20])

    def write(self, place, levels):
        """The file; returns the velocities as (levels, places, 2)."""
        count = len(self.lon) if place == "nod2" else len(self.triangles)
        values = self.random.normal(size=(len(self.depths), count, 2))
        file = {"lon": [("nod2",), self.lon, {"units": "degrees_east"}], "lat": [("nod2",), self.lat, {"units": "degrees_north"}],
                "elements": [("n3", "elem"), (self.triangles.T + 1).astype("i4"), {}],
                levels: [(levels,), self.depths, {"units": "m", "positive": "down"}]}
        for i, name in enumerate("uv"):
            file[name] = [(levels, place), values[..., i], {"units": "m/s"}]
        earth_flows.write(self.folder / "f.nc", file)
        return values

    def shares(self, at):
        """The triangles in which positions are, and the shares of their corners."""
        x, y = truth.plane(self.lon, self.lat)
        corners = numpy.stack([x, y, numpy.ones_like(x)], axis=1)[self.triangles]
        known = numpy.stack([at[:, 0], at[:, 1], numpy.ones(len(at))], axis=1)
        shares = numpy.einsum("pk,tkc->ptc", known, numpy.linalg.inv(corners))
        inside = shares.min(axis=2).argmax(axis=1)
        return inside, shares[numpy.arange(len(at)), inside]

    def test_at_nodes(self):
        values = self.write("nod2", "nz")
        path, = self.imports("f.nc", "-o", "v.vdb", "--size", 20, 20, 16)
        at, found, _ = truth.random_voxels(path)
        inside, shares = self.shares(at)
        below = numpy.clip(numpy.searchsorted(self.depths, -at[:, 2]) - 1, 0, 2)
        down = (-at[:, 2] - self.depths[below]) / numpy.diff(self.depths)[below]
        corners = self.triangles[inside]
        columns = values[below[:, None], corners] * (1 - down)[:, None, None] + values[below[:, None] + 1, corners] * down[:, None, None]
        numpy.testing.assert_allclose(found[:, :2], (columns * shares[..., None]).sum(axis=1), atol=1e-4)

    def test_in_triangles(self):
        """The mean of the cells around each corner, interpolated, and in the middle of a cell its own value."""
        values = self.write("elem", "nz1")
        path, = self.imports("f.nc", "-o", "v.vdb", "--size", 20, 20, 16)
        at, found, _ = truth.random_voxels(path)
        middles = (self.depths[1:] + self.depths[:-1]) / 2
        edges = numpy.r_[2 * self.depths[0] - middles[0], middles, 2 * self.depths[-1] - middles[-1]]
        sums, counts = (numpy.zeros((len(edges), len(self.lon), n)) for n in (2, 1))
        for layer in range(len(self.depths)):
            for edge in layer, layer + 1:
                for corner in range(3):
                    numpy.add.at(sums[edge], self.triangles[:, corner], values[layer])
                    numpy.add.at(counts[edge], self.triangles[:, corner], 1)
        means = sums / counts
        inside, shares = self.shares(at)
        layer = numpy.clip(numpy.searchsorted(edges, -at[:, 2]) - 1, 0, len(self.depths) - 1)
        down = ((-at[:, 2] - edges[layer]) / numpy.diff(edges)[layer])[:, None, None]
        above, below = means[layer[:, None], self.triangles[inside]], means[layer[:, None] + 1, self.triangles[inside]]
        lacking = values[layer, inside] - (above.mean(axis=1) + below.mean(axis=1)) / 2
        expected = ((above * (1 - down) + below * down) * shares[..., None]).sum(axis=1) + lacking
        away = (shares.min(axis=1) > 0.01) & (numpy.abs(down[:, 0, 0] - 0.5) < 0.49)  # from the borders of cells
        self.assertGreater(away.sum(), 600)
        numpy.testing.assert_allclose(found[away, :2], expected[away], atol=1e-4)


class Carried(TruthTest):
    def test_a_vector_is_turned_as_the_velocity(self):
        """Stress along a grid that is turned by 0.7, beside the velocity; one component alone is refused."""
        file = earth_flows.turned()
        for name, other in ("tx", "u"), ("ty", "v"):
            told = file[other][2] | {"standard_name": f"surface_downward_{name[1]}_stress", "units": "Pa"}
            file[name] = [file[other][0], 3 * file[other][1], told]
        path, = self.imported(file, "--carry", "ty,tx,u")
        for name, value in ("tx", 1.5), ("ty", 0), ("u", 0.5):
            values = [voxel.value for voxel in vdb.read(str(path), name).citerOnValues()]
            numpy.testing.assert_allclose(values, value, atol=0.01)
        self.assertIn("'tx' is the component x of a vector along a grid that is turned; carry the other one, too",
                      self.fails(3, "vdblic_import", "f.nc", "-o", "w.vdb", "--carry", "tx"))

    def test_of_roms(self):
        netcdf_flows.write_ocean(self.folder / "f.nc", [0], angle=0.4)
        with netCDF4.Dataset(self.folder / "f.nc", "r+") as data:
            for name in "uv":
                data.createVariable(f"{name}_stokes", "f8", data[name].dimensions)[...] = 2 * data[name][:]
        path, = self.imports("f.nc", "-o", "v.%04d.vdb", "--carry", "u_stokes,v_stokes")
        read = [vdb.read(str(path), name).getConstAccessor() for name in ("u_stokes", "v_stokes")]
        voxels = list(vdb.read(str(path), "velocity").citerOnValues())
        self.assertGreater(len(voxels), 100)
        for voxel in voxels:
            numpy.testing.assert_allclose([grid.getValue(voxel.min) for grid in read], numpy.multiply(2, voxel.value[:2]), atol=1e-5)


class Answers(TruthTest):
    def test_of_several_files(self):
        """An answer is of the files that have the variable; one that no file has is refused."""
        file = earth_flows.sea()
        for name, other in ("u", "v"), ("v", "u"):
            del file[name][2]["units"]
            earth_flows.write(self.folder / f"{name}.nc", {key: part for key, part in file.items() if key != other})
        answers = "u:units=m/s", "v:units=m/s"
        path, = self.imports("u.nc", "v.nc", "-o", "w.vdb", "--attribute", *answers)
        at, found, _ = truth.random_voxels(path)
        numpy.testing.assert_allclose(found[:, 0], earth_flows.east(*earth_flows.on_earth(at, (10.875, 40.5))), atol=1e-5)
        self.assertIn("--attribute q: there is no variable 'q'; u.nc has lon",
                      self.fails(2, "vdblic_import", "u.nc", "v.nc", "-o", "x.vdb", "--attribute", *answers, "q:units=m/s"))


if __name__ == "__main__":
    unittest.main()
