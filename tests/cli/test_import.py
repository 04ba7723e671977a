"""vdblic_import: known flows in the files of other programs become the same flows in velocity volumes."""

import unittest

import netCDF4
import numpy
import pyopenvdb as vdb

import flows
import netcdf_flows
from imports import TIMES, ImportTest, velocity_of


class VtkFiles(ImportTest):
    def test_every_format(self):
        for ending, make, voxels in (("vti", flows.image, (9, 7, 5)), ("vtr", flows.rectilinear, (9, 7, 5)),
                                     ("vts", flows.structured, None), ("vtu", flows.tetrahedra, (15, 11, 7)),
                                     ("vtm", flows.blocks, None), ("vtk", flows.structured, None)):
            with self.subTest(ending):
                for frame, time in enumerate(TIMES, 3):
                    flows.write_vtk(make(time), self.folder / f"{ending}_{frame:03}.{ending}")
                paths = self.imports(f"{ending}_%03d.{ending}", "-o", f"{ending}.%04d.vdb", "--carry", "p", "-q")
                self.assertEqual([path.name for path in paths], [f"{ending}.{frame:04}.vdb" for frame in (3, 4, 5)])
                for frame, (time, path) in enumerate(zip(TIMES, paths), 3):
                    active = self.assert_flow(path, lambda at, time=time: flows.flow(at, time), voxels)
                    self.assertGreater(active.sum(), 150)
                    found = vdb.readMetadata(str(path))
                    self.assertEqual((found["frame"], found["time"], found["velocity_unit"]), (frame, time, "world/s"))
                values, _, positions = velocity_of(paths[0], "p")
                numpy.testing.assert_allclose(values[active], flows.pressure(positions)[active], rtol=1e-5)
        self.assert_advects("vts.%04d.vdb")

    def test_cells_of_an_image_keep_their_values(self):
        flows.write_vtk(flows.image(1.0, cells=True), self.folder / "v.vti")
        path, = self.imports("v.vti", "-o", "v.vdb")
        self.assert_flow(path, lambda at: flows.flow(at, 1.0), (8, 6, 4), 1e-7)

    def test_a_list_of_files(self):
        flows.write_pvd(self.folder, TIMES)
        paths = self.imports("flow.pvd", "-o", "v.%04d.vdb", "--times", 0.4, 9)
        self.assertEqual([path.name for path in paths], ["v.0002.vdb", "v.0003.vdb"])
        for time, path in zip(TIMES[1:], paths):
            self.assert_flow(path, lambda at, time=time: flows.flow(at, time))
            self.assertEqual(vdb.readMetadata(str(path))["dt"], 0.5 if time == 0 else 0.75)

    def test_hidden_points_and_values_that_are_no_numbers_are_inactive(self):
        image = flows.image()
        ghosts = numpy.zeros((5, 7, 9), numpy.uint8)
        ghosts[0, 0] = 2  # hidden
        flows.add(image.GetPointData(), "vtkGhostType", ghosts)
        velocity = flows.flow(flows.grid_positions(*flows.axes()))
        velocity[2, 3, 4] = numpy.nan
        image.GetPointData().RemoveArray("U")
        flows.add(image.GetPointData(), "U", velocity)
        flows.write_vtk(image, self.folder / "v.vti")
        path, = self.imports("v.vti", "-o", "v.vdb")
        active = self.assert_flow(path, flows.flow)
        expected = numpy.ones((9, 7, 5), bool)
        expected[:, 0, 0] = expected[4, 3, 2] = False
        numpy.testing.assert_array_equal(active, expected)

    def test_other_voxels(self):
        flows.write_vtk(flows.tetrahedra(), self.folder / "v.vtu")
        first = self.imports("v.vtu", "-o", "size.vdb", "--size", 10, 8, 4)[0]
        self.assert_flow(first, flows.flow, (10, 8, 4))
        numpy.testing.assert_allclose(
    vdb.read(
        str(first), "velocity").transform.indexToWorld(
            (0, 0, 0)), (1.1, -0.875, 0.125))
        path, = self.imports("v.vtu", "-o", "voxel.vdb", "--voxel-size", 0.1, 0.2, 0.25)
        self.assert_flow(path, flows.flow, (20, 10, 4))
        # A box that reaches beyond the flow: what is outside stays inactive.
        path, = self.imports("v.vtu", "-o", "box.vdb", "--voxel-size", 0.1, "--bounds", 2, -2, 0, 4, 0, 1)
        self.assert_flow(path, flows.flow, (10, 10, 10))
        path, = self.imports("v.vtu", "-o", "like.vdb", "--like", "size.vdb:velocity")
        numpy.testing.assert_allclose(velocity_of(path)[0], velocity_of(first)[0], atol=1e-6)
        turned = vdb.FloatGrid()
        turned.fill((-2, 1, 0), (5, 6, 3), 1)
        turned.transform = vdb.createLinearTransform(
            [[0.1, 0.05, 0, 0], [-0.05, 0.1, 0, 0], [0, 0, 0.2, 0], [2, -0.3, 0.1, 1]])
        turned.name = "turned"
        vdb.write(str(self.folder / "turned.vdb"), turned)
        path, = self.imports("v.vtu", "-o", "out.vdb", "--like", "turned.vdb")
        grid = vdb.read(str(path), "velocity")
        self.assertEqual(grid.evalActiveVoxelBoundingBox(), ((-2, 1, 0), (5, 6, 3)))
        expected = flows.flow(numpy.array(turned.transform.indexToWorld((4, 3, 2))))
        numpy.testing.assert_allclose(grid.getConstAccessor().getValue((4, 3, 2)), expected, rtol=1e-5)

    def test_voxels_on_the_rim_are_inside(self):
        """Their centres are corners of the cells, but for rounding."""
        x, y, z = (axis / 3 for axis in flows.axes())
        for ending, grid in ("vtr", flows.rectilinear(axes=(x, y, z))), ("vts", flows.structured(axes=(x, y, z), rise=0)):
            flows.write_vtk(grid, self.folder / f"v.{ending}")
            for first in -60, 0, 7:
                like = vdb.FloatGrid()
                like.fill((first, first, first), (first + 8, first + 6, first + 4), 1)
                matrix = numpy.diag([*(axis[1] - axis[0] for axis in (x, y, z)), 1])
                matrix[3, :3] = [axis[0] - first * (axis[1] - axis[0]) for axis in (x, y, z)]
                like.transform = vdb.createLinearTransform(matrix.tolist())
                like.name = "like"
                vdb.write(str(self.folder / "like.vdb"), like)
                path, = self.imports(f"v.{ending}", "-o", "v.vdb", "--like", "like.vdb")
                self.assertEqual(vdb.read(str(path), "velocity").activeVoxelCount(), 9 * 7 * 5, (ending, first))

    def test_choice_of_arrays(self):
        image = flows.image()
        for i, name in enumerate("ab"):
            flows.add(image.GetPointData(), name, flows.flow(flows.grid_positions(*flows.axes()))[..., i])
        image.GetPointData().RemoveArray("U")
        flows.write_vtk(image, self.folder / "v.vti")
        self.assertIn("a, b, p", self.refuses(3, "v.vti", "-o", "v.vdb"))
        self.assertIn("has 1 components", self.refuses(3, "v.vti", "-o", "v.vdb", "--array", "a"))
        self.assertIn("no array 'c'", self.refuses(3, "v.vti", "-o", "v.vdb", "--array", "a,b,c"))
        path, = self.imports("v.vti", "-o", "v.vdb", "--array", "a,b,p")
        self.assert_flow(path, lambda at: numpy.concatenate(
            [flows.flow(at)[..., :2], flows.pressure(at)[..., None]], axis=-1))


