"""vdblic_import: one flow whose components lie in several files, or on several grids of one file."""

import unittest

import netCDF4
import numpy
import pyopenvdb as vdb

import netcdf_flows
from imports import ImportTest, velocity_of

FILES = "U.nc", "V.nc", "W.nc"


class Joined(ImportTest):
    def test_a_file_for_each_component(self):
        hours = [0.0, 0.5, 2.0]
        netcdf_flows.write_c_grid(self.folder, hours)
        paths = self.imports(*FILES, "-o", "v.%04d.vdb")
        for hour, path in zip(hours, paths, strict=True):
            active = self.assert_flow(path, lambda at, hour=hour: netcdf_flows.wind(at, hour))
            self.assertGreater(active.sum(), 100)
            found = vdb.readMetadata(str(path))
            self.assertEqual((found["time"], found["start"], found["source"], found["velocity_array"]),
                             (3600 * hour, "1990-01-01T00:00:00", "U.nc V.nc W.nc", "velU,velV,velW"))
        self.assert_advects("v.%04d.vdb")
        # The first one chooses voxels and place; the others come in any order.
        path, = self.imports("U.nc", "W.nc", "V.nc", "-o", "w.%04d.vdb", "--frames", 3)
        numpy.testing.assert_array_equal(velocity_of(path)[0], velocity_of(paths[2])[0])
        self.assertIn("velU and velV have no third component",
                      self.run_tool("vdblic_import", "U.nc", "V.nc", "-o", "p.%04d.vdb").stderr)

    def test_a_pattern_for_each_component(self):
        for frame, hour in (3, 1.0), (4, 3.0):
            netcdf_flows.write_c_grid(self.folder, [hour], f"{{}}.{frame:04}.nc")
        paths = self.imports("U.%04d.nc", "V.%04d.nc", "W.%04d.nc", "-o", "v.%04d.vdb", "--frames", "3-4")
        self.assertEqual([path.name for path in paths], ["v.0003.vdb", "v.0004.vdb"])
        self.assert_flow(paths[1], lambda at: netcdf_flows.wind(at, 3.0))
        (self.folder / "V.0004.nc").rename(self.folder / "V.0005.nc")
        self.assertIn("V.%04d.nc: its files are not numbered as those of U.%04d.nc",
                      self.refuses(3, "U.%04d.nc", "V.%04d.nc", "W.%04d.nc", "-o", "w.%04d.vdb"))

    def test_several_grids_in_a_file(self):
        netcdf_flows.write_b_grid(self.folder / "pop.nc")
        path, = self.imports("pop.nc", "-o", "v.vdb")
        active = self.assert_flow(path, netcdf_flows.wind)
        self.assertGreater(active.sum(), 100)

    def test_mistakes(self):
        netcdf_flows.write_c_grid(self.folder, [0, 1])
        netcdf_flows.write_c_grid(self.folder, [0, 1, 2], "{}-long.nc")
        with netCDF4.Dataset(self.folder / "V.nc", "r+") as data:
            data["time_counter"][1] = 2
        for status, words, *inputs in (
                (3, "V.nc: step 2 is at 631159200 s, in U.nc at 631155600 s; files of one flow have the same times",
                 "U.nc", "V.nc"),
                (3, "V-long.nc: it holds 3 steps, U.nc 2; files of one flow have the same", "U.nc", "V-long.nc"),
                (3, "X.nc: no such file", "U.nc", "X.nc"),
                (3, "no array is known as a velocity; choose with --array", "U.nc", "W.nc"),
                (2, "paths on standard input are one flow; leave out the other inputs", "U.nc", "-")):
            with self.subTest(words):
                self.assertIn(words, self.refuses(status, *inputs, "-o", "v.%04d.vdb"))


if __name__ == "__main__":
    unittest.main()
