"""vdblic_import --globe: longitude, latitude and height become a Cartesian shell; the flow is that of the sphere."""

import unittest

import numpy
import pyopenvdb as vdb

import earth_flows
import netcdf_flows
from earth_flows import HEIGHTS, OMEGA, RADIUS, unit_vectors, wind
from imports import ImportHere, velocity_of


def whole(step=3.0, first=0.0):
    """Axes around the Earth, which end half a spacing before the poles."""
    return first + numpy.arange(0, 360, step), numpy.arange(-90 + step / 2, 90, step)


class GlobeTest(ImportHere):
    def globe(self, file, *options, name="f.nc"):
        earth_flows.write(self.folder / name, file)
        return self.imports(name, "-o", "v.%04d.vdb", "--globe", *options)[0]

    def assert_rotates(self, path, exaggeration, up=0.0):
        """The flow is omega x r at every voxel of the data; its speed that of the file. Returns what velocity_of does."""
        values, active, at = velocity_of(path)
        rim = velocity_of(path, "rim")[0]
        inside = active & (rim > 0)
        radius = numpy.linalg.norm(at, axis=-1, keepdims=True).clip(0.1)
        expected = numpy.cross(OMEGA, at) + up * exaggeration / 1e6 * at / radius
        most = abs(expected[active]).max()
        self.assertGreater(inside.sum(), 100)
        numpy.testing.assert_allclose(values[inside], expected[inside], atol=1e-3 * most)
        height = (radius[..., 0] - RADIUS / 1e6) / exaggeration * 1e6
        if HEIGHTS[0] <= height[inside].min():
            speed = numpy.linalg.norm(numpy.cross(OMEGA, at / radius), axis=-1) * (RADIUS + height)
            speed = numpy.hypot(speed, up)[inside]
            numpy.testing.assert_allclose(velocity_of(path, "speed")[0][inside], speed, atol=1e-3 * speed.max())
        return values, active, at