class Cases(ImportTest):
    def test_openfoam(self):
        for name, pieces, argument in ("whole", 1, "whole"), ("pieces", 3, "pieces/pieces.foam"):
            flows.write_foam(self.folder / name, TIMES, pieces)
            (self.folder / name / f"{name}.foam").touch()
            paths = self.imports(argument, "-o", f"{name}.%04d.vdb", "--size", 8, 6, 4)
            self.assertEqual([vdb.readMetadata(str(path))["time"] for path in paths], TIMES)
            for time, path in zip(TIMES, paths):  # the voxels are the cells, whose values they keep
                self.assert_flow(path, lambda at, time=time: flows.flow(at, time), (8, 6, 4))
        self.assert_advects("pieces.%04d.vdb")

    def test_a_case_that_lacks_something(self):
        self.assertIn("no such file", self.refuses(3, "nothing", "-o", "v.%04d.vdb"))
        (self.folder / "empty").mkdir()
        self.assertIn("not an OpenFOAM case", self.refuses(3, "empty", "-o", "v.%04d.vdb"))
        flows.write_foam(self.folder / "case", [0.0])
        (self.folder / "case/constant/polyMesh/faces").unlink()
        self.assertIn("case: ", self.refuses(3, "case", "-o", "v.%04d.vdb"))

    def test_ensight(self):
        flows.write_ensight(self.folder, TIMES)
        paths = self.imports("flow.case", "-o", "v.%04d.vdb")
        for time, path in zip(TIMES, paths, strict=True):
            self.assert_flow(path, lambda at, time=time: flows.flow(at, time), (9, 7, 5))
            self.assertEqual(vdb.readMetadata(str(path))["time"], time)


