"""vdblic_import: forms of files beside NetCDF, and what arrays and VTK's files leave open."""

import importlib.util
import json
import unittest

import numpy
import pyopenvdb as vdb
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkStructuredGrid
from vtkmodules.vtkFiltersCore import vtkAppendFilter

import earth_flows
import flows
from imports import TIMES, ImportHere, velocity_of

SIZE = 6, 5, 4


def has(*modules):
    return all(importlib.util.find_spec(module) for module in modules)


def sample(time=0.0):
    """A flow on (x, y, z, 3) at whole numbers."""
    x, y, z = numpy.meshgrid(*(numpy.arange(n) for n in SIZE), indexing="ij")
    return flows.flow(numpy.stack([x, y, z], axis=-1), time)


class Arrays(ImportHere):
    def test_layouts(self):
        one, steps = sample(), numpy.stack([sample(time) for time in TIMES])
        for layout, values in (
                ("cxyz", one.transpose(3, 0, 1, 2)), ("czyx", one.transpose(3, 2, 1, 0)), ("xyzc", one),
                ("tczyx", steps.transpose(0, 4, 3, 2, 1)), ("xyztc", steps.transpose(1, 2, 3, 0, 4))):
            with self.subTest(layout):
                numpy.savez(self.folder / "a.npz", velocity=values, **{"time": TIMES} if "t" in layout else {})
                paths = self.imports("a.npz", "-o", "v.%04d.vdb", "--layout", layout)
                self.assert_flow(paths[0], flows.flow, SIZE)
                self.assert_flow(paths[-1], lambda at: flows.flow(at, TIMES[-1 if "t" in layout else 0]), SIZE)
        numpy.save(self.folder / "a.npy", one.transpose(3, 0, 1, 2))
        self.assertIn("a.npy: nothing tells the order of the axes of 'velocity' (3, 6, 5, 4); say it: --layout cxyz",
                      self.refuses(3, "a.npy", "-o", "w.vdb"))
        for values in one, steps[..., 0, :], one[..., 0]:  # (x, y, z, c) or (t, x, y, c), (x, y, z) or (z, y, x)
            self.assertIn("nothing tells the order of the axes", self.refuses(3, self.save(values), "-o", "w.vdb"))
        self.assertEqual(len(self.imports(self.save(steps[..., 0, :]), "-o", "w.%04d.vdb", "--layout", "txyc")), len(TIMES))
        self.assertIn("--layout is letters of t, c, x, y and z", self.refuses(2, "a.npy", "-o", "w.vdb", "--layout", "xxyz"))
        self.assertIn("the axes of 'velocity' (6, 5, 4, 3) are x, y, z, components; --layout tells others",
                      self.run_tool("vdblic_import", self.npz(one), "-o", "u.vdb").stderr)

    def save(self, values):
        numpy.save(self.folder / "b.npy", values)
        return "b.npy"

    def npz(self, values):
        numpy.savez(self.folder / "c.npz", velocity=values, origin=0)
        return "c.npz"

    def test_planes(self):
        numpy.save(self.folder / "a.npy", sample()[:, :, 0, :2])
        path, = self.imports("a.npy", "-o", "v.vdb", "--layout", "xyc")
        self.assert_flow(path, lambda at: flows.flow(at) * (1, 1, 0), (*SIZE[:2], 1))

    def test_types_dates_and_axes(self):
        days = numpy.array(["2020-01-31", "2020-02-01", "2020-03-01"], "datetime64[D]")
        half = numpy.stack([sample()] * 3).astype("f2")
        numpy.savez(self.folder / "a.npz", velocity=half, time=days)
        paths = self.imports("a.npz", "-o", "v.%04d.vdb", "--layout", "txyzc")
        self.assert_flow(paths[0], lambda at: flows.flow(at).astype("f2"), SIZE)
        found = [vdb.readMetadata(str(path)) for path in paths]
        self.assertEqual([data["time"] for data in found], [0, 86400, 30 * 86400])
        self.assertEqual(found[0]["start"], "2020-01-31T00:00:00")
        axes = [2 + 0.5 * numpy.arange(6), -numpy.arange(5.0), numpy.arange(4) * 10.0]
        at = numpy.stack(numpy.meshgrid(*axes, indexing="ij"), axis=-1)
        numpy.savez(self.folder / "a.npz", velocity=flows.flow(at), **dict(zip("xyz", axes)))
        path, = self.imports("a.npz", "-o", "w.vdb")
        self.assert_flow(path, flows.flow, SIZE)
        numpy.savez(self.folder / "a.npz", velocity=sample() * 1j)
        self.assertIn("'velocity' has complex numbers", self.refuses(3, "a.npz", "-o", "z.vdb"))

    @unittest.skipUnless(has("h5py"), "python3-h5py is not installed")
    def test_hdf5(self):
        import h5py  # pylint: disable=import-outside-toplevel

        for ending in "h5", "mat":
            with h5py.File(self.folder / f"a.{ending}", "w", userblock_size=512 if ending == "mat" else 0) as file:
                for i, name in enumerate("uvw"):
                    file[f"flow/{name}"] = numpy.stack([sample(time)[..., i].T for time in TIMES])
                file["time"] = TIMES
            self.assertIn("nothing tells the order of the axes", self.refuses(3, f"a.{ending}", "-o", "v.%04d.vdb"))
            paths = self.imports(f"a.{ending}", "-o", "v.%04d.vdb", "--layout", "tzyx", "--array", "flow/u,flow/v,flow/w")
            for time, path in zip(TIMES, paths, strict=True):
                self.assert_flow(path, lambda at, time=time: flows.flow(at, time), SIZE)
                path.unlink()
        (self.folder / "old.mat").write_bytes(b"MATLAB 5.0 MAT-file" + b" " * 600)
        self.assertIn("it is of MATLAB before version 7.3", self.refuses(3, "old.mat", "-o", "v.%04d.vdb"))


