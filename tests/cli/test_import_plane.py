"""vdblic_import of regions on longitude and latitude that are too large for a plane along the meridians: projected."""

import re
import unittest

import numpy

import earth_flows
from earth_flows import OMEGA, RADIUS, unit_vectors, wind
from imports import ImportHere, velocity_of


class Region(ImportHere):
    longitude, latitude = numpy.arange(-20, 20.5, 1), numpy.arange(60, 80.5, 1)

    def setUp(self):
        super().setUp()
        self.centre = unit_vectors(*numpy.meshgrid(self.longitude, self.latitude))[0].mean(axis=(0, 1))
        self.centre /= numpy.linalg.norm(self.centre)
        self.east = numpy.cross((0, 0, 1), self.centre) / numpy.hypot(*self.centre[:2])
        self.north = numpy.cross(self.centre, self.east)

    def file(self, spin):
        file = wind(self.longitude, self.latitude, heights=numpy.zeros(1))
        out, east, north = unit_vectors(self.longitude[None, None, :], self.latitude[None, :, None])
        flow = numpy.cross(spin, out) * RADIUS
        for name, along in ("u", east), ("v", north):
            file[name][1] = (flow * along).sum(-1)
        return file

    def on_sphere(self, at):
        """Directions of places on the plane, by the inverse of the stereographic projection."""
        away = numpy.hypot(at[..., 0], at[..., 1])[..., None]
        angle = 2 * numpy.arctan(away / (2 * RADIUS))
        across = (at[..., :1] * self.east + at[..., 1:2] * self.north) / numpy.maximum(away, 1e-9)
        return numpy.cos(angle) * self.centre + numpy.sin(angle) * across

    def on_plane(self, out):
        scale = 2 * RADIUS / (1 + out @ self.centre)
        return numpy.stack([scale * (out @ self.east), scale * (out @ self.north)], axis=-1)

    def assert_rotates(self, path, spin):
        """Speeds are the file's, and directions those of a short step on the sphere."""
        values, active, at = velocity_of(path)
        out = self.on_sphere(at[active])
        flow = numpy.cross(spin, out) * RADIUS
        step = self.on_plane(out + 1e-7 * flow) - self.on_plane(out - 1e-7 * flow)
        step *= numpy.linalg.norm(flow, axis=-1, keepdims=True) / numpy.linalg.norm(step, axis=-1, keepdims=True)
        numpy.testing.assert_allclose(values[active][:, :2], step, atol=1e-3 * abs(flow).max())
        self.assertGreater(active.sum(), 400)
        return values, active, at

    def test_rotation_at_70_degrees(self):
        earth_flows.write(self.folder / "f.nc", self.file(OMEGA))
        done = self.run_tool("vdblic_import", "f.nc", "-o", "v.vdb")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_rotates(self.folder / "v.vdb", OMEGA)
        told = re.search(r"projection about (\S+) degrees east, (\S+) degrees north, .* by a factor of up to (\S+)", done.stderr)
        self.assertAlmostEqual(float(told[1]), 0)
        self.assertAlmostEqual(float(told[2]), numpy.degrees(numpy.arcsin(self.centre[2])), delta=0.01)
        farthest = numpy.arccos(unit_vectors(20.0, 60.0)[0] @ self.centre)
        self.assertAlmostEqual(float(told[3]), 1 / numpy.cos(farthest / 2) ** 2, delta=5e-3)  # it has three digits

    def test_great_circle(self):
        """A jet along a great circle through the middle goes straight ahead on the plane."""
        spin = 1e-5 * self.north
        earth_flows.write(self.folder / "f.nc", self.file(spin))
        path, = self.imports("f.nc", "-o", "v.vdb", "--size", 51, 51, 1)
        values, active, at = self.assert_rotates(path, spin)
        axis = active & (abs(at[..., 1]) < 2e4)
        self.assertGreater(axis.sum(), 10)
        self.assertLess(abs(values[axis][:, 1]).max(), 1e-3 * values[axis][:, 0].max() + 1e-5 * 2.5e4)
        self.assertGreater(values[axis][:, 0].min(), 0)

    def test_files_of_components(self):
        """The second file is on the plane of the first; components that do not say that they are eastward are so."""
        file = self.file(OMEGA)
        for name in "u", "v":
            del file[name][2]["standard_name"]
            part = {key: file[key] for key in ("lon", "lat", "height", name)}
            earth_flows.write(self.folder / f"{name}.nc", part)
        path, = self.imports("u.nc", "v.nc", "-o", "v.vdb")
        self.assert_rotates(path, OMEGA)

    def test_small_regions_keep_their_voxels(self):
        file = wind(numpy.arange(10, 12, 0.1), numpy.arange(60, 60.5, 0.1), heights=numpy.zeros(1))
        earth_flows.write(self.folder / "f.nc", file)
        done = self.run_tool("vdblic_import", "f.nc", "-o", "v.vdb")
        self.assertIn("20 x 5 x 1 voxels", done.stderr)
        self.assertNotIn("projection", done.stderr)
        values, active, _ = velocity_of(self.folder / "v.vdb")
        numpy.testing.assert_array_equal(values[active][:, 0].reshape(20, 5).T, file["u"][1][0].astype("f4"))