class NetCdf(ImportTest):
    def test_pressure_levels(self):
        hours = [6, 7, 9]
        netcdf_flows.write_pressure_levels(self.folder / "winds.nc", hours)
        paths = self.imports("winds.nc", "-o", "v.%04d.vdb", "--carry", "t")
        for hour, path in zip(hours, paths, strict=True):
            active = self.assert_flow(path, lambda at, hour=hour: netcdf_flows.wind(at, 0.1 * hour))
            self.assertGreater(active.sum(), 200)
            found = vdb.readMetadata(str(path))
            self.assertEqual((found["time"], found["start"], found["length_unit"]),
                             (3600 * (hour - 6), "2000-01-01T00:00:00", "m"))
        self.assertAlmostEqual(velocity_of(paths[0], "t")[0][active].max(), 250, 3)
        self.assert_advects("v.%04d.vdb")
        # A part of the sequence counts from the same time.
        path, = self.imports("winds.nc", "-o", "part.%04d.vdb", "--frames", 3)
        self.assertEqual(vdb.readMetadata(str(path))["time"], 3 * 3600)

    def test_without_vertical_velocity_and_geopotential(self):
        netcdf_flows.write_pressure_levels(self.folder / "winds.nc", [6], omega=False)
        done = self.run_tool("vdblic_import", "winds.nc", "-o", "v.vdb")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("the vertical velocity is 0", done.stderr)
        self.assertEqual(abs(velocity_of(self.folder / "v.vdb")[0][..., 2]).max(), 0)

    def test_heights_with_terrain(self):
        netcdf_flows.write_heights(self.folder / "h.nc", terrain=True)
        expected = netcdf_flows.write_heights(self.folder / "h.nc")
        path, = self.imports("h.nc", "-o", "v.vdb")
        active = self.assert_flow(path, netcdf_flows.wind)
        low = vdb.read(str(path), "velocity").evalActiveVoxelBoundingBox()[0]
        numpy.testing.assert_array_equal(active, expected[low[0]:, low[1]:, low[2]:])
        self.assertFalse(active.all())

    def test_wrf(self):
        dates = ["2005-08-28_00:00:00", "2005-08-28_03:00:00"]
        for date in dates:
            netcdf_flows.write_wrf(self.folder / f"wrfout_d01_{date}", [date])
        names = "".join(f"wrfout_d01_{date}\n" for date in dates)
        paths = self.imports("-", "-o", "v.%04d.vdb", "--renumber", 1, "--carry", "QVAPOR", stdin=names)
        for time, path in zip((0, 10800), paths, strict=True):
            active = self.assert_flow(path, netcdf_flows.wind)
            self.assertEqual(vdb.readMetadata(str(path))["time"], time)
        self.assertAlmostEqual(velocity_of(path, "QVAPOR")[0][active].max(), 0.01, 6)
        ground = 100 + numpy.arange(8) * 3000 / 50 + 400  # of the lowest level
        heights = 500 + numpy.arange(5) * 905
        inside = (heights >= ground[:, None] - 1e-6) & (heights <= ground[:, None] + 3200 + 1e-6)
        numpy.testing.assert_array_equal(active, numpy.broadcast_to(inside[:, None, :], active.shape))

    def test_levels_that_follow_the_sea_floor(self):
        netcdf_flows.write_ocean(self.folder / "sea.nc", [0, 1800], angle=0.4)
        paths = self.imports("sea.nc", "-o", "v.%04d.vdb", "--size", 20, 20, 20)
        for time, path in zip((0, 1800), paths, strict=True):
            values, active, positions = velocity_of(path)
            # Away from the coast and the rims, where faces have no neighbours, means of faces are exact in x and y.
            inner = active & (positions[..., 0] > -10000) & (abs(positions[..., 0])
                              < 14000) & (abs(positions[..., 1]) < 14000)
            expected = netcdf_flows.wind(positions, time / 3600)
            numpy.testing.assert_allclose(values[inner], expected[inner], atol=4e-3)
            self.assertGreater(inner.sum(), 500)
            self.assertFalse(active[positions[..., 0] < -16000].any(), "land")
            self.assertEqual(vdb.readMetadata(str(path))["time"], time)

    def test_packed_values_at_random_places(self):
        """Against netCDF4's own reading: packed numbers, an axis that falls, missing values."""
        random = numpy.random.default_rng(5)
        data = netcdf_flows.create(self.folder / "packed.nc", time=2, z=6, y=7, x=8)
        for name, values in ("z", numpy.arange(6)), ("y", -numpy.arange(7)), ("x", numpy.arange(8)):
            netcdf_flows.put(data, name, (name,), 100.0 * values, units="m")
        netcdf_flows.put(data, "time", ("time",), [0, 1], units="hours since 2020-02-29")
        for name in "uvw":
            variable = data.createVariable(name, "i2", ("time", "z", "y", "x"), fill_value=-32767)
            variable.setncatts({"scale_factor": 0.002, "add_offset": 10.0, "units": "m s-1"})
            values = random.uniform(-40, 60, (2, 6, 7, 8))
            variable[:] = numpy.ma.masked_where(random.random(values.shape) < 0.1, values)
        data.close()
        paths = self.imports("packed.nc", "-o", "v.%04d.vdb")
        with netCDF4.Dataset(self.folder / "packed.nc") as data:
            for step, path in enumerate(paths):
                grid = vdb.read(str(path), "velocity")
                for _ in range(100):
                    i, j, k = (int(random.integers(n)) for n in (8, 7, 6))
                    expected = [data[name][step, k, j, i] for name in "uvw"]
                    voxel = tuple(map(round, grid.transform.worldToIndex((100.0 * i, -100.0 * j, 100.0 * k))))
                    valid = not any(value is numpy.ma.masked for value in expected)
                    self.assertEqual(grid.getConstAccessor().isValueOn(voxel), valid)
                    if valid:
                        numpy.testing.assert_allclose(grid.getConstAccessor().getValue(voxel), expected, rtol=1e-6)

    def test_files_that_lack_something(self):
        data = netcdf_flows.create(self.folder / "flat.nc", y=3, x=4)
        netcdf_flows.put(data, "u", ("y", "x"), numpy.zeros((3, 4)))
        data.close()
        self.assertIn("no array is known as a velocity", self.refuses(3, "flat.nc", "-o", "v.vdb"))
        data = netcdf_flows.create(self.folder / "level.nc", lev=3, y=3, x=4)
        for name, size in ("lev", 3), ("y", 3), ("x", 4):
            netcdf_flows.put(data, name, (name,), numpy.arange(size), units="1" if name == "lev" else "m")
        for name in "uvw":
            netcdf_flows.put(data, name, ("lev", "y", "x"), numpy.ones((3, 3, 4)))
        data.close()
        self.assertIn("geopotential_height", self.refuses(3, "level.nc", "-o", "v.vdb"))