class Earth(ImportHere):
    def assert_sea(self, path, middle=(10.875, 40.5)):
        values, active, positions = velocity_of(path)
        at = earth_flows.on_earth(positions, middle)
        self.assertTrue(active.all())
        for slot, flow in enumerate((earth_flows.east, earth_flows.north)):
            numpy.testing.assert_allclose(values[..., slot], flow(*at), atol=2e-4)

    @unittest.skipUnless(has("zarr"), "python3-zarr is not installed")
    def test_zarr(self):
        import xarray  # pylint: disable=import-outside-toplevel

        file = earth_flows.sea()
        xarray.Dataset({name: tuple(value) for name, value in file.items()}).to_zarr(self.folder / "a.zarr")
        path, = self.imports("a.zarr", "-o", "v.%04d.vdb")
        self.assert_sea(path)
        self.assertEqual(vdb.readMetadata(str(path))["start"], "2020-02-29T06:00:00")

    @unittest.skipUnless(has("cfgrib", "eccodes"), "python3-cfgrib is not installed")
    def test_grib(self):
        """Rows from north to south, pressure levels, two times; u and v of several levels in any order."""
        import eccodes  # pylint: disable=import-outside-toplevel

        latitude, longitude = 45 - 0.5 * numpy.arange(6), 10 + 0.5 * numpy.arange(8)
        with open(self.folder / "a.grib", "wb") as file:
            for hour in 0, 6:
                for level in 500, 850, 1000:
                    for number, flow in (131, earth_flows.east), (132, earth_flows.north):
                        message = eccodes.codes_grib_new_from_samples("regular_ll_pl_grib1")
                        for key, value in {
                                "Ni": 8, "Nj": 6, "latitudeOfFirstGridPointInDegrees": 45, "longitudeOfFirstGridPointInDegrees": 10,
                                "latitudeOfLastGridPointInDegrees": 42.5, "longitudeOfLastGridPointInDegrees": 13.5,
                                "iDirectionIncrementInDegrees": 0.5, "jDirectionIncrementInDegrees": 0.5, "level": level,
                                "dataDate": 20200229, "dataTime": 100 * hour, "indicatorOfParameter": number,
                                "bitsPerValue": 24}.items():
                            eccodes.codes_set(message, key, value)
                        values = flow(longitude[None, :], latitude[:, None], level / 1000)
                        eccodes.codes_set_values(message, numpy.ravel(values))
                        eccodes.codes_write(message, file)
                        eccodes.codes_release(message)
        paths = self.imports("a.grib", "-o", "v.%04d.vdb", "--size", 8, 6, 1)
        self.assertEqual([vdb.readMetadata(str(path))["time"] for path in paths], [0, 21600])
        self.assertEqual(vdb.readMetadata(str(paths[0]))["start"], "2020-02-29T00:00:00")
        path, = self.imports("a.grib", "-o", "w.%04d.vdb", "--frames", 1)
        values, active, positions = velocity_of(path)
        for at, level in (positions[..., 0, 2].mean(), 1000), (positions[..., -1, 2].mean(), 500):
            height = 110.9 if level == 1000 else 5574.4  # of the standard atmosphere
            self.assertAlmostEqual(at, height, delta=1)
        place = earth_flows.on_earth(positions, (11.75, 43.75))
        self.assertTrue(active[..., 0].all())
        numpy.testing.assert_allclose(values[..., 0, 0], earth_flows.east(place[0], place[1], 1.0)[..., 0], atol=1e-3)

    @unittest.skipUnless(has("cfgrib", "eccodes"), "python3-cfgrib is not installed")
    def test_grib_without_rows_and_columns(self):
        import eccodes  # pylint: disable=import-outside-toplevel

        for sample, words in (("reduced_gg_pl_32_grib2", "a reduced Gaussian grid, whose rows differ in length; make a regular "
                               "one of it: cdo setgridtype,regular"), ("sh_pl_grib2", "spherical harmonics; make")):
            message = eccodes.codes_grib_new_from_samples(sample)
            with open(self.folder / "a.grib", "wb") as file:
                eccodes.codes_write(message, file)
            self.assertIn(words, self.refuses(3, "a.grib", "-o", "v.%04d.vdb"))

    def test_a_mesh_in_a_file_of_its_own(self):
        file = earth_flows.fvcom()[0]
        mesh = {name: file[name] for name in ("lon", "lat", "nv", "h", "siglay", "siglev")}
        earth_flows.write(self.folder / "whole.nc", file)
        earth_flows.write(self.folder / "mesh.nc", mesh)
        earth_flows.write(self.folder / "flow.nc", {name: file[name] for name in ("u", "v", "zeta", "time")})
        whole, = self.imports("whole.nc", "-o", "a.%04d.vdb")
        parts, = self.imports("flow.nc", "mesh.nc", "-o", "b.%04d.vdb")
        numpy.testing.assert_allclose(velocity_of(whole)[0], velocity_of(parts)[0], atol=1e-3)
        self.assertIn("name the file of the mesh, too: vdblic_import flow.nc MESH.nc",
                      self.refuses(3, "flow.nc", "-o", "c.%04d.vdb"))