class Nemo(ImportHere):
    """A file for each component along a turned grid, which says so in a long name; land has the flow 0."""

    def parts(self, land=0.0):
        file = earth_flows.turned()
        for name, axis in ("u", "x"), ("v", "y"):
            file[name][1] = numpy.array(file[name][1])
            file[name][1][..., :3] = land
            file[name][2] = {"Unit": "m/s", "long_name": f"sea_water_{axis}_velocity", "coordinates": "nav_lon nav_lat"}
            part = {key: file[key] for key in ("nav_lon", "nav_lat", "depth", "time", name)}
            earth_flows.write(self.folder / f"{name}.nc", part)

    def test_long_names(self):
        self.parts(land=numpy.nan)
        path, = self.imports("u.nc", "v.nc", "-o", "v.vdb")
        values, active, _ = velocity_of(path)
        numpy.testing.assert_allclose(values[active].mean(axis=0), (0.5, 0, 0), atol=2e-3)

    def test_land_that_has_the_flow_0(self):
        self.parts()
        done = self.run_tool("vdblic_import", "u.nc", "v.nc", "-o", "v.vdb")
        self.assertIn("38 % of 'u' are exactly 0; if that is land: --attribute 'u:missing_value=0'", done.stderr)
        self.assertLess(velocity_of(self.folder / "v.vdb")[0][..., 0].mean(), 0.4)
        answers = "--attribute", "u:missing_value=0", "v:missing_value=0"
        path, = self.imports("u.nc", "v.nc", "-o", "v.vdb", *answers)
        values, active, _ = velocity_of(path)
        numpy.testing.assert_allclose(values[active].mean(axis=0), (0.5, 0, 0), atol=2e-3)
        message = self.fails(3, "vdblic_import", "u.nc", "v.nc", "-o", "w.vdb", "--attribute", "u:missing_value=land")
        self.assertIn("u.nc: the missing_value 'land' of 'u' is no number", message)

    def test_land_without_coordinates(self):
        """It is at 0 degrees east and north."""
        for extra in (), ("--globe", "--voxel-size", 0.005):
            self.parts(land=numpy.nan)
            _, whole, there = velocity_of(self.imports("u.nc", "v.nc", "-o", "v.vdb", *extra)[0])
            file = earth_flows.turned()
            for name in "u", "v":
                part = {key: file[key] for key in ("nav_lon", "nav_lat", "depth", "time", name)}
                for place in "nav_lon", "nav_lat":
                    part[place][1][:, :3] = 0
                earth_flows.write(self.folder / f"{name}.nc", part)
            done = self.run_tool("vdblic_import", "u.nc", "v.nc", "-o", "v.vdb", *extra)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("18 points at 0 degrees east and north are left out", done.stderr)
            values, active, at = velocity_of(self.folder / "v.vdb")
            self.assertGreater(active.sum(), 0.5 * whole.sum())
            self.assertLess(numpy.ptp(at[..., 0]), 2 * numpy.ptp(there[..., 0]))  # no box that reaches to the equator
            speed = velocity_of(self.folder / "v.vdb", "speed")[0] if extra else numpy.linalg.norm(values, axis=-1)
            self.assertAlmostEqual(speed[active].mean(), 0.5, delta=0.01)

    def test_without_standard_names_and_words(self):
        """Nothing tells whether components of two files are along the grid."""
        self.parts()
        message = self.fails(3, "vdblic_import", "u.nc", "v.nc", "-o", "w.vdb", "--attribute", "u:long_name=a", "v:long_name=b")
        self.assertIn("is 'u' along the grid, which is turned by up to 40", message)

    def test_levels_without_coordinates(self):
        file = earth_flows.sea()
        del file["depth"]
        earth_flows.write(self.folder / "f.nc", file)
        self.assertIn("the vertical axis 'depth' has no coordinates; add them", self.fails(3, "vdblic_import", "f.nc", "-o", "w.vdb"))


if __name__ == "__main__":
    unittest.main()