class Arrays(ImportTest):
    def test_numpy(self):
        x, y, z = numpy.meshgrid(*(numpy.arange(n) for n in (6, 5, 4)), indexing="ij")
        positions = numpy.stack([x, y, z], axis=-1) * (0.5, 0.5, 1) + (1, 2, 3)
        active = x + y > 2
        velocity = [flows.flow(positions, time) for time in TIMES]
        numpy.savez(self.folder / "v.npz", velocity=velocity, active=active, time=TIMES,
                    voxel_size=(0.5, 0.5, 1), origin=(1, 2, 3))
        paths = self.imports("v.npz", "-o", "v.%04d.vdb")
        for time, path in zip(TIMES, paths, strict=True):
            numpy.testing.assert_array_equal(self.assert_flow(path, lambda at, time=time: flows.flow(at, time)), active)
        numpy.save(self.folder / "plain.npy", flows.flow(numpy.stack([x, y, z], axis=-1)))
        path, = self.imports("plain.npy", "--layout", "xyzc", "-o", "plain.vdb")
        self.assert_flow(path, flows.flow, (6, 5, 4))
        numpy.savez(self.folder / "bad.npz", velocity=numpy.zeros((3, 3, 3, 3)), p=numpy.zeros((4, 4, 4)))
        self.assertIn("different shapes", self.refuses(3, "bad.npz", "-o", "v.vdb", "--layout", "xyzc"))


