"""The Python module's grids and volumes as arrays and mappings, in notebooks, and in xarray; arrays in any order."""

import doctest
import importlib
import re
import unittest

import numpy

from python_module import MODULE
from support import ToolTest

import vdblic

SIZE = 12, 10, 8
FLOW = next(vdblic.synth("abc", SIZE, [1]))["velocity"].values


def xarray_for(test):
    try:
        return importlib.import_module("xarray")
    except ImportError:
        return test.skipTest("the module xarray is missing")


class Grids(unittest.TestCase):
    grid = vdblic.Grid(FLOW, name="velocity", transform=numpy.diag([2, 2, 3, 1.0]), origin=(5, 0, -1))

    def test_a_grid_is_an_array(self):
        self.assertEqual((self.grid.shape, self.grid.ndim, self.grid.dtype, len(self.grid)), (FLOW.shape, 4, FLOW.dtype, 12))
        for made, expected in (
                (numpy.asarray(self.grid), FLOW), (self.grid[1:5, ..., 0], FLOW[1:5, ..., 0]), (2 * self.grid + 1, 2 * FLOW + 1),
                (numpy.sqrt(abs(self.grid)), numpy.sqrt(abs(FLOW))), (numpy.linalg.norm(self.grid, axis=3), numpy.linalg.norm(FLOW, axis=3)),
                (self.grid == self.grid, FLOW == FLOW), (numpy.stack([self.grid] * 2), numpy.stack([FLOW] * 2))):
            self.assertIs(type(made), numpy.ndarray)
            numpy.testing.assert_array_equal(made, expected)
        self.assertEqual(float(numpy.max(self.grid)), FLOW.max())

    def test_copies_are_made_where_they_are_asked_for(self):
        self.assertTrue(numpy.shares_memory(numpy.asarray(self.grid), FLOW))
        for copy in numpy.array(self.grid), numpy.asarray(self.grid, float), self.grid.__array__(copy=True):
            self.assertFalse(numpy.shares_memory(copy, FLOW))
            numpy.testing.assert_array_equal(copy, FLOW)
        self.assertIs(self.grid.__array__(copy=False), FLOW)
        with self.assertRaisesRegex(ValueError, "the grid 'velocity' holds float32; as float64 it is a copy"):
            self.grid.__array__(float, copy=False)

    def test_a_notebook_shows_three_slices(self):
        page = self.grid._repr_html_()
        self.assertEqual(len(re.findall("data:image/png;base64,", page)), 3)
        self.assertEqual(re.findall(r"(\w) → (\w) ↑", page), [("x", "y"), ("x", "z"), ("y", "z")])
        self.assertIn("vdblic.Grid &#x27;velocity&#x27; (x: 12, y: 10, z: 8, 3) float32, voxel size 2, 3", page)
        # 24 × 20 × 24 world units
        self.assertEqual(re.findall(r"width:(\d+)px;height:(\d+)px", page), [("200", "167"), ("200", "200"), ("167", "200")])
        volume = vdblic.Volume([self.grid, vdblic.Grid(FLOW[..., 0], name="<p>")], {"frame": 3})
        self.assertEqual(volume._repr_html_().count("data:image/png"), 6)
        self.assertNotIn("<p>", volume._repr_html_())
        for odd in (numpy.full(SIZE, numpy.nan), numpy.zeros((0, 3, 3)), numpy.ones((1, 1, 1)), numpy.ones((600, 2, 2), bool),
                    numpy.ma.masked_all(SIZE)):
            self.assertIn("vdblic.Grid", vdblic.Grid(odd)._repr_html_())

    def test_a_slice_shows_the_values_of_the_middle(self):
        from vdblic import views  # pylint: disable=import-outside-toplevel

        values, shown = views._cut(vdblic.Grid(FLOW[..., 0], active=FLOW[..., 1] > 0), (slice(None), slice(None), 4))
        numpy.testing.assert_array_equal(values[-1, :], FLOW[:, 0, 4, 0])  # the lowest row is the first y
        numpy.testing.assert_array_equal(shown, (FLOW[:, :, 4, 1] > 0).T[::-1])

    def test_a_volume_is_a_mapping(self):
        volume = vdblic.Volume([self.grid], {"frame": 7, "time": 0.25})
        self.assertEqual(repr(volume), "<vdblic.Volume: velocity (12, 10, 8, 3); frame 7; time 0.25 s>")
        self.assertIs(dict(volume)["velocity"], self.grid)
        self.assertEqual(volume._ipython_key_completions_(), ["velocity"])


