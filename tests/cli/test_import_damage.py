"""vdblic_import refuses files that end too early, and values whose place is missing."""

import pickle
import shutil
import struct
import unittest
import zipfile

import netCDF4
import numpy
import pyopenvdb as vdb

import flows
import netcdf_flows
from imports import TIMES, ImportTest, velocity_of


def hide(path, name, place=..., packed=False):
    """Make values of a variable missing; if packed, by a valid range of packed numbers that few of them have."""
    with netCDF4.Dataset(path, "r+") as data:
        if not packed:
            values = data[name][:]
            values[place] = numpy.nan
            data[name][:] = values
            return
        old = data[name]
        values = old[:]
        data.renameVariable(name, "unpacked")
        new = data.createVariable(name, "i2", old.dimensions)
        new.setncatts({key: old.getncattr(key) for key in old.ncattrs() if key != "_FillValue"})
        new.scale_factor = 1 / 30000
        new[:] = values
        new.valid_min, new.valid_max = numpy.int16([-1, 0])


class Places(ImportTest):
    def sea(self):
        netcdf_flows.write_ocean(self.folder / "sea.nc", [0])
        return self.folder / "sea.nc"

    def test_levels_of_the_sea(self):
        hide(self.sea(), "Cs_r", packed=True)
        message = self.refuses(3, "sea.nc", "-o", "v.vdb")
        self.assertIn("'Cs_r', which gives other values their place, lacks 6 of 6 values", message)
        self.assertIn("valid_min and valid_max, which are in packed numbers", message)
        for name in "s_rho", "hc", "h", "zeta", "angle", "lon_rho":
            hide(self.sea(), name, ... if name in ("s_rho", "hc") else (..., 3, 4))
            self.assertIn(f"'{name}', which gives other values their place", self.refuses(3, "sea.nc", "-o", "v.vdb"))
        hide(self.sea(), "mask_rho")
        self.assertIn("'mask_rho' is 1 nowhere", self.refuses(3, "sea.nc", "-o", "v.vdb"))

    def test_land_needs_no_place(self):
        self.imports(self.sea(), "-o", "whole.vdb")
        for name in "h", "zeta", "angle":
            hide(self.folder / "sea.nc", name, (..., slice(None), 0))  # land
        self.imports("sea.nc", "-o", "part.vdb", "--like", "whole.vdb")
        whole, active, _ = velocity_of(self.folder / "whole.vdb")
        part, other, _ = velocity_of(self.folder / "part.vdb")
        numpy.testing.assert_array_equal(active, other)
        numpy.testing.assert_allclose(whole[active], part[active], atol=1e-4)

    def test_flow_that_is_missing_in_the_sea(self):
        self.imports(self.sea(), "-o", "whole.vdb", "--size", 36, 28, 40)
        hide(self.folder / "sea.nc", "u", (0, 2, 3, 4))  # a face amid the sea
        self.imports("sea.nc", "-o", "part.vdb", "--like", "whole.vdb")
        whole, part = (vdb.read(str(self.folder / f"{name}.vdb"), "velocity") for name in ("whole", "part"))
        x, y = netcdf_flows.plane(numpy.linspace(10, 10.5, 9), numpy.linspace(43, 43.4, 7))
        lost = [voxel.min for voxel in whole.citerOnValues() if not part.getConstAccessor().isValueOn(voxel.min)]
        self.assertGreater(len(lost), 100)
        places = numpy.array([whole.transform.indexToWorld(voxel) for voxel in lost])
        self.assertTrue(((places[:, 0] > x[3]) & (places[:, 0] < x[6])).all())
        self.assertTrue(((places[:, 1] > y[2]) & (places[:, 1] < y[4])).all())

    def test_heights_of_pressure_levels(self):
        for place, status in ((0, 2, 3, 4), 3), ((0, slice(None), 3, 4), 3):
            netcdf_flows.write_pressure_levels(self.folder / "air.nc", [6])
            hide(self.folder / "air.nc", "z", place)
            self.assertIn("'z', which gives other values their place", self.refuses(status, "air.nc", "-o", "v.vdb"))
        for name in "uvw":  # what is missing itself needs no height
            hide(self.folder / "air.nc", name, place)
        path, = self.imports("air.nc", "-o", "v.vdb")
        self.assert_flow(path, lambda at: netcdf_flows.wind(at, 0.6))
        for name in "level", "longitude":
            netcdf_flows.write_pressure_levels(self.folder / "air.nc", [6])
            hide(self.folder / "air.nc", name, 2)
            self.assertIn(f"'{name}', which gives", self.refuses(3, "air.nc", "-o", "v.vdb"))

    def test_heights_of_wrf(self):
        netcdf_flows.write_wrf(self.folder / "wrfout_d01", ["2005-08-28_00:00:00"])
        hide(self.folder / "wrfout_d01", "PHB", (0, 2, 3, 4))
        self.assertIn("'PHB', which gives", self.refuses(3, "wrfout_d01", "-o", "v.vdb"))


