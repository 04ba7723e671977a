"""A fuzz of headers: attributes are dropped, renamed, written in other letters and in another order.

vdblic_import makes the velocity of the untouched file of it, or refuses it by name; never another velocity.
"""

import copy
import unittest

import numpy
import pyopenvdb as vdb

import earth_flows
from imports import ImportHere
from support import often

COUNT = often(200, 2000)


def projected():
    mapping = {"grid_mapping_name": "polar_stereographic", "latitude_of_projection_origin": 90.0, "standard_parallel": 70.0,
               "straight_vertical_longitude_from_pole": 0.0, "false_easting": 0.0, "false_northing": 0.0}
    file = earth_flows.sea()
    for old, name, kind in ("lon", "x", "projection_x_coordinate"), ("lat", "y", "projection_y_coordinate"):
        _, values, _ = file.pop(old)
        file[name] = [(name,), 900 + 10 * values, {"units": "km", "standard_name": kind, "axis": name.upper()}]
    file["crs"] = [(), numpy.array(0, "i4"), mapping]
    for name in "uv":
        file[name][0] = ("time", "depth", "y", "x")
        file[name][2]["grid_mapping"] = "crs"
    return file


def sigma():
    """Levels that follow the bottom, a velocity in cm/s, times of another calendar."""
    file = earth_flows.sea()
    file["s"] = [("s",), -numpy.array([0.1, 0.3, 0.6, 0.9]), {
        "standard_name": "ocean_sigma_coordinate", "formula_terms": "sigma: s eta: zeta depth: h", "positive": "up"}]
    file["h"] = [("lat", "lon"), 0.1 + 0.02 * numpy.arange(8) + numpy.zeros((6, 1)), {"units": "km"}]
    file["zeta"] = [("time", "lat", "lon"), numpy.full((1, 6, 8), 50.0), {"units": "cm"}]
    file["time"][2] |= {"units": "days since 0001-01-01", "calendar": "noleap"}
    for name in "uv":
        file[name][0], file[name][2]["units"] = ("time", "s", "lat", "lon"), "cm/s"
    del file["depth"]
    return file


def surface():
    file = earth_flows.sea()
    for name in "uv":
        file[name][1] = file[name][1][:, :1]
    file["depth"][1] = file["depth"][1][:1]
    return file


class Headers(ImportHere):
    def result(self, file):
        """The velocity, where it is and when; None if the file was refused."""
        earth_flows.write(self.folder / "f.nc", file)
        done = self.run_tool("vdblic_import", "f.nc", "-o", "v.%04d.vdb", "-q")
        if done.returncode:
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("f.nc: ", done.stderr)
            return None
        grid = vdb.read(str(self.folder / "v.0001.vdb"), "velocity")
        low, high = grid.evalActiveVoxelBoundingBox()
        values = numpy.zeros((*(b - a + 1 for a, b in zip(low, high)), 3), numpy.float32)
        grid.copyToArray(values, low)
        told = vdb.readMetadata(str(self.folder / "v.0001.vdb"))
        place = [grid.transform.indexToWorld(at) for at in (low, high)]
        return values, numpy.array(place), grid.activeVoxelCount(), told["start"], told["time"]

    def assert_same(self, one, other):
        # A voxel on the border of two cells belongs to either: VTK probes in several threads.
        numpy.testing.assert_allclose(one[0], other[0], atol=1e-3)
        numpy.testing.assert_allclose(one[1], other[1], rtol=1e-6, atol=1e-3)
        self.assertEqual(one[2:], other[2:])

    @staticmethod
    def changed(file, random):
        """A copy of a file with up to three changes in its header, and what they are."""
        file, changes = copy.deepcopy(file), []
        for _ in range(random.integers(1, 4)):
            name = random.choice([name for name in file if file[name][2]])
            told = file[name][2]
            key = random.choice(list(told))
            value = told.pop(key)
            change = random.choice(["drop", "rename", "letters", "value", "order"])
            if change == "rename":
                told[str(random.choice(["my_" + key, key + "s", key[:-1] or "x"]))] = value
            elif change == "letters":
                told[str(random.choice([key.upper(), key.capitalize(), key.swapcase()]))] = value
            elif change == "value" and isinstance(value, str):
                told[key] = str(random.choice([value.upper(), value.capitalize()]))
            elif change != "drop":
                told[key] = value
                file[name][2] = dict(random.permutation(list(told.items())).tolist()) if all(
                    isinstance(value, str) for value in told.values()) else told
            changes.append((change, name, key))
        return file, changes

    def test_changes(self):
        files = {"sea": earth_flows.sea(), "air": earth_flows.air(), "turned": earth_flows.turned(), "projected": projected(),
                 "sigma": sigma(), "surface": surface(), "fvcom": earth_flows.fvcom()[0], "mpas": earth_flows.mpas()}
        random, taken = numpy.random.default_rng(20), 0
        known = {kind: self.result(file) for kind, file in files.items()}
        for kind, result in known.items():
            self.assertIsNotNone(result, kind)
        for number in range(COUNT):
            kind = list(files)[number % len(files)]
            file, changes = self.changed(files[kind], random)
            with self.subTest(kind, changes=changes):
                result = self.result(file)
                if result is not None:
                    taken += 1
                    self.assert_same(result, known[kind])
        self.assertGreater(taken, COUNT / 5)  # most of the header may be changed without harm


if __name__ == "__main__":
    unittest.main()
