"""vdblic_import: flows in blocks, levels and pieces of VTK's files, and meshes that move."""

import re
import unittest

import numpy
import pyopenvdb as vdb
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkMultiBlockDataSet, vtkStructuredGrid
from vtkmodules.vtkFiltersCore import vtkAppendFilter
from vtkmodules.vtkFiltersGeneral import vtkDataSetTriangleFilter
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

import flows
from imports import ImportHere, velocity_of

REFINED = 8  # VTK's flag of a cell in whose place there are finer ones


def box(low, high, spacing, cells, values=flows.flow):
    """An image between two corners, with the flow, or other values, at its points or in its cells."""
    image, low = vtkImageData(), numpy.array(low, float)
    size = numpy.round((numpy.array(high) - low) / spacing).astype(int) + 1
    image.SetDimensions(*size)
    image.SetOrigin(*low)
    image.SetSpacing(*[spacing] * 3)
    first, count = (low + spacing / 2, size - 1) if cells else (low, size)
    at = flows.grid_positions(*(a + spacing * numpy.arange(n) for a, n in zip(first, count)))
    flows.add(image.GetCellData() if cells else image.GetPointData(), "U", values(at))
    return image, at


def multi_block(*blocks):
    whole = vtkMultiBlockDataSet()
    for i, block in enumerate(blocks):
        whole.SetBlock(i, block)
    return whole


def wrong(at):
    return flows.flow(at) + 100


