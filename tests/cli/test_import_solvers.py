"""vdblic_import: AMReX's plot files and Plot3D, against VTK's own probe and a flow that is known everywhere."""

import itertools
import shutil
import unittest

import numpy
import pyopenvdb as vdb
from vtkmodules.vtkIOAMR import vtkAMReXGridReader
from vtkmodules.vtkIOParallel import vtkMultiBlockPLOT3DReader

import flows
import solver_flows
import truth
from imports import ImportHere, velocity_of

NAMES = "density", "x_velocity", "y_velocity", "z_velocity"


class Amrex(ImportHere):
    COARSE = [((0, 0, 0), (7, 7, 7)), ((8, 0, 0), (15, 7, 7))]
    FINE = [((4, 4, 4), (11, 11, 11))]

    def write(self, name="plt00010", levels=None, **options):
        """The flow; under the finer cells the coarse ones hold something else."""
        def values(at, level):
            covered = ((at > 2) & (at < 6)).all(axis=-1) & (level == 0)
            return numpy.concatenate([at[..., :1], flows.flow(at) + 100 * covered[..., None]], axis=-1)

        solver_flows.write_amrex(self.folder / name, levels or [self.COARSE, self.FINE], NAMES, values, **options)

    def test_levels(self):
        self.write()
        path, = self.imports("plt00010", "-o", "v.vdb", "--size", 32, 16, 16)
        self.assertEqual(vdb.readMetadata(str(path))["time"], 0.25)
        found, active, at = velocity_of(path)
        self.assertTrue(active.all())
        fine = ((at > 2.5) & (at < 5.5)).all(axis=-1)
        numpy.testing.assert_allclose(found[fine], flows.flow(at)[fine], atol=1e-5)
        self.assertLess(numpy.abs(found - flows.flow(at)).max(), 1.5)  # nothing of the hidden 100

    def test_one_level_against_vtk(self):
        self.write(levels=[self.COARSE])
        path, = self.imports("plt00010", "-o", "v.vdb")
        reader = vtkAMReXGridReader()
        reader.SetFileName(str(self.folder / "plt00010"))
        reader.UpdateInformation()
        reader.GetCellDataArraySelection().EnableAllArrays()
        reader.Update()
        read = vdb.read(str(path), "velocity").getConstAccessor()
        cells = [reader.GetOutput().GetDataSet(0, i) for i in range(2)]
        for _ in range(truth.COUNT):
            block = cells[self.random.integers(2)]
            cell = int(self.random.integers(block.GetNumberOfCells()))
            bounds = numpy.array(block.GetCell(cell).GetBounds()).reshape(3, 2).mean(axis=1)
            value = read.getValue(tuple(int(i) for i in numpy.floor(bounds)))
            expected = [block.GetCellData().GetArray(name).GetTuple1(cell) for name in NAMES[1:]]
            numpy.testing.assert_allclose(value, expected, rtol=1e-6)

    def test_folders_by_standard_input(self):
        for number in 3, 4:
            self.write(f"plt{number:05}", time=number / 2)
        paths = self.imports("-", "-o", "v.%04d.vdb", "--size", 16, 8, 8, stdin="plt00003\nplt00004\n")
        self.assertEqual([(path.name, vdb.readMetadata(str(path))["time"]) for path in paths],
                         [("v.0003.vdb", 1.5), ("v.0004.vdb", 2.0)])

    def test_folders_by_a_pattern(self):
        """In the order of their numbers, and so of their times."""
        for number in 9, 100000, 20, 10:
            self.write(f"plt{number:05}", [self.COARSE], time=number / 2)
        self.write("plt00010.old.0003", [self.COARSE])  # as AMReX renames what it replaces
        (self.folder / "plt11").write_bytes(b"no folder")
        for options, numbers in ((), (9, 10, 20, 100000)), (("--frames", "10-20x10"), (10, 20)):
            for pattern in "plt*", "./plt*", self.folder / "plt*":
                with self.subTest(pattern, options=options):
                    paths = self.imports(pattern, "-o", "v.%04d.vdb", *options)
                    self.assertEqual([(path.name, vdb.readMetadata(str(path))["time"]) for path in paths],
                                     [(f"v.{number:04}.vdb", number / 2) for number in numbers])
        self.assertIn("frame 15 is missing", self.refuses(3, "plt*", "-o", "v.%04d.vdb", "--frames", "15"))
        self.write("plt010", [self.COARSE])
        self.assertRegex(self.refuses(3, "plt*", "-o", "v.%04d.vdb"), "its number is that of .*; move one of the two away")
        self.assertIn("'*' is no frame field", self.refuses(2, "other*", "-o", "v.%04d.vdb"))

    def test_damage(self):
        for part in "Header", "Level_0/Cell_H", "Level_1/Cell_H", "Level_0/Cell_D_00000", "Level_1/Cell_D_00000":
            self.write("plt00010")
            whole = (self.folder / "plt00010" / part).read_bytes()
            for share in (0.02, 0.15) if part.endswith("_H") else (0.02, 0.5, 0.95):  # lists of extremes are not needed
                (self.folder / "plt00010" / part).write_bytes(whole[:int(share * len(whole))])
                with self.subTest(part, share=share):
                    self.assertIn("cannot be read", self.refuses(3, "plt00010", "-o", "v.vdb"))
            shutil.rmtree(self.folder / "plt00010")
        self.write()
        text = (self.folder / "plt00010/Header").read_text()
        (self.folder / "plt00010/Header").write_text(text.replace("\n0\n0\n", "\n1\n0\n"), encoding="ascii")
        self.assertIn("its coordinates are cylindrical or spherical", self.refuses(3, "plt00010", "-o", "v.vdb"))

    def setUp(self):
        super().setUp()
        self.random = numpy.random.default_rng(5)


