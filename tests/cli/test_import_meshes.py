"""vdblic_import: cases as CGNS's library and OpenFOAM write them, and the voxels of meshes that nobody chose."""

import os
import pathlib
import re
import shutil
import struct
import subprocess
import unittest

import numpy
import pyopenvdb as vdb
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkCellLocator, vtkRectilinearGrid
from vtkmodules.vtkFiltersCore import vtkAppendFilter
from vtkmodules.vtkIOParallel import vtkPOpenFOAMReader
from vtkmodules.vtkParallelCore import vtkDummyController

import cgns
import flows
from imports import ImportTest, velocity_of
from support import BIN, SOURCE

FOAM = pathlib.Path("/usr/share/openfoam")


class Cgns(ImportTest):
    def test_every_version_of_adf_is_known(self):
        """By files of zeros behind a header, whose end is in another form in version A."""
        look = (
            "from vdblic_convert.errors import InputError\n"
            "from vdblic_convert.readers.whole_files import check_whole\n"
            "try: print(check_whole('f.cgns'))\n"
            "except InputError as error: print(error)"
        )
        environment = os.environ | {"PYTHONPATH": f"{SOURCE / 'tools/python'}:{BIN.parent / 'python'}"}
        told = lambda: subprocess.run(
            ["/usr/bin/python3", "-B", "-c", look],
            cwd=self.folder, env=environment, text=True, capture_output=True, check=True,
        ).stdout.strip()
        for version, end in (b"A02011>", b"000000010020"), (b"B02012>", struct.pack("<QI", 1, 32)):
            header = b"@(#)ADF Database Version " + version + bytes(0x64 - 32) + b"L" + bytes(0x92 - 0x65) + end
            path = self.folder / "f.cgns"
            path.write_bytes(header.ljust(4096 + 32, b"\0"))
            self.assertEqual(told(), "ADF")
            path.write_bytes(header.ljust(4096 + 31, b"\0"))
            self.assertIn("f.cgns: it ends too early: after 4127 of the 4128", told())

    @unittest.skipUnless(cgns.library(), "VTK has no library of CGNS")
    def test_both_forms(self):
        for form in cgns.FORMS:
            with self.subTest(form):
                cgns.write(self.folder / "box.cgns", form)
                path, = self.imports("box.cgns", "-o", "v.vdb")
                self.assert_flow(path, flows.flow, (9, 7, 5))
                path.unlink()
                whole = self.contents("box.cgns")
                for share in 0.003, 0.02, 0.5:
                    (self.folder / "box.cgns").write_bytes(whole[:int(share * len(whole))])
                    message = self.refuses(3, "box.cgns", "-o", "v.vdb", timeout=20)
                    self.assertRegex(message, "box.cgns: .*(ends too early|neither of the forms)")


class Regions(ImportTest):
    def test_cells_of_a_region(self):
        """A mesh and its fields in folders of a region."""
        flows.write_foam(self.folder / "case", [0.0])
        for folder in "constant", "0":
            inner = self.folder / "case" / folder / "air"
            inner.mkdir()
            for entry in (self.folder / "case" / folder).iterdir():
                if entry != inner:
                    entry.rename(inner / entry.name)
        path, = self.imports("case", "-o", "v.%04d.vdb", "--size", 8, 6, 4)
        self.assert_flow(path, flows.flow, (8, 6, 4))


    def test_regions_are_told(self):
        """Cells of air and a wall beside it, which has no velocity."""
        for region, at in ("air", 0), ("wall", 2):
            flows.write_foam(self.folder / region, [0.0])
            for folder in "constant", "0":
                (self.folder / "case" / folder).mkdir(parents=True, exist_ok=True)
                (self.folder / region / folder).rename(self.folder / "case" / folder / region)
            if at:
                (self.folder / "case/0/wall/U").unlink()
                head = flows.FOAM_HEADER.format(kind="volScalarField", place="0", name="T")
                (self.folder / "case/0/wall/T").write_text(
                    head + "dimensions [0 0 0 1 0 0 0]; internalField uniform 300; boundaryField{}\n", encoding="ascii")
                points = self.folder / "case/constant/wall/polyMesh/points"
                moved = re.sub(r"\((\S+) (\S+ \S+\))", lambda found: f"({float(found[1]) + at} {found[2]}", points.read_text())
                points.write_text(moved, encoding="ascii")
        (self.folder / "air/system").rename(self.folder / "case/system")
        done = self.run_tool("vdblic_import", "case", "-o", "v.vdb", "--array", "U")
        self.assertIn("case: the regions that have the velocity are one flow, of air, wall", done.stderr)
        self.assert_flow(self.folder / "v.vdb", flows.flow, (8, 6, 4))

    def test_times_that_some_folders_lack(self):
        flows.write_foam(self.folder / "case", [0.0, 0.5, 1.0], 2)
        shutil.rmtree(self.folder / "case/processor0/1")
        done = self.run_tool("vdblic_import", "case", "-o", "v.%d.vdb", "--size", 8, 6, 4)
        self.assertIn("case: processor0 lacks the times 1, which are left out", done.stderr)
        self.assertEqual(len(done.stdout.split()), 2)
        flows.write_foam(self.folder / "whole", [0.0, 0.5])
        for folder in "constant", "0", "0.5":
            (self.folder / "whole" / folder).rename(self.folder / "case" / folder)
        done = self.run_tool("vdblic_import", "case", "-o", "w.%d.vdb", "--size", 8, 6, 4)
        self.assertIn("case: the times 1 are in processor folders only and are left out; reconstructPar puts", done.stderr)
        self.assertIn("mean flow is (1.55, 0.8, 0.85), 27 degrees from x towards y, with a mean speed of 2.23 m/s; from 0 s "
                      "on; z is up", done.stderr)
        self.assert_flow(self.folder / "w.2.vdb", lambda at: flows.flow(at, 0.5), (8, 6, 4))


    def test_two_files_of_one_name(self):
        """VTK goes by what a file says of itself, and would take the last one."""
        flows.write_foam(self.folder / "case", [0.0])
        shutil.copy(self.folder / "case/0/U", self.folder / "case/0/Uuniform")
        self.assertIn("case/0/Uuniform: it says that it is U, as U does; move one of them away",
                      self.refuses(3, "case", "-o", "v.vdb"))