class Blocks(ImportHere):
    def test_images_side_by_side_keep_their_voxels(self):
        random = numpy.random.default_rng(3)
        for cells in False, True:
            kept = {}

            def values(at, kept=kept):
                found = random.normal(size=at.shape)
                kept.update(zip(map(tuple, numpy.round(at.reshape(-1, 3), 6)), found.reshape(-1, 3)))
                return found

            blocks = [box(*ends, 0.25, cells, values=values)[0] for ends in (
                ((1, 2, 3), (2, 3, 4)), ((2 + (not cells) / 4, 2, 3), (4, 3, 4)), ((1, 3 + (not cells) / 4, 3), (2, 4, 4)))]
            flows.write_vtk(multi_block(*blocks), self.folder / "m.vtm")
            path, = self.imports("m.vtm", "-o", "v.vdb")
            found, active, at = velocity_of(path)
            self.assertEqual(active.sum(), len(kept))
            for value, place in zip(found[active], at[active]):
                numpy.testing.assert_allclose(value, kept[tuple(numpy.round(place, 6))], rtol=1e-6)

    def test_coarse_cells_under_finer_ones_do_not_count(self):
        """In a multi-block by VTK's flags; in an overlapping hierarchy by its boxes."""
        coarse, at = box((0, 0, 0), (4, 4, 4), 1, True, values=lambda at: numpy.where(
            (at < 2).all(axis=-1)[..., None], wrong(at), flows.flow(at)))
        fine, _ = box((0, 0, 0), (2, 2, 2), 0.5, True)
        flows.add(coarse.GetCellData(), "vtkGhostType", numpy.where((at < 2).all(axis=-1), REFINED, 0).astype(numpy.uint8))
        flows.write_vtk(multi_block(coarse, fine), self.folder / "m.vtm")
        coarse.GetCellData().RemoveArray("vtkGhostType")
        text = ""
        for level, (spacing, grid) in enumerate(((1, coarse), (0.5, fine))):
            flows.write_vtk(grid, self.folder / f"level{level}.vti")
            text += (f'<Block level="{level}" spacing="{spacing} {spacing} {spacing}">'
                     f'<DataSet index="0" amr_box="0 3 0 3 0 3" file="level{level}.vti"/></Block>')
        (self.folder / "m.vthb").write_text(
            '<VTKFile type="vtkOverlappingAMR" version="1.1"><vtkOverlappingAMR origin="0 0 0" grid_description="XYZ">'
            f"{text}</vtkOverlappingAMR></VTKFile>", encoding="ascii")
        for name in "m.vtm", "m.vthb":
            path, = self.imports(name, "-o", "v.vdb", "--size", 8, 8, 8)
            found, active, places = velocity_of(path)
            self.assertTrue(active.all())
            inner = (places < 2).all(axis=-1)
            numpy.testing.assert_allclose(found[inner], flows.flow(places)[inner], atol=0.3)
            fine = (places < 1.5).all(axis=-1) & (places > 0.5).all(axis=-1)
            numpy.testing.assert_allclose(found[fine], flows.flow(places)[fine], atol=1e-5)

    def test_levels_of_an_older_form(self):
        """VTK would end the process."""
        (self.folder / "old.vthb").write_text(
            '<VTKFile type="vtkHierarchicalBoxDataSet" version="1.0"><vtkHierarchicalBoxDataSet>'
            '<Block level="0" refinement_ratio="2"><DataSet index="0" amr_box="0 1 0 1 0 1" file="a.vti"/></Block>'
            '</vtkHierarchicalBoxDataSet></VTKFile>', encoding="ascii")
        self.assertIn("old.vthb: VTK cannot read levels in the form of 1.0", self.refuses(3, "old.vthb", "-o", "v.vdb"))

    def test_an_array_that_a_piece_lacks(self):
        grid = flows.tetrahedra()
        flows.write_vtk(grid, self.folder / "a.vtu")
        pieces = lambda names: (
            '<VTKFile type="PUnstructuredGrid" version="0.1"><PUnstructuredGrid GhostLevel="0"><PPointData>'
            '<PDataArray type="Float64" Name="U" NumberOfComponents="3"/><PDataArray type="Float64" Name="p"/></PPointData>'
            '<PPoints><PDataArray type="Float32" NumberOfComponents="3"/></PPoints>'
            + "".join(f'<Piece Source="{name}"/>' for name in names) + "</PUnstructuredGrid></VTKFile>")
        (self.folder / "a.pvtu").write_text(pieces(["a.vtu", "b.vtu"]), encoding="ascii")
        grid.GetPointData().RemoveArray("p")
        flows.write_vtk(grid, self.folder / "b.vtu")
        done = self.run_tool("vdblic_import", "a.pvtu", "-o", "v.vdb")
        self.assertIn("a piece lacks the array p, which is left out", done.stderr)
        self.assert_flow(self.folder / "v.vdb", flows.flow)
        grid.GetPointData().RemoveArray("U")
        flows.add(grid.GetPointData(), "p", numpy.zeros((1, 1, grid.GetNumberOfPoints())))
        flows.write_vtk(grid, self.folder / "b.vtu")
        done = self.run_tool("vdblic_import", "a.pvtu", "-o", "w.vdb")
        self.assertEqual(done.returncode, 3)
        self.assertIn("a piece lacks the array U, which is left out", done.stderr)
        self.assertIn("no array is known as a velocity", done.stderr)


    def test_cells_in_one_place_are_taken_in_their_order(self):
        """Not in that of threads: a voxel has the value of the last cell around it."""
        append = vtkAppendFilter()
        for add in 100, 0:
            image, _ = box((0, 0, 0), (1, 1, 1), 1 / 16, False, values=lambda at, add=add: flows.flow(at) + add)
            split = vtkDataSetTriangleFilter()
            split.SetInputData(image)
            split.Update()
            append.AddInputData(split.GetOutput())
        append.Update()
        flows.write_vtk(append.GetOutput(), self.folder / "twice.vtu")
        path, = self.imports("twice.vtu", "-o", "v.vdb", "--size", 32, 32, 32)
        self.assertTrue(self.assert_flow(path, flows.flow).all())


class Planes(ImportHere):
    def test_quadrilaterals_are_not_cut_into_triangles(self):
        """A bilinear flow is exact in rectangles; with the flow in cells, a voxel is a cell."""
        bilinear = lambda at: numpy.stack([at[..., 0] * at[..., 1], at[..., 0] - at[..., 1], 0 * at[..., 0]], axis=-1)
        grid, points = vtkStructuredGrid(), vtkPoints()
        x, y = numpy.linspace(0, 3, 7) ** 2, numpy.linspace(-1, 1, 5)
        at = flows.grid_positions(x, y, numpy.array([1000000.5]))
        points.SetData(numpy_to_vtk(at.reshape(-1, 3), deep=True))
        grid.SetDimensions(7, 5, 1)
        grid.SetPoints(points)
        flows.add(grid.GetPointData(), "U", bilinear(at))
        flows.write_vtk(grid, self.folder / "a.vts")
        surface = vtkGeometryFilter()
        surface.SetInputData(grid)
        surface.Update()
        flows.write_vtk(surface.GetOutput(), self.folder / "a.vtp")
        for name in "a.vts", "a.vtp":
            path, = self.imports(name, "-o", "v.vdb", "--size", 30, 20, 1)
            self.assertTrue(self.assert_flow(path, bilinear).all())