class Sphere(GlobeTest):
    def test_rotation_about_an_axis_that_is_tilted(self):
        path = self.globe(wind(*whole(), up=0.5), "--voxel-size", 0.15)
        exaggeration = vdb.readMetadata(str(path))["exaggeration"]
        self.assertEqual(exaggeration, 70)  # 9 km are 0.63 of 6.371, between a twentieth and a tenth
        _, active, at = self.assert_rotates(path, exaggeration, 0.5)
        radius = numpy.linalg.norm(at, axis=-1)
        self.assertLess(radius[active].min(), 6.371 - 0.15)  # a margin beyond the data
        self.assertGreater(radius[active].max(), 6.371 + 0.63 + 0.15)
        shell = (radius > 6.371229) & (radius < 6.371229 + 0.63)
        self.assertTrue(active[shell].all())  # no seam, no hole at the poles
        height = velocity_of(path, "height")[0]
        numpy.testing.assert_allclose(height[shell], (radius[shell] - 6.371229) / 70 * 1e6, atol=1)
        self.assertEqual(vdb.read(str(path), "speed").metadata["unit"], "m/s")
        self.assertEqual(vdb.readMetadata(str(path))["length_unit"], "Mm")

    def test_film(self):
        """A film has the true speed in m/s."""
        self.globe(wind(*whole(9.0)))
        done = self.run_tool("vdblic_film", "v.%04d.vdb", "-o", "globe.png", "--size", 96, 64)
        self.assertEqual(done.returncode, 0, done.stderr)
        for part in "--carry speed", "--color-by speed", "--solid v.0001.vdb:solid", "--emit v.0001.vdb:rim":
            self.assertIn(part, done.stderr)

    def test_said_aloud(self):
        earth_flows.write(self.folder / "f.nc", wind(*whole()))
        done = self.run_tool("vdblic_import", "f.nc", "-o", "v.%04d.vdb", "--globe")
        self.assertIn("that of 0 to 9000 m is 9.9 % of the Earth's radius, because heights are exaggerated 70 times",
                      done.stderr)
        self.assertIn("voxels of 0.3336", done.stderr)  # 3 degrees on the equator

    def test_exaggeration(self):
        path = self.globe(wind(*whole()), "--exaggerate", 40, "--voxel-size", 0.15)
        self.assert_rotates(path, 40)

    def test_flow_goes_on_in_the_margin(self):
        path = self.globe(wind(*whole(), heights=HEIGHTS + 1000), "--voxel-size", 0.15)
        values, active, at = velocity_of(path)
        outer = active & (velocity_of(path, "rim")[0] < 0)
        self.assertGreater(outer.sum(), 100)
        numpy.testing.assert_allclose(values[outer], numpy.cross(OMEGA, at)[outer], atol=2e-3 * abs(values[outer]).max())

    def test_conventions_of_longitude(self):
        """The same bytes of grids from 0 to 360, from -180 to 180, westward, and northward or southward."""
        longitude, latitude = whole()
        first = self.grids_of(self.globe(wind(longitude, latitude)))
        n, m = len(longitude), len(latitude)
        for columns, rows in ((numpy.arange(n) - n // 2, numpy.arange(m)), (numpy.arange(n)[::-1], numpy.arange(m)),
                              (numpy.arange(n), numpy.arange(m)[::-1])):
            file = wind(longitude, latitude)
            file["lon"][1] = numpy.where(columns < 0, -360, 0) + longitude[columns]
            file["lat"][1] = latitude[rows]
            for name in "u", "v", "w":
                file[name][1] = file[name][1][:, rows][:, :, columns]
            for name, values in self.grids_of(self.globe(file)).items():
                self.assertEqual(values, first[name], name)

    def grids_of(self, path):
        return {name: velocity_of(path, name)[0].tobytes() for name in ("velocity", "speed", "rim", "height")}

    def test_date_line(self):
        for first in 0.0, -180.0, -178.5:
            values, active, at = velocity_of(self.globe(wind(*whole(first=first)), "--voxel-size", 0.15))
            by_line = active & (abs(at[..., 1]) < 0.2) & (at[..., 0] < 0)
            self.assertGreater(by_line.sum(), 100)
            self.assertLess(abs(values - numpy.cross(OMEGA, at))[by_line].max(), 1e-3 * abs(values).max())

    def test_components_between_each_others_columns(self):
        """There is no gap at the seam, whichever columns come first there."""
        longitude, latitude = whole()
        for first, shift in (0.0, 1.5), (1.5, -1.5):
            file, other = wind(longitude + first, latitude), wind(longitude + first + shift, latitude)
            file["lon_v"] = [("lon_v",), *other["lon"][1:]]
            file["v"] = [(*file["v"][0][:-1], "lon_v"), *other["v"][1:]]
            _, active, at = self.assert_rotates(self.globe(file, "--voxel-size", 0.08), 70)
            radius = numpy.linalg.norm(at, axis=-1)
            self.assertTrue(active[(radius > 6.371229) & (radius < 6.371229 + 0.63)].all())

    def test_rows_at_the_poles(self):
        longitude, _ = whole()
        self.assert_rotates(self.globe(wind(longitude, numpy.arange(-90, 90.1, 3)), "--voxel-size", 0.15), 70)

    def test_columns_of_heights(self):
        """Pressure levels with a geopotential: heights differ from column to column."""
        longitude, latitude = whole()
        file = wind(longitude, latitude)
        bumps = 1 + 0.1 * numpy.sin(numpy.radians(longitude)) + 0 * latitude[:, None]
        height = HEIGHTS[:, None, None] * bumps
        out, east, north = unit_vectors(longitude[None, None, :], latitude[None, :, None])
        flow = numpy.cross(OMEGA, out) * (RADIUS + height)[..., None]
        del file["height"]
        here = "level", "lat", "lon"
        file["level"] = [("level",), numpy.array([1000.0, 700, 450, 300]), {"units": "hPa"}]
        file["z"] = [here, height * 9.80665, {"units": "m2 s-2", "standard_name": "geopotential"}]
        for name, vector in ("u", east), ("v", north):
            file[name] = [here, (flow * vector).sum(-1), file[name][2]]
        del file["w"]
        path = self.globe(file, "--voxel-size", 0.2)
        exaggeration = vdb.readMetadata(str(path))["exaggeration"]
        _, active, at = self.assert_rotates(path, exaggeration)
        radius = numpy.linalg.norm(at, axis=-1)
        self.assertTrue(active[(radius > 6.38) & (radius < 6.38 + 0.9 * exaggeration * 9e-3)].all())  # at the poles, too

    def test_files_of_components(self):
        file, here = wind(*whole()), {}
        for name in "u", "v":
            here[name] = {key: file[key] for key in ("lon", "lat", "height", name)}
            earth_flows.write(self.folder / f"{name}.nc", here[name])
        path, = self.imports("u.nc", "v.nc", "-o", "v.%04d.vdb", "--globe", "--voxel-size", 0.15)
        self.assert_rotates(path, 70)


class Parts(GlobeTest):
    def test_single_layer(self):
        longitude, latitude = whole()
        file = wind(longitude, latitude, heights=numpy.zeros(1))
        path = self.globe(file, "--voxel-size", 0.15)
        _, active, at = self.assert_rotates(path, 1)
        radius = numpy.linalg.norm(at, axis=-1)
        numpy.testing.assert_array_equal(active, abs(radius - 6.371229) <= 0.225)  # three voxels
        speed = velocity_of(path, "speed")[0][active]
        across = numpy.linalg.norm(numpy.cross(OMEGA, at / radius.clip(0.1)[..., None]), axis=-1)[active] * RADIUS
        numpy.testing.assert_allclose(speed, across, atol=1e-3 * across.max())

    def test_land_is_solid(self):
        longitude, latitude = whole()
        file = wind(longitude, latitude, heights=numpy.zeros(1))
        land = (abs(longitude - 90) < 20) & (abs(latitude) < 20)[:, None]
        for name in "u", "v":
            file[name][1][:, land] = numpy.nan
        path = self.globe(file, "--voxel-size", 0.15)
        _, active, at = self.assert_rotates(path, 1)
        grid = vdb.read(str(path), "solid").getConstAccessor()
        solid = lambda *place: grid.getValue(tuple(round(x / 0.15) for x in place)) > 0
        self.assertTrue(solid(0, 6.371, 0))  # the middle of the land
        self.assertFalse(solid(6.371, 0, 0))  # water
        self.assertTrue(solid(5.95, 0, 0))  # the Earth below
        self.assertFalse(solid(0, 7.0, 0))
        middle = numpy.linalg.norm(at - (0, 6.371, 0), axis=-1) < 0.5
        self.assertFalse(active[middle].any())

    def test_region(self):
        for west in -20.0, 340.0, 170.0:  # across Greenwich, in both conventions, and across the date line
            file = wind(west + numpy.arange(0, 40.5, 1), numpy.arange(30, 60.5, 1))
            path = self.globe(file)
            self.assertEqual(vdb.readMetadata(str(path))["exaggeration"], 70)
            values, active, at = self.assert_rotates(path, 70)
            longitude = (numpy.degrees(numpy.arctan2(at[..., 1], at[..., 0])) - west) % 360
            latitude = numpy.degrees(numpy.arctan2(at[..., 2], numpy.hypot(at[..., 0], at[..., 1])))
            from_edge = numpy.minimum(numpy.minimum(longitude, 40 - longitude), numpy.minimum(latitude - 30, 60 - latitude))
            height = (numpy.linalg.norm(at, axis=-1) - 6.371229) / 70 * 1e6
            shell = (height > 0) & (height < 9000) & (abs(from_edge) > 1e-6)
            numpy.testing.assert_array_equal(active[shell], (from_edge > 0)[shell])
            self.assertLess(numpy.prod(values.shape[:3]), 200_000)  # not the box of the Earth

    def test_turned_grid(self):
        """Components along a grid that is turned against east, as of ocean models; on its plane the angles are right to 1 %."""
        path = self.globe(earth_flows.turned(), "--exaggerate", 1000, "--voxel-size", 0.004)
        values, active, at = velocity_of(path)
        inside = active & (velocity_of(path, "rim")[0] > 0)
        self.assertGreater(inside.sum(), 50)
        radius = numpy.linalg.norm(at, axis=-1, keepdims=True)
        east = numpy.stack([-at[..., 1], at[..., 0], 0 * at[..., 0]], axis=-1) / numpy.hypot(at[..., 0], at[..., 1])[..., None]
        numpy.testing.assert_allclose(values[inside], (0.5 * radius / RADIUS * east)[inside], atol=0.01 * 0.5e-6)
        numpy.testing.assert_allclose(velocity_of(path, "speed")[0][inside], 0.5, rtol=0.01)

    def test_levels_that_follow_the_sea_floor(self):
        """ROMS: its own grid, turned, with land along one side."""
        netcdf_flows.write_ocean(self.folder / "sea.nc", [0], angle=0.4)
        path, = self.imports("sea.nc", "-o", "v.%04d.vdb", "--globe", "--exaggerate", 50, "--voxel-size", 0.002)
        values, active, at = velocity_of(path)
        radius = numpy.linalg.norm(at, axis=-1)
        longitude = numpy.degrees(numpy.arctan2(at[..., 1], at[..., 0]))
        latitude = numpy.degrees(numpy.arcsin(at[..., 2] / radius))
        inner = active & (velocity_of(path, "rim")[0] > 0.01) & (abs(longitude - 10.25) < 0.15) & (abs(latitude - 43.2) < 0.12)
        self.assertGreater(inner.sum(), 500)
        height = (radius - RADIUS / 1e6) / 50 * 1e6
        scale = RADIUS * numpy.cos(numpy.radians(43.2)), RADIUS
        place = [scale[0] * numpy.radians(longitude - 10.25), scale[1] * numpy.radians(latitude - 43.2), height]
        flow = netcdf_flows.wind(numpy.stack(place, axis=-1))
        numpy.testing.assert_allclose(velocity_of(path, "speed")[0][inner], numpy.linalg.norm(flow, axis=-1)[inner], atol=4e-3)
        flow[..., :2] *= (radius / RADIUS)[..., None]
        flow[..., 2] *= 50 / 1e6
        out, east, north = unit_vectors(longitude, latitude)
        world = flow[..., :1] * east + flow[..., 1:2] * north + flow[..., 2:] * out
        numpy.testing.assert_allclose(values[inner], world[inner], atol=4e-3 * abs(world[inner]).max())

    def test_carried(self):
        file = wind(*whole())
        file["T"] = [("height", "lat", "lon"), 280 - file["height"][1][:, None, None] / 150 + 0 * file["u"][1], {"units": "K"}]
        path = self.globe(file, "--carry", "T")
        height, active = velocity_of(path, "height")[:2]
        inside = active & (velocity_of(path, "rim")[0] > 0)
        numpy.testing.assert_allclose(velocity_of(path, "T")[0][inside], 280 - height[inside] / 150, atol=0.05)

    def test_steps(self):
        """Later steps keep the voxels of the first."""
        file = wind(*whole())
        for name in "u", "v":
            file[name] = [("time", *file[name][0]), numpy.stack([file[name][1], 2 * file[name][1]]), file[name][2]]
        file["time"] = [("time",), numpy.array([0.0, 6]), {"units": "hours since 2020-01-01"}]
        earth_flows.write(self.folder / "f.nc", file)
        a, b = (velocity_of(path) for path in self.imports("f.nc", "-o", "v.%04d.vdb", "--globe"))
        numpy.testing.assert_array_equal(a[1], b[1])
        numpy.testing.assert_allclose(b[0], 2 * a[0], rtol=1e-6)
        self.assertEqual(vdb.readMetadata(str(self.folder / "v.0002.vdb"))["time"], 21600)


class Refused(GlobeTest):
    def test_no_values(self):
        """A step without any gives a volume without any, and a warning."""
        file = wind(*whole())
        file["u"][1][...] = numpy.nan
        earth_flows.write(self.folder / "f.nc", file)
        done = self.run_tool("vdblic_import", "f.nc", "-o", "v.%04d.vdb", "--globe")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("f.nc: frame 1 has no values within the voxels", done.stderr)
        self.assertEqual(vdb.read(str(self.folder / "v.0001.vdb"), "velocity").activeVoxelCount(), 0)

    def test_options(self):
        for wrong in (["--globe", "--size", 9, 9, 9], ["--globe", "--bounds", 0, 0, 0, 1, 1, 1], ["--exaggerate", 9],
                      ["--globe", "--voxel-size", 1, 1, 2], ["--globe", "--like", "x.vdb"], ["--globe", "--exaggerate", 0]):
            self.refuses(2, "f.nc", "-o", "v.%04d.vdb", *wrong)

    def test_files(self):
        file = wind(*whole())
        file["lon"][2]["units"] = file["lat"][2]["units"] = "km"
        for name, words in ("lon", "longitude"), ("lat", "latitude"):
            file[name][2]["standard_name"] = f"projection_{'xy'[name == 'lat']}_coordinate"
        earth_flows.write(self.folder / "f.nc", file)
        message = self.refuses(3, "f.nc", "-o", "v.%04d.vdb", "--globe")
        self.assertIn("f.nc: --globe takes grids on longitude and latitude", message)
        self.assertIn("--attribute 'x:units=degrees_east'", message)
        numpy.savez(self.folder / "f.npz", velocity=numpy.ones((4, 4, 4, 3)))
        self.assertIn("f.npz: --globe takes", self.refuses(3, "f.npz", "-o", "v.%04d.vdb", "--globe", "--layout", "xyzc"))

    def test_voxels(self):
        earth_flows.write(self.folder / "f.nc", wind(*whole()))
        self.assertIn("--voxel-size", self.refuses(2, "f.nc", "-o", "v.%04d.vdb", "--globe", "--voxel-size", 1e-5))
        message = self.refuses(2, "f.nc", "-o", "v.%04d.vdb", "--globe", "--exaggerate", 0.0001, "--voxel-size", 5)
        self.assertIn("choose a smaller one", message)

    def test_names(self):
        file = wind(*whole())
        file["speed"] = [("height", "lat", "lon"), file["u"][1], {"units": "m/s"}]
        earth_flows.write(self.folder / "f.nc", file)
        self.assertIn("rename", self.refuses(2, "f.nc", "-o", "v.%04d.vdb", "--globe", "--carry", "speed"))


if __name__ == "__main__":
    unittest.main()