class Collated(ImportTest):
    def test_the_layout(self):
        flows.write_foam(self.folder / "case", [0.0])
        for part in "0", "0.5", "constant":
            (self.folder / "case/processors2" / part).mkdir(parents=True)
        self.assertIn("case: VTK cannot read the collated files in processors2; put the case together first: "
                      "reconstructPar -case case", self.refuses(3, "case", "-o", "v.%04d.vdb"))

    @unittest.skipUnless(FOAM.is_dir() and shutil.which("icoFoam"), "OpenFOAM is not installed")
    def test_a_real_case(self):
        self.write_cavity()
        self.run_foam("blockMesh")
        self.run_foam("icoFoam")
        paths = self.imports("cavity", "-o", "v.%04d.vdb")
        self.assertEqual([vdb.readMetadata(str(path))["time"] for path in paths], [0, 0.01, 0.02])
        values, active, positions = velocity_of(paths[-1])
        self.assertEqual((active.shape, active.all()), ((20, 20, 1), True))
        numpy.testing.assert_allclose(values, self.cells_at(positions, 0.02), atol=1e-6)
        self.assertGreater(numpy.abs(values).max(), 0.3)
        for time in "0.01", "0.02":
            shutil.rmtree(self.folder / "cavity" / time)
        self.run_foam("decomposePar", "-fileHandler", "collated")
        self.assertIn("reconstructPar -case cavity", self.refuses(3, "cavity", "-o", "w.%04d.vdb"))

    def run_foam(self, tool, *arguments):
        done = subprocess.run([tool, *arguments], cwd=self.folder / "cavity", text=True, capture_output=True,
                              env=os.environ | {"WM_PROJECT_DIR": str(FOAM)}, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def cells_at(self, positions, time):
        """The velocity of the cells around positions, as VTK reads them."""
        reader = vtkPOpenFOAMReader()
        reader.SetController(vtkDummyController())
        reader.SetFileName(str(self.folder / "cavity/system/controlDict"))
        reader.CreateCellToPointOff()
        reader.UpdateTimeStep(time)
        mesh = reader.GetOutput().GetBlock(0)
        locator = vtkCellLocator()
        locator.SetDataSet(mesh)
        locator.BuildLocator()
        cells = [locator.FindCell(at) for at in positions.reshape(-1, 3)]
        return vtk_to_numpy(mesh.GetCellData().GetArray("U"))[cells].reshape(positions.shape)

    def write_cavity(self):
        for name, kind, text in (
                ("system/controlDict", "dictionary", "startFrom startTime; startTime 0; stopAt endTime; endTime 0.02; "
                 "deltaT 0.005; writeControl timeStep; writeInterval 2; writePrecision 8;"),
                ("system/blockMeshDict", "dictionary", "scale 0.1; vertices ((0 0 0)(1 0 0)(1 1 0)(0 1 0)(0 0 0.1)"
                 "(1 0 0.1)(1 1 0.1)(0 1 0.1)); blocks (hex (0 1 2 3 4 5 6 7) (20 20 1) simpleGrading (1 1 1)); "
                 "edges (); boundary (lid {type wall; faces ((3 7 6 2));} walls {type wall; faces ((0 4 7 3)"
                 "(2 6 5 1)(1 5 4 0));} sides {type empty; faces ((0 3 2 1)(4 5 6 7));});"),
                ("system/fvSchemes", "dictionary", "ddtSchemes{default Euler;} gradSchemes{default Gauss linear;} "
                 "divSchemes{default Gauss linear;} laplacianSchemes{default Gauss linear orthogonal;} "
                 "interpolationSchemes{default linear;} snGradSchemes{default orthogonal;}"),
                ("system/fvSolution", "dictionary", "solvers{\"p.*\"{solver PCG; preconditioner DIC; tolerance 1e-6; "
                 "relTol 0;} U{solver smoothSolver; smoother symGaussSeidel; tolerance 1e-5; relTol 0;}} "
                 "PISO{nCorrectors 2; pRefCell 0; pRefValue 0;}"),
                ("system/decomposeParDict", "dictionary", "numberOfSubdomains 2; method simple; coeffs{n (2 1 1);}"),
                ("constant/transportProperties", "dictionary", "nu 0.01;"),
                ("0/U", "volVectorField", "dimensions [0 1 -1 0 0 0 0]; internalField uniform (0 0 0); boundaryField"
                 "{lid{type fixedValue; value uniform (1 0 0);} walls{type noSlip;} sides{type empty;}}"),
                ("0/p", "volScalarField", "dimensions [0 2 -2 0 0 0 0]; internalField uniform 0; boundaryField"
                 "{lid{type zeroGradient;} walls{type zeroGradient;} sides{type empty;}}")):
            path = self.folder / "cavity" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            head = flows.FOAM_HEADER.format(kind=kind, place=path.parent.name, name=path.name)
            path.write_text(head + text + "\n", encoding="utf-8")


def graded(edges):
    """Hexahedra between edges along x, y and z, as an unstructured grid; the grid of their edges."""
    grid = vtkRectilinearGrid()
    grid.SetDimensions(*map(len, edges))
    for axis, set_coordinates in zip(edges, (grid.SetXCoordinates, grid.SetYCoordinates, grid.SetZCoordinates)):
        set_coordinates(flows.numpy_to_vtk(axis, deep=True))
    flows.add(grid.GetPointData(), "U", flows.flow(flows.grid_positions(*edges)))
    append = vtkAppendFilter()
    append.AddInputData(grid)
    append.Update()
    return append.GetOutput(), grid


class Voxels(ImportTest):
    def test_one_layer_of_cells(self):
        for sizes in (20, 20, 1), (12, 1, 7), (1, 1, 5):
            name = "x".join(map(str, sizes))
            flows.write_foam(self.folder / name, [0.0], sizes=sizes)
            path, = self.imports(name, "-o", f"{name}.vdb")
            self.assert_flow(path, flows.flow, sizes)

    def test_every_fine_cell_has_a_voxel(self):
        """Three quarters of the cells are fine, in a corner of a box that coarse ones fill."""
        edges = [numpy.concatenate([numpy.linspace(0, 1, 21), numpy.linspace(1.5, 3, 4)])] * 3
        mesh, _ = graded(edges)
        flows.write_vtk(mesh, self.folder / "m.vtu")
        done = self.run_tool("vdblic_import", "m.vtu", "-o", "m.vdb")
        self.assertEqual((done.returncode, "warning" in done.stderr), (0, False), done.stderr)
        values, active, positions = velocity_of(self.folder / "m.vdb")
        probed, valid = flows.probed(mesh, positions, "U")
        numpy.testing.assert_array_equal(active.ravel(), valid)
        numpy.testing.assert_allclose(values.reshape(-1, 3)[valid], probed[valid], atol=1e-5)
        cells = numpy.stack([numpy.searchsorted(edge, positions[..., i]) for i, edge in enumerate(edges)], axis=-1)
        self.assertEqual(len(numpy.unique(cells[active].reshape(-1, 3), axis=0)), 24**3)

    def test_cells_without_a_voxel_are_told(self):
        _, grid = graded([numpy.geomspace(1, 1000, 15), numpy.linspace(0, 3, 4), numpy.linspace(0, 3, 4)])
        flows.write_vtk(grid, self.folder / "m.vtr")
        done = self.run_tool("vdblic_import", "m.vtr", "-o", "m.vdb")
        self.assertRegex(done.stderr, r"warning: only \d+ % of the cells have a voxel in them, because they differ in size")
        done = self.run_tool("vdblic_import", "m.vtr", "-o", "m.vdb", "--size", 15, 3, 3)
        self.assertNotIn("warning", done.stderr)

    def test_velocity_of_exodus(self):
        image = flows.image()
        for name in "DISPL", "VEL", "ACCL", "C":
            flows.add(image.GetPointData(), name, flows.flow(flows.grid_positions(*flows.axes()),
                                                             1 if name == "VEL" else 0))
        image.GetPointData().RemoveArray("U")
        flows.write_vtk(image, self.folder / "v.vti")
        path, = self.imports("v.vti", "-o", "v.vdb")
        self.assert_flow(path, lambda at: flows.flow(at, 1))
        for name in "VEL", "ACCL", "DISPL":
            image.GetPointData().RemoveArray(name)
        flows.write_vtk(image, self.folder / "v.vti")
        self.assertIn("no array is known as a velocity", self.refuses(3, "v.vti", "-o", "v.vdb"))


if __name__ == "__main__":
    unittest.main()