class Rules(ImportTest):
    def setUp(self):
        super().setUp()
        for frame in 1, 2, 3:
            numpy.savez(self.folder / f"f.{frame:04}.npz", velocity=numpy.full((8, 8, 8, 3), frame, numpy.float32), voxel_size=1)

    def test_sequences(self):
        first = self.imports("f.%04d.npz", "-o", "v.####.vdb", "--dt", 0.5, "--frames", "2-3")
        self.assertEqual([path.name for path in first], ["v.0002.vdb", "v.0003.vdb"])
        self.assertEqual([vdb.readMetadata(str(path))["time"] for path in first], [0.5, 1])
        before = self.contents("v.0002.vdb")
        mine = self.contents("v.0002.vdb")
        (self.folder / "v.0003.vdb").write_bytes(mine)
        self.imports("f.%04d.npz", "-o", "v.%04d.vdb", "--dt", 0.5, "--skip-existing")
        self.assertEqual(self.contents("v.0003.vdb"), mine)
        self.imports("f.%04d.npz", "-o", "v.%04d.vdb", "--dt", 0.5)
        self.assertEqual(self.contents("v.0002.vdb"), before, "equal inputs give equal bytes")
        done = self.run_tool("vdblic_import", "-", "-o", "p.%04d.vdb", stdin="f.0002.npz\nf.0003.npz\n")
        self.assertEqual(done.stdout.split(), ["p.0002.vdb", "p.0003.vdb"])
        self.assertIn("frame 3: ", done.stderr)

    def test_help_names_the_inputs(self):
        for tool in "import", "export":
            help_text = self.run_tool(f"vdblic_{tool}", "--help").stdout
            self.assertRegex(help_text, rf"(?m)^Usage: vdblic_{tool} \[OPTIONS\] INPUT")
            self.assertRegex(help_text, r"(?m)^Positionals:\n  INPUT TEXT REQUIRED ")

    def test_mistakes(self):
        (self.folder / "f.0005.npz").write_bytes(b"")
        (self.folder / "g.1.npz").touch()
        for status, words, *arguments in (
                (3, "frame 4 is missing", "f.%04d.npz", "-o", "v.%04d.vdb"),
                (3, "frame 7 is missing", "f.%04d.npz", "-o", "v.%04d.vdb", "--frames", 7),
                (3, "f.%04d.npz", "f.%02d.npz", "-o", "v.%04d.vdb"),
                (3, "the files on disk match g.%d.npz", "g.%04d.npz", "-o", "v.%04d.vdb"),
                (3, "no such file", "-", "-o", "v.%04d.vdb"),
                (3, "the file is empty", "f.0005.npz", "-o", "v.vdb"),
                (3, "cannot be read", "f.%04d.npz", "-o", "v.%04d.vdb", "--frames", "1", "--like", "f.0001.npz"),
                (2, "is no frame field; write f.%04d.npz", "f.*.npz", "-o", "v.vdb"),
                (2, "names one file", "f.%04d.npz", "-o", "v.vdb", "--frames", "1-3"),
                (2, "must end in .vdb", "f.0001.npz", "-o", "v.vti"),
                (2, "--frames needs a pattern", "f.0001.npz", "-o", "v.vdb", "--frames", 1),
                (2, "leave out --size", "f.0001.npz", "-o", "v.vdb", "--like", "f.0001.npz", "--size", 1, 1, 1),
                (2, "of memory", "f.0001.npz", "-o", "v.vdb", "--size", 131072, 131072, 131072),
                (2, "empty box", "f.0001.npz", "-o", "v.vdb", "--bounds", 0, 0, 0, 1, 1, 0),
                (2, "there is no option --siz; --size is one", "f.0001.npz", "-o", "v.vdb", "--siz", 1)):
            with self.subTest(words):
                self.assertIn(words, self.refuses(status, *arguments, stdin="missing.0001.npz\n"))

    def test_files_that_are_broken(self):
        flows.write_vtk(flows.image(), self.folder / "whole.vti")
        flows.write_vtk(flows.image(), self.folder / "whole.vtk")
        for ending in "vti", "vtk", "pvd", "case", "cgns", "nc", "npz":
            (self.folder / f"garbage.{ending}").write_bytes(b"garbage")
            self.assertIn(f"garbage.{ending}: ", self.refuses(3, f"garbage.{ending}", "-o", "v.vdb"))
        for ending in "vti", "vtk":
            (self.folder / f"half.{ending}").write_bytes(self.contents(f"whole.{ending}")[:900])
            self.assertIn(f"half.{ending}: ", self.refuses(3, f"half.{ending}", "-o", "v.vdb"))


if __name__ == "__main__":
    unittest.main()