class XArray(unittest.TestCase):
    def setUp(self):
        self.xarray = xarray_for(self)

    def test_what_goes_to_xarray_comes_back(self):
        place = numpy.diag([2, -0.5, 3, 1.0])
        place[:3, 3] = 1, 2, 3
        active = FLOW[..., 0] > 0
        active[0, 0, 0] = active[-1, -1, -1] = True
        grid = vdblic.Grid(FLOW, active, place, (5, 0, -1), "velocity", {"unit": "m/s"})
        volume = vdblic.Volume([grid, vdblic.Grid(FLOW[..., 0], None, place, (5, 0, -1), "p")],
                               {"time": 1.5, "start": "2005-08-28T06:00:00", "length_unit": "m"})
        data = volume.to_xarray()
        self.assertEqual((list(data), data.velocity.dims, data.velocity.attrs, data.x.attrs),
                         (["velocity", "p"], ("x", "y", "z", "component"), {"units": "m/s"}, {"axis": "X", "units": "m"}))
        self.assertEqual(data.time.values, numpy.datetime64("2005-08-28T06:00:01.5", "ns"))
        numpy.testing.assert_array_equal(data.y, grid.positions()[0, :, 0, 1])
        self.assertTrue(numpy.isnan(data.velocity.values[~active]).all())
        back = vdblic.as_volume(data)
        numpy.testing.assert_array_equal(back["velocity"].active, active)
        numpy.testing.assert_array_equal(back["velocity"].values[active], FLOW[active])
        numpy.testing.assert_allclose(back["velocity"].positions(), grid.positions())
        numpy.testing.assert_array_equal(back["p"].values, FLOW[..., 0])
        self.assertEqual(grid.to_xarray().name, "velocity")

    def test_a_texture_over_time(self):
        textures = vdblic.advect(vdblic.synth("abc", SIZE, range(1, 4)), scalars="texture", refine=2)
        film = self.xarray.concat([texture.to_xarray() for texture in textures], "time")
        self.assertEqual(dict(film.density.sizes), {"time": 3, "x": 24, "y": 20, "z": 16})
        numpy.testing.assert_allclose(film.time, [0, 1 / 24, 2 / 24])

    def test_whole_numbers_without_gaps_keep_their_type(self):
        hits = vdblic.Grid(numpy.ones((2, 2, 2), numpy.int32), name="hits")
        self.assertEqual(hits.to_xarray().dtype, numpy.int32)
        hits.active = numpy.arange(8).reshape(2, 2, 2) > 0
        self.assertTrue(numpy.isnan(hits.to_xarray()[0, 0, 0]))

    def test_what_has_no_coordinates_is_refused(self):
        turned = numpy.eye(4)[[1, 0, 2, 3]]
        texture, = vdblic.advect(FLOW, refine=2)
        for call, words in (
                (vdblic.Grid(FLOW, transform=turned).to_xarray, "the axes of the grid 'density' are turned"),
                (vdblic.Grid(FLOW, staggered=True).to_xarray, "the grid 'density' is staggered"),
                (texture.to_xarray, "the voxels of 'density' and 'magnitude' differ: .*scalars=\"texture\"")):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                call()


class Layouts(ToolTest):
    def test_any_order_of_axes_gives_the_same_textures(self):
        expected = list(vdblic.advect([FLOW] * 3))
        flow = {"": FLOW, "t": numpy.stack([FLOW] * 3)}
        for layout, order, time in (
                ("zyx", "zyxc", ""), ("xyz", "xyzc", ""), ("czyx", "czyx", ""), ("yxcz", "yxcz", ""), ("tzyx", "zyxc", ""),
                ("tzyx", "tzyxc", "t"), ("txyz", "txyzc", "t"), ("tczyx", "tczyx", "t"), ("xyzt", "xyztc", "t")):
            values = flow[time].transpose([f"{time}xyzc".index(axis) for axis in order])
            textures = list(vdblic.advect(values if time else [values] * 3, layout=layout))
            with self.subTest(layout=layout, order=order):
                self.assertEqual(len(textures), 3)
                numpy.testing.assert_array_equal(textures[-1]["density"].values, expected[-1]["density"].values)

    def test_an_order_that_nothing_tells_is_refused(self):
        for data, layout, words in (
                (numpy.stack([FLOW] * 2), None, r"nothing tells the order of the axes of an array of the shape \(2, 12, 10, 8, 3\); "
                                                "say it: layout='txyzc' or layout='tzyxc'"),
                ([FLOW.transpose(3, 0, 1, 2)], None, "frame 1: .* is no field; say it: layout='cxyz' or layout='czyx'"),
                ([FLOW], "cxyz", "frame 1: .* is no field in the layout 'cxyz'"),
                (numpy.stack([FLOW] * 2), "zyx", "more axes than the layout 'zyx'"),
                ([FLOW], "zyxx", "`layout` cannot be 'zyxx'; it is letters of t, c, x, y and z, each once"),
                ([FLOW], "zy", "`layout` cannot be 'zy'"), ([FLOW], 3, "`layout` cannot be 3")):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                list(vdblic.advect(data, layout=layout))

    def test_arrays_by_name_are_written(self):
        vdblic.write(self.folder / "a.vdb", {"velocity": FLOW.transpose(2, 1, 0, 3), "p": FLOW[..., 0].T}, {"frame": 2},
                     voxel_size=(1, 2, 3), layout="zyx")
        volume = vdblic.read(self.folder / "a.vdb")
        self.assertEqual((list(volume), volume.frame), (["velocity", "p"], 2))
        numpy.testing.assert_array_equal(volume["velocity"], FLOW)
        numpy.testing.assert_array_equal(volume["p"], FLOW[..., 0])
        numpy.testing.assert_array_equal(volume["p"].voxel_size, (1, 2, 3))
        parts = dict(zip("uvw", numpy.moveaxis(FLOW, 3, 0)))
        expected, = vdblic.advect(FLOW)
        texture, = vdblic.advect(parts)
        numpy.testing.assert_array_equal(texture["density"], expected["density"])
        with self.assertRaisesRegex(ValueError, "^'p': an array of the shape"):
            vdblic.write(self.folder / "b.vdb", {"p": FLOW[0, 0]})
        self.assertEqual(self.files(), ["a.vdb"])


class Examples(unittest.TestCase):
    def test_examples_of_docstrings(self):
        ran = 0
        for path in sorted(MODULE.glob("vdblic/*.py")):
            module = vdblic if path.stem == "__init__" else importlib.import_module(f"vdblic.{path.stem}")
            failed, tried = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
            self.assertEqual(failed, 0, path.stem)
            ran += tried
        self.assertGreater(ran, 5)


if __name__ == "__main__":
    unittest.main()