class Times(ImportTest):
    def write(self, **attributes):
        netcdf_flows.write_heights(self.folder / "steady.nc", terrain=False)
        with netCDF4.Dataset(self.folder / "steady.nc") as steady:
            data = netcdf_flows.create(self.folder / "year.nc", month=3, z=5, y=6, x=9)
            for name in "zyx":
                netcdf_flows.put(data, name, (name,), steady[name][:], units=steady[name].units)
            netcdf_flows.put(data, "month", ("month",), [1, 2, 3], **attributes)
            for name in "uvw":
                netcdf_flows.put(data, name, ("month", "z", "y", "x"), [steady[name][:]] * 3, units="m/s")
            data.close()

    def test_a_time_axis_without_units(self):
        self.write()
        message = self.refuses(3, "year.nc", "-o", "v.%04d.vdb")
        self.assertIn("the time axis 'month' has no units", message)
        self.assertIn("--attribute 'month:units=days since 2000-01-01'", message)
        self.write(units="months")
        self.assertIn("the time axis 'month' is in 'months'", self.refuses(3, "year.nc", "-o", "v.%04d.vdb"))
        self.write(units="days since 2000-01-01")
        paths = self.imports("year.nc", "-o", "v.%04d.vdb")
        self.assertEqual([vdb.readMetadata(str(path))["time"] for path in paths], [0, 86400, 172800])
        self.assertEqual(vdb.readMetadata(str(paths[2]))["start"], "2000-01-02T00:00:00")

    def test_the_time_of_a_missing_array(self):
        flows.write_foam(self.folder / "case", TIMES)
        (self.folder / "case/0.5/U").unlink()
        done = self.run_tool("vdblic_import", "case", "-o", "v.%04d.vdb", "--array", "U")
        self.assertEqual((done.returncode, done.stdout), (3, "v.0001.vdb\n"))
        self.assertIn("case: at 0.5 s: no array 'U'", done.stderr)