class Plot3d(ImportHere):
    def write(self, flow=flows.flow, **form):
        x, y, z = flows.axes()
        blocks = [flows.grid_positions(x, y, z), flows.grid_positions(x + x[-1] - x[0], y, z)]
        blocks = blocks if form.get("many", True) else blocks[:1]
        solver_flows.write_plot3d(self.folder / "a.xyz", self.folder / "a.q", blocks, flow, **form)

    def test_forms(self):
        for order, records, many, width in itertools.product("<>", (False, True), (True, False), (4, 8)):
            with self.subTest(order=order, records=records, many=many, width=width):
                self.write(order=order, records=records, many=many, width=width)
                path, = self.imports("a.q", "-o", "v.vdb", "--size", 20, 10, 8)
                self.assertTrue(self.assert_flow(path, flows.flow).all())

    def test_against_vtk(self):
        self.write(lambda at: numpy.sin(40 * at))
        path, = self.imports("a.q", "-o", "v.vdb", "--size", 24, 12, 10)
        reader = vtkMultiBlockPLOT3DReader()
        reader.AutoDetectFormatOn()
        reader.SetXYZFileName(str(self.folder / "a.xyz"))
        reader.SetQFileName(str(self.folder / "a.q"))
        reader.SetVectorFunctionNumber(200)
        reader.Update()
        at, found, _ = truth.random_voxels(path)
        for block in map(reader.GetOutput().GetBlock, range(2)):
            values, valid = flows.probed(block, at, "Velocity")
            self.assertGreater(valid.sum(), 300)
            numpy.testing.assert_allclose(found[valid], values[valid], atol=1e-5)

    def test_marks(self):
        """Points that the grid marks by 0 are none of the flow; those of other blocks, below 0, are."""
        self.write(many=False, marks=lambda at: numpy.where(at[..., 0] < flows.axes()[0][2], 0, -2))
        path, = self.imports("a.q", "-o", "v.vdb", "--size", 20, 10, 8)
        _, _, at = velocity_of(path)
        self.assertGreater(at[..., 0].min(), flows.axes()[0][2] - 0.1)
        self.assert_flow(path, flows.flow)

    def test_the_grid_is_told(self):
        self.write()
        for number in 1, 2:
            shutil.copy(self.folder / "a.q", self.folder / f"s.{number}.q")
        (self.folder / "a.xyz").rename(self.folder / "grid.xyz")
        self.assertIn("a.q: its grid is not beside it in a.xyz; name it: vdblic_import a.q GRID.xyz",
                      self.refuses(3, "a.q", "-o", "v.vdb"))
        self.assertIn("grid.xyz: Plot3D's grid without the solution", self.refuses(3, "grid.xyz", "-o", "v.vdb"))
        for path in self.imports("s.%d.q", "grid.xyz", "-o", "v.%d.vdb", "--size", 20, 10, 8):
            self.assert_flow(path, flows.flow)

    def test_damage(self):
        self.write()
        for name in "a.xyz", "a.q":
            whole = self.contents(name)
            for size in 0, 3, 10, 40, len(whole) // 2, len(whole) - 1, len(whole) - 200:
                (self.folder / name).write_bytes(whole[:size])
                self.assertIn("a.q: ", self.refuses(3, "a.q", "-o", "v.vdb"))
            (self.folder / name).write_bytes(whole)
        self.write(text=True)
        self.assertIn("a.q: the text of Plot3D does not tell the order of its numbers", self.refuses(3, "a.q", "-o", "v.vdb"))


if __name__ == "__main__":
    unittest.main()
