"""The Python module on data of other packages: masked arrays, xarray, VTK and PyVista."""

import importlib
import os
import subprocess
import sys
import unittest
import warnings

import numpy

from python_module import MODULE
from support import ToolTest

import vdblic

SIZE = 12, 10, 8
FILL = 1e37  # as NetCDF's
VELOCITY = numpy.random.default_rng(5).normal(size=(*SIZE, 3)).astype(numpy.float32)
VELOCITY[2, 3, 4] = numpy.nan


def needed(test, name):
    """A module, without which a test is skipped."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return test.skipTest(f"the module {name} is missing")


def masked_velocity():
    """A velocity with masked voxels, some with one masked component, over a fill value."""
    velocity = numpy.ma.masked_array(numpy.nan_to_num(VELOCITY), numpy.zeros(VELOCITY.shape, bool))
    velocity[3:5, 2:6] = numpy.ma.masked
    velocity[7, 7, 7, 1] = numpy.ma.masked
    velocity.data[velocity.mask] = FILL
    return velocity


class Masked(ToolTest):
    def test_masked_voxels_are_inactive(self):
        masked = masked_velocity()
        active = ~masked.mask.any(axis=3)
        known = vdblic.Grid(masked.filled(0), active, name="velocity")
        expected = list(vdblic.advect([known] * 3))[-1]
        for frames in (
                [masked] * 3, [(k / 24, masked) for k in range(3)], numpy.ma.stack([masked] * 3),
                [vdblic.Grid(masked, name="velocity")] * 3):
            texture = list(vdblic.advect(frames, layout="txyz"))[-1]
            for name in expected:
                numpy.testing.assert_array_equal(texture[name].active, active)
                numpy.testing.assert_array_equal(texture[name].values, expected[name].values)
                self.assertLess(texture[name].values.max(), 100)

    def test_masks_are_written_and_rendered(self):
        speed = numpy.ma.masked_less(numpy.random.default_rng(2).random(SIZE), 0.3)
        speed.data[speed.mask] = FILL
        also = numpy.ones(SIZE, bool)
        also[:, :2] = False
        vdblic.write(self.folder / "a.vdb", vdblic.Grid(speed, also))
        back = vdblic.read(self.folder / "a.vdb")["density"]
        where = tuple(slice(low, low + n) for low, n in zip(back.origin, back.values.shape))
        numpy.testing.assert_array_equal(back.active, (~speed.mask & also)[where])
        self.assertLessEqual(back.values.max(), 1)
        bare = vdblic.Renderer(size=(30, 20))(speed)
        known = vdblic.Volume([vdblic.Grid(speed.filled(0), ~speed.mask)])
        numpy.testing.assert_array_equal(bare.linear, vdblic.Renderer(size=(30, 20))(known).linear)


class Volumes(ToolTest):
    def test_of_arrays(self):
        volume = vdblic.as_volume(VELOCITY, voxel_size=(1, 2, 3))
        numpy.testing.assert_array_equal(volume["velocity"].transform, numpy.diag([1, 2, 3, 1]))
        self.assertEqual(list(vdblic.as_volume(VELOCITY[..., 0])), ["density"])
        self.assertIs(vdblic.as_volume(volume), volume)
        for bad, words in ((VELOCITY[0, 0], r"shape \(8, 3\)"), ("v", "'v' is no field"), (1j * VELOCITY, "complex"),
                           ([[1], [2, 3]], "no field")):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                vdblic.as_volume(bad)

    def test_one_field_is_one_frame(self):
        still = numpy.nan_to_num(VELOCITY)
        expected, = vdblic.advect([still])
        for one in still, vdblic.as_volume(still), vdblic.as_volume(still)["velocity"]:
            texture, = vdblic.advect(one)
            numpy.testing.assert_array_equal(texture["density"].values, expected["density"].values)


class XArray(ToolTest):
    def setUp(self):
        super().setUp()
        self.xarray = needed(self, "xarray")

    def dataset(self, order=("time", "z", "y", "x"), **coordinates):
        """u, v, w at three times, with axes in the usual order of NetCDF."""
        places = {"x": 100 + 2.0 * numpy.arange(12), "y": 50 - 0.5 * numpy.arange(10), "z": 0.25 * numpy.arange(8),
                  "time": 10 + 0.5 * numpy.arange(3)} | coordinates
        values = numpy.stack([VELOCITY, 2 * VELOCITY, 3 * VELOCITY])
        variables = {name: self.xarray.DataArray(values[..., i], dims=("time", "x", "y", "z"), coords=places).transpose(*order)
                     for i, name in enumerate("uvw")}
        return self.xarray.Dataset(variables)

    def known(self):
        """The same as grids."""
        place = numpy.diag([2.0, -0.5, 0.25, 1])
        place[:3, 3] = 100, 50, 0
        active = ~numpy.isnan(VELOCITY).any(axis=3)
        for k in range(3):
            grid = vdblic.Grid((k + 1) * VELOCITY, active, place, name="velocity")
            yield vdblic.Volume([grid], {"time": 10 + 0.5 * k})

    def assert_same(self, textures, expected):
        textures, expected = list(textures), list(expected)
        self.assertEqual(len(textures), len(expected))
        for one, other in zip(textures, expected):
            numpy.testing.assert_array_equal(one["density"].transform, other["density"].transform)
            numpy.testing.assert_array_equal(one["density"].active, other["density"].active)
            numpy.testing.assert_array_equal(one["density"].values, other["density"].values)
            self.assertEqual((one.time, one.metadata["dt"]), (other.time, other.metadata["dt"]))

    def test_datasets_and_arrays_are_grids(self):
        expected = list(vdblic.advect(self.known(), refine=2))
        data = self.dataset()
        vectors = data.to_array("component").rename("wind").transpose("time", "component", "z", "x", "y")
        parts = [data.isel(time=k) for k in range(3)]
        for frames in (data, self.dataset(order=("y", "time", "x", "z")), vectors, parts,
                       [(part.time.item(), part.drop_vars("time")) for part in parts]):
            self.assert_same(vdblic.advect(frames, refine=2), expected)

    def test_axes_are_known_by_their_attribute(self):
        data = self.dataset().rename(x="east", y="north", z="height")
        for name, axis in ("east", "X"), ("north", "Y"), ("height", "Z"):
            data[name].attrs["axis"] = axis
        self.assert_same(vdblic.advect(data), vdblic.advect(self.known()))

    def test_dates_are_counted_from_the_first(self):
        first = numpy.datetime64("2005-08-28T06:00:00", "ns")
        data = self.dataset(time=first + numpy.timedelta64(500, "ms") * numpy.arange(3))
        textures = list(vdblic.advect(data))
        self.assertEqual([(t.time, t.metadata["start"]) for t in textures],
                         [(0.5 * k, "2005-08-28T06:00:00") for k in range(3)])
        part = vdblic.as_volume(data.isel(time=1))
        self.assertEqual((part.time, part.metadata["start"]), (1125208800.5, "1970-01-01T00:00:00"))

    def test_units_and_axes_without_coordinates(self):
        data = self.dataset().isel(time=0)
        data["x"].attrs["units"] = "km"
        volume = vdblic.as_volume(data.drop_vars(["y", "z"]).isel(z=[0]), voxel_size=(7, 8, 9))
        self.assertEqual(volume.metadata, {"length_unit": "m", "time": 10.0})
        numpy.testing.assert_array_equal(volume["u"].transform[:3], [[2000, 0, 0, 1e5], [0, 8, 0, 0], [0, 0, 9, 0]])
        single = data.assign_coords(x=(5e5 + 0.1 * numpy.arange(12)).astype(numpy.float32))
        self.assertAlmostEqual(vdblic.as_volume(single)["u"].voxel_size[0], 0.1, places=2)

    def test_units_are_those_of_the_import(self):
        data = self.dataset()
        data["x"].attrs["units"], data["y"].attrs["units"], data["time"].attrs["units"] = "feet", "hm", "minutes"
        volume = vdblic.as_volume(data.isel(time=1))
        numpy.testing.assert_allclose(numpy.diag(volume["u"].transform)[:3], (0.6096, -50, 0.25))
        self.assertEqual((volume.time, volume.metadata["length_unit"]), (630.0, "m"))

    def test_the_earth_is_read_as_the_tool_reads_files(self):
        """A Dataset on longitude, latitude and depth: the velocity is that of the file."""
        import earth_flows  # pylint: disable=import-outside-toplevel  # it needs netCDF4

        earth_flows.write(self.folder / "sea.nc", earth_flows.sea())
        path, = self.outputs("vdblic_import", "sea.nc", "-o", "v.vdb")
        known = vdblic.read(path)["velocity"]
        with self.xarray.open_dataset(self.folder / "sea.nc") as data:
            found = vdblic.as_volume(data.isel(time=0))
            numpy.testing.assert_array_equal(found["velocity"].values, known.values)
            numpy.testing.assert_allclose(found["velocity"].transform, known.transform, rtol=1e-12)
            self.assertEqual(found.metadata["length_unit"], "m")
            del data["u"].attrs["units"]
            with self.assertRaisesRegex(ValueError, "the Dataset: 'u' has no units"):
                vdblic.as_volume(data.isel(time=0))

    def test_an_array_is_a_grid_and_a_texture(self):
        speed = self.dataset().u.isel(time=0).rename("speed")
        grid = vdblic.Grid(speed, name="s")
        self.assertEqual((grid.name, grid.values.shape), ("s", SIZE))
        expected, = self.known().__next__().grids
        numpy.testing.assert_array_equal(grid.transform, expected.transform)
        numpy.testing.assert_array_equal(grid.active, ~numpy.isnan(VELOCITY[..., 0]))
        moved = vdblic.Grid(speed, transform=numpy.diag([3, 3, 3, 1.0]))
        numpy.testing.assert_array_equal(moved.transform, numpy.diag([3, 3, 3, 1]))
        picture = vdblic.Renderer(size=(30, 20))(speed)
        known = vdblic.Volume([vdblic.Grid(VELOCITY[..., 0], grid.active, grid.transform)])
        numpy.testing.assert_array_equal(picture.linear, vdblic.Renderer(size=(30, 20))(known).linear)

    def test_mistakes(self):
        data = self.dataset().isel(time=0)
        degrees = data.copy()
        degrees["y"].attrs["units"] = "degrees_north"
        hours = data.copy()
        hours["time"].attrs["units"] = "hours since 2000-01-01"
        uneven = data.assign_coords(z=[0, 1, 2, 3, 4, 5, 7, 8])
        for bad, words in (
                (uneven, r"coordinates 'z' are uneven, with steps from 1 to 2; .*\.interp\(z=numpy.linspace\(0, 8, 8\)\)"),
                (data.assign_coords(z=[1] * 8), "coordinates 'z' are uneven"),
                (data.assign_coords(x=list("abcdefghijkl")), "coordinates 'x' are not finite numbers"),
                (degrees, "the Dataset: .*; say .* data\\['x'\\].attrs\\['units'\\] = 'm'"), (degrees.u, "'y' are in 'degrees_north'"),
                (hours, "times 'time' are in 'hours since 2000-01-01'"),
                (data.rename(x="lon", y="lat"), "the Dataset: 'z' has no units; say which"),
                (data.u.rename(z="level"), "'u' has no dimension z; its dimensions are level, y, x"),
                (self.dataset().u, r"the data have a dimension 'time'; choose one moment, as .isel\(time=0\) does"),
                (data.expand_dims(run=3, member=3).u, "beside x, y and z; a vector has one, of 3 components")):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                vdblic.as_volume(bad)
            if bad is not uneven:
                continue
            with self.assertRaisesRegex(ValueError, "frame 2: the coordinates 'z' are uneven"):
                list(vdblic.advect([data, bad]))
        with self.assertRaisesRegex(ValueError, "several grids: u, v, w"):
            vdblic.Grid(data)
        with self.assertRaisesRegex(ValueError, r"the texture has the shape \(12, 10, 8, 3\)"):
            vdblic.Renderer()(data.to_array("component"))


class VTK(ToolTest):
    def image(self, cells=False):
        """A turned image with an extent, vectors, a scalar and hidden voxels."""
        model = needed(self, "vtkmodules.vtkCommonDataModel")
        core = needed(self, "vtkmodules.vtkCommonCore")
        bridge = needed(self, "vtkmodules.util.numpy_support")
        image, more = model.vtkImageData(), int(cells)
        image.SetExtent(4, 4 + 11 + more, -2, -2 + 9 + more, 0, 7 + more)
        image.SetSpacing(0.5, 0.25, 2)
        image.SetOrigin(10, 20, 30)
        image.SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1)
        data = image.GetCellData() if cells else image.GetPointData()
        hidden = numpy.zeros(SIZE, numpy.uint8)
        hidden[0, 1] = 32 if cells else 2
        velocity = numpy.nan_to_num(VELOCITY)
        for name, values in ("speed", velocity[..., 0]), ("flow", velocity), ("vtkGhostType", hidden):
            array = bridge.numpy_to_vtk(values.swapaxes(0, 2).reshape(-1, *values.shape[3:]), deep=True)
            array.SetName(name)
            data.AddArray(array)
        data.SetActiveVectors("flow")
        time = core.vtkDoubleArray()
        time.SetName("TimeValue")
        time.InsertNextValue(1.5)
        image.GetFieldData().AddArray(time)
        return image

    def test_images_are_grids(self):
        for cells in False, True:
            image = self.image(cells)
            volume = vdblic.as_volume(image)
            self.assertEqual((list(volume), volume.time), (["flow", "speed"], 1.5))
            flow = volume["flow"]
            self.assertEqual(flow.origin, (4, -2, 0))
            numpy.testing.assert_array_equal(flow.values, numpy.nan_to_num(VELOCITY))
            self.assertFalse(flow.active[0, 1].any())
            self.assertEqual((~flow.active).sum(), SIZE[2])
            # The voxels are where VTK has its points or the middles of its cells.
            places = flow.positions().swapaxes(0, 2).reshape(-1, 3)
            for number in 0, 1, 100, len(places) - 1:
                bounds = image.GetCell(number).GetBounds() if cells else numpy.repeat(image.GetPoint(number), 2)
                numpy.testing.assert_allclose(places[number], numpy.reshape(bounds, (3, 2)).mean(axis=1))
            texture, = vdblic.advect(image)
            expected, = vdblic.advect([vdblic.Grid(flow.values, flow.active, flow.transform, flow.origin, "velocity")])
            numpy.testing.assert_array_equal(texture["density"].values, expected["density"].values)
            numpy.testing.assert_array_equal(texture["density"].transform, expected["density"].transform)

    def test_an_image_of_one_array_is_a_texture(self):
        image = self.image()
        image.GetPointData().RemoveArray("flow")
        grid = vdblic.Grid(image)
        self.assertEqual((grid.name, grid.origin), ("density", (4, -2, 0)))
        numpy.testing.assert_array_equal(vdblic.Renderer(size=(30, 20))(image).linear, vdblic.Renderer(size=(30, 20))(grid).linear)

    def test_mistakes(self):
        model = needed(self, "vtkmodules.vtkCommonDataModel")
        for bad, words in ((model.vtkUnstructuredGrid(), "a vtkUnstructuredGrid has no even voxels; resample it"),
                           (model.vtkImageData(), "no arrays of 1 or 3 components")):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                vdblic.as_volume(bad)
            with self.subTest(words), self.assertRaisesRegex(ValueError, "frame 1: .*" + words):
                list(vdblic.advect([bad]))

    def test_pyvista(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pyvista = needed(self, "pyvista")
        image = pyvista.ImageData(dimensions=SIZE, spacing=(0.5, 1, 2), origin=(1, 2, 3))
        velocity = numpy.nan_to_num(VELOCITY)
        image["wind"] = velocity.reshape(-1, 3, order="F")
        volume = vdblic.as_volume(image)
        numpy.testing.assert_array_equal(volume["wind"].values, velocity)
        numpy.testing.assert_array_equal(volume["wind"].transform[:3], [[0.5, 0, 0, 1], [0, 1, 0, 2], [0, 0, 2, 3]])
        texture, = vdblic.advect(image)
        image["texture"] = texture["density"].values.ravel(order="F")
        self.assertEqual(vdblic.Renderer(size=(30, 20), texture="texture")(image).shape, (20, 30, 3))


class Imports(ToolTest):
    def test_no_package_is_imported(self):
        program = ("import sys, numpy, vdblic; list(vdblic.advect([numpy.ones((4, 4, 4, 3))])); "
                   "print([m for m in sys.modules if m.split('.')[0] in ('xarray', 'pyvista', 'vtk', 'vtkmodules')])")
        done = subprocess.run([sys.executable, "-c", program], env=os.environ | {"PYTHONPATH": str(MODULE)}, text=True,
                              capture_output=True, check=True)
        self.assertEqual(done.stdout, "[]\n")


if __name__ == "__main__":
    unittest.main()