class Truncated(ImportTest):
    def test_netcdf(self):
        for kind in "NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA", "NETCDF4":
            with self.subTest(kind):
                with netCDF4.Dataset(self.folder / "w.nc", "w", format=kind) as data:
                    for name, size in ("time", None), ("z", 3), ("y", 4), ("x", 5):
                        data.createDimension(name, size)
                        netcdf_flows.put(data, name, (name,), numpy.arange(size or 2), units="s" if not size else "m")
                    for i, name in enumerate("uvw"):
                        netcdf_flows.put(data, name, ("time", "z", "y", "x"), numpy.full((2, 3, 4, 5), i + 1), units="m/s")
                self.imports("w.nc", "-o", "v.%04d.vdb")
                for path in self.folder.glob("v.*.vdb"):
                    path.unlink()
                whole = self.contents("w.nc")
                for length in len(whole) - 8, len(whole) // 2, 50, 9:
                    (self.folder / "w.nc").write_bytes(whole[:length])
                    self.assertIn("w.nc: ", self.refuses(3, "w.nc", "-o", "v.%04d.vdb"))

    def test_openfoam(self):
        flows.write_foam(self.folder / "whole", [0.0], sizes=(20, 20, 1))
        for name in "0/U", "constant/polyMesh/points", "constant/polyMesh/faces", "constant/polyMesh/owner":
            for share in 0.3, 0.7, 0.75, 0.98:
                shutil.rmtree(self.folder / "case", ignore_errors=True)
                shutil.copytree(self.folder / "whole", self.folder / "case")
                whole = self.contents(f"whole/{name}")
                (self.folder / "case" / name).write_bytes(whole[:int(share * len(whole))])
                with self.subTest(name, share=share):
                    self.assertIn("case: ", self.refuses(3, "case", "-o", "v.vdb"))

    def test_a_header_of_numpy(self):
        numpy.save(self.folder / "a.npy", numpy.ones((8, 8, 8, 3)))
        (self.folder / "a.npy").write_bytes(self.contents("a.npy").replace(b"}", b"("))
        self.assertIn("a.npy: cannot be read as NumPy's arrays", self.refuses(3, "a.npy", "-o", "v.vdb"))

    def test_shapes_and_types_of_numpy(self):
        for shape, kind, words in (
                ("(0, 8, 8, 3)", "<f4", "a.npy: "), ("(-1, 8, 8, 3)", "<f4", "a.npy: "),
                ("(-2, -4, 8, 3)", "<f4", "a.npy: "), ("(8, 8, 8, 3)", "|O", "a.npy: cannot be read"),
                ("(8, 8, 'a', 3)", "<f4", "a.npy: cannot be read"), ("(99999999999, 8, 8, 3)", "<f8", "a.npy: "),
                ("(8, 8, 8, 3)", "<m8[s]", "no array is a field"), ("(8, 8, 8, 3)", "<c8", "no array is a field"),
                ("(8, 8, 8)", "<U4", "no array is a field")):
            header = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
            (self.folder / "a.npy").write_bytes(b"\x93NUMPY\x01\x00v\x00" + header.encode() + bytes(16 * 8**3 * 3))
            with self.subTest(shape, kind=kind):
                self.assertIn(words, self.refuses(3, "a.npy", "-o", "v.vdb", "--layout", "xyzc"))
        (self.folder / "a.npy").write_bytes(pickle.dumps(numpy.ones((8, 8, 8, 3))))
        self.assertIn("a.npy: cannot be read", self.refuses(3, "a.npy", "-o", "v.vdb"))
        for place in {"time": "noon"}, {"voxel_size": "wide"}, {"origin": [{}]}:
            for name, value in place.items():
                numpy.savez(self.folder / "a.npz", **{"velocity": numpy.ones((8, 8, 8, 3)), "voxel_size": 1} | place)
                with self.subTest(name):
                    self.assertIn("a.npz: ", self.refuses(3, "a.npz", "-o", "v.vdb"))
        for name, shape in ("velocity", (8, 0, 8, 3)), ("velocity", (0, 8, 8, 8, 3)), ("active", (0, 8, 8)):
            numpy.savez(self.folder / "a.npz", **({"velocity": numpy.ones((8, 8, 8, 3)), "voxel_size": 1} | {name: numpy.ones(shape)}))
            with self.subTest(name, shape=shape):
                self.assertIn("a.npz: ", self.refuses(3, "a.npz", "-o", "v.vdb"))

    def test_the_place_in_arrays_of_numpy(self):
        """Of types and shapes that are no place, and matrices that are none."""
        values, whole = numpy.ones((8, 8, 8, 3)), numpy.zeros(8, [("a", "f4"), ("b", "i4")])
        axes = dict.fromkeys("xyz", numpy.arange(8.0))
        for place in ({"voxel_size": whole}, {"origin": whole, "voxel_size": 1}, {"matrix": whole},
                      {"matrix": numpy.ones((4, 4, 4))}, {"matrix": numpy.ones((4, 4))}, axes | {"x": numpy.array(list("abcdefgh"))},
                      axes | {"y": numpy.zeros(8, "V1")}, axes | {"z": numpy.array([0, 1, 2, 3, numpy.nan, 5, 6, 7])},
                      axes | {"x": numpy.array([0, 1, 2, 2, 2, 5, 6, 7.0])}):
            numpy.savez(self.folder / "a.npz", velocity=values, **place)
            with self.subTest(place):
                self.assertIn("a.npz: ", self.refuses(3, "a.npz", "-o", "v.vdb"))

    def test_headers_and_archives_that_numpy_stumbles_over(self):
        def of(header):
            return b"\x93NUMPY\x02\0" + struct.pack("<I", len(header)) + header

        numpy.savez_compressed(self.folder / "a.npz", velocity=numpy.ones((8, 8, 8, 3)))
        good = self.contents("a.npz")
        begin, entry = good.index(b"velocity.npy") + 32, good.index(b"PK\x01\x02")
        garbage = good[:begin] + b"\xff" * 40 + good[begin + 40:]
        unknown, locked = (good[:entry + at] + bytes((number, 0)) + good[entry + at + 2:] for at, number in ((10, 97), (8, 1)))
        with zipfile.ZipFile(self.folder / "z.zip", "w") as archive:
            archive.writestr("velocity.npy", b"no array")
        for name, data in (("a.npy", of(b"1+" * 3000 + b"1\n")), ("a.npy", of(b"-" * 5000 + b"1\n")),
                           ("a.npy", of(b"{'descr': '<f4', 'fortran_order': False, 'shape': (" + b"9" * 4000 + b",)}\n")),
                           ("a.npz", garbage), ("a.npz", unknown), ("a.npz", locked), ("a.npz", self.contents("z.zip"))):
            (self.folder / name).write_bytes(data)
            with self.subTest(data[:60]):
                message = self.refuses(3, name, "-o", "v.vdb", "--layout", "xyzc")
                self.assertIn(f"{name}: ", message)
                self.assertLess(len(message), 1000)

    def test_other_forms(self):
        flows.write_vtk(flows.image(), self.folder / "a.vti")
        flows.write_vtk(flows.tetrahedra(), self.folder / "a.vtu")
        flows.write_vtk(flows.image(), self.folder / "a.vtk")
        numpy.save(self.folder / "a.npy", numpy.ones((8, 8, 8, 3)))
        numpy.savez(self.folder / "a.npz", velocity=numpy.ones((8, 8, 8, 3)))
        for name in "a.vti", "a.vtu", "a.vtk", "a.npy", "a.npz":
            whole = self.contents(name)
            for share in 0.3, 0.9:
                (self.folder / name).write_bytes(whole[:int(share * len(whole))])
                with self.subTest(name, share=share):
                    self.assertIn(f"{name}: ", self.refuses(3, name, "-o", "v.vdb"))