class Vtk(ImportHere):
    def test_scalars_and_vectors_one_after_the_other(self):
        head = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 8\n"
        scalars = "".join(f"SCALARS {name} float 1\nLOOKUP_TABLE default\n{' '.join([str(i)] * 8)}\n" for i, name in enumerate("uvw", 1))
        vectors = "".join(f"VECTORS {name} float\n{' '.join(['1 2 3'] * 8)}\n".replace("1 2 3", value)
                          for name, value in (("magnetic", "9 9 9"), ("velocity", "1 2 3")))
        for body in scalars, vectors:
            (self.folder / "a.vtk").write_text(head + body, encoding="ascii")
            path, = self.imports("a.vtk", "-o", "v.vdb")
            numpy.testing.assert_array_equal(velocity_of(path)[0][1, 1, 1], (1, 2, 3))

    def test_lists_of_files(self):
        for i, time in enumerate(TIMES):
            flows.write_vtk(flows.image(time), self.folder / f"a{i}.vti")
        entries = lambda times: "".join(f'<DataSet {time} part="0" file="a{i}.vti"/>' for i, time in enumerate(times))
        for name, times, expected in (
                ("untimed.pvd", ["", "", ""], [None] * 3), ("twice.pvd", ['timestep="0"', 'timestep="2"', 'timestep="2"'], [0, 2])):
            text = f'<VTKFile type="Collection"><Collection>{entries(times)}</Collection></VTKFile>'
            (self.folder / name).write_text(text, encoding="ascii")
            paths = self.imports(name, "-o", f"{name}.%04d.vdb")
            self.assertEqual([vdb.readMetadata(str(path)).get("time") for path in paths], expected)
            self.assert_flow(paths[-1], lambda at: flows.flow(at, TIMES[-1]))
        listed = {"files": [{"name": f"a{i}.vti", "time": time} for i, time in enumerate(TIMES)]}
        (self.folder / "a.vti.series").write_text(json.dumps(listed), encoding="ascii")
        paths = self.imports("a.vti.series", "-o", "s.%04d.vdb")
        self.assertEqual([vdb.readMetadata(str(path))["time"] for path in paths], TIMES)

    def npz(self, values):
        numpy.savez(self.folder / "c.npz", velocity=values, origin=0)
        return "c.npz"

    def test_planes(self):
        """A plane is a layer of voxels: of an image whose spacing across it is 0, of quadrilaterals, structured or not."""
        head = "# vtk DataFile Version 2.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 1 2\nORIGIN 0 0 0\nSPACING 2 0 3\n"
        (self.folder / "a.vtk").write_text(f"{head}POINT_DATA 6\nVECTORS Velocity float\n{'1 2 3 ' * 6}", encoding="ascii")
        path, = self.imports("a.vtk", "-o", "v.vdb")
        self.assertEqual(vdb.read(str(path), "velocity").transform.voxelSize(), (2, 2, 3))
        grid, points = vtkStructuredGrid(), vtkPoints()
        at = numpy.array([(0.5 * x, 2.0, 0.25 * z) for z in range(5) for x in range(7)])
        for place in at:
            points.InsertNextPoint(place)
        grid.SetDimensions(7, 5, 1)
        grid.SetPoints(points)
        values = flows.numpy_to_vtk(flows.flow(at), deep=True)
        values.SetName("U")
        grid.GetPointData().AddArray(values)
        append = vtkAppendFilter()
        append.AddInputData(grid)
        append.Update()
        for name, data in ("a.vts", grid), ("a.vtu", append.GetOutput()):
            flows.write_vtk(data, self.folder / name)
            path, = self.imports(name, "-o", "w.vdb")
            active = self.assert_flow(path, lambda p: flows.flow(numpy.stack([p[..., 0], 2 + 0 * p[..., 1], p[..., 2]], -1)))
            self.assertEqual(active.shape[1], 1)
            self.assertTrue(active.all())


if __name__ == "__main__":
    unittest.main()