class Moving(ImportHere):
    def moved(self, by):
        grid = flows.tetrahedra()
        places = flows.vtkPoints()
        places.SetData(numpy_to_vtk(numpy.array([grid.GetPoint(i) for i in range(grid.GetNumberOfPoints())]) + [by, 0, 0],
                                    deep=True))
        grid.SetPoints(places)
        grid.GetFieldData().RemoveArray("TimeValue")
        return grid

    def test_a_mesh_that_leaves_the_first_box(self):
        """Every frame has all of its flow, on the voxels of the first one."""
        for i, by in enumerate((0, 0.5, -0.25), 1):
            flows.write_vtk(self.moved(by), self.folder / f"m.{i}.vtu")
        done = self.run_tool("vdblic_import", "m.%d.vtu", "-o", "v.%d.vdb", "--size", 20, 10, 5)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(re.findall("frame 2 reaches beyond the box of the first step", done.stderr)), 1)
        first = vdb.read(str(self.folder / "v.1.vdb"), "velocity").transform
        for i, by in enumerate((0, 0.5, -0.25), 1):
            path = self.folder / f"v.{i}.vdb"
            active = self.assert_flow(path, lambda at, by=by: flows.flow(at - [by, 0, 0]))
            self.assertAlmostEqual(active.sum(), 1000, delta=60)
            self.assertEqual(vdb.read(str(path), "velocity").transform, first)
        self.imports("m.%d.vtu", "-o", "w.%d.vdb", "--size", 20, 10, 5, "--bounds", 1, -1, 0, 3, 1, 1)
        self.assertLess(velocity_of(self.folder / "w.2.vdb")[1].sum(), 800)
        flows.write_vtk(self.moved(1e30), self.folder / "m.4.vtu")
        done = self.run_tool("vdblic_import", "m.%d.vtu", "-o", "y.%d.vdb", "--size", 20, 10, 5, "--frames", 4)
        self.assertEqual(done.returncode, 2)
        self.assertIn("m.4.vtu: frame 4: ", done.stderr)
        last, = self.imports("m.%d.vtu", "-o", "x.%d.vdb", "--size", 20, 10, 5, "--frames", 3)
        self.assertEqual(self.contents("x.3.vdb"), self.contents("v.3.vdb"))

    def test_cases_that_move(self):
        """The points of OpenFOAM in the folders of times; the geometry of EnSight a file for each time."""
        places = dict(zip((0.0, 0.5, 1.0), (0, 0.5, -0.25)))
        flows.write_foam(self.folder / "case", places)
        points = (self.folder / "case/constant/polyMesh/points").read_text()
        flows.write_ensight(self.folder, places)
        geometry = (self.folder / "flow.geo").read_text().split("\n")
        for i, (time, by) in enumerate(places.items()):
            (self.folder / f"case/{time:g}/polyMesh").mkdir()
            (self.folder / f"case/{time:g}/polyMesh/points").write_text(
                re.sub(r"\((\S+) (\S+ \S+\))", lambda found, by=by: f"({float(found[1]) + by} {found[2]}", points),
                encoding="ascii")
            at = flows.grid_positions(*flows.axes()).reshape(-1, 3) + [by, 0, 0]
            column = [f"{value:12.5e}" for value in at.T.ravel()]
            (self.folder / f"flow.geo.{i:04}").write_text("\n".join([*geometry[:9], *column, ""]), encoding="ascii")
        case = (self.folder / "flow.case").read_text()
        for words in "", " change_coords_only":
            (self.folder / f"flow{len(words)}.case").write_text(
                case.replace("model: flow.geo", f"model: 1 flow.geo.****{words}"), encoding="ascii")
        for name in "case", "flow0.case", "flow19.case":
            paths = self.imports(name, "-o", "v.%d.vdb")
            for path, (time, by) in zip(paths, places.items(), strict=True):
                active = self.assert_flow(path, lambda at, time=time, by=by: flows.flow(at - [by, 0, 0], time))
                self.assertEqual(active.sum(), 192 if name == "case" else 315)
                path.unlink()


if __name__ == "__main__":
    unittest.main()