class EnSight(ImportTest):
    def refuses_every_start(self, name, tail):
        """A file that is cut off anywhere, but in its last `tail` bytes, is refused by its name."""
        whole = self.contents(name)
        for size in numpy.linspace(1, len(whole) - tail, 6).astype(int):
            with self.subTest(name=name, size=size):
                (self.folder / name).write_bytes(whole[:size])
                self.assertIn(f"{name}: it ends too early: ", self.refuses(3, "flow.case", "-o", "v.%04d.vdb"))
        (self.folder / name).write_bytes(whole)

    def test_a_block(self):
        flows.write_ensight(self.folder, TIMES)
        for name in "flow.geo", "flow.U.0000":
            self.refuses_every_start(name, 14)
        data = self.contents("flow.U.0002")
        (self.folder / "flow.U.0002").write_bytes(data[:len(data) // 2])
        self.assertRegex(self.fails(3, "vdblic_import", "flow.case", "-o", "v.%04d.vdb", "--frames", 3),
                         r"flow.U.0002: it ends too early: 'block' of part 1 has \d+ of 945 values; copy it again")
        self.imports("flow.case", "-o", "v.%04d.vdb", "--frames", "1-2")  # which need that file not

    def test_cells(self):
        for gold in True, False:
            flows.write_ensight_cells(self.folder, gold)
            self.assert_flow(self.imports("flow.case", "-o", "v.vdb")[0], flows.flow)
            (self.folder / "v.vdb").unlink()
            self.refuses_every_start("flow.geo", 12)
            self.refuses_every_start("flow.U", 80)


if __name__ == "__main__":
    unittest.main()
