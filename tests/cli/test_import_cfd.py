"""vdblic_import: files of Exodus, VTKHDF, Fluent and Tecplot, and those of other programs that are refused by name."""

import importlib.util
import unittest

import numpy
import pyopenvdb as vdb
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOExodus import vtkExodusIIWriter

import flows
from imports import ImportHere

SIZE = 8, 6, 4


def lines(rows):
    return "\n".join(rows)


class Forms(ImportHere):
    def cut_files_are_refused(self, name, imported=None):
        whole = self.contents(name)
        for share in 0.02, 0.3, 0.6, 0.9, 0.99:
            (self.folder / name).write_bytes(whole[:int(share * len(whole))])
            self.assertRegex(self.refuses(3, imported or name, "-o", "cut.vdb"), f"{name}: .*(ends too early|cannot be read)")

    def test_exodus(self):
        writer = vtkExodusIIWriter()
        writer.SetInputData(flows.tetrahedra())
        writer.SetFileName(str(self.folder / "a.exo"))
        self.assertEqual(writer.Write(), 1)
        path, = self.imports("a.exo", "-o", "v.vdb")
        self.assertTrue(self.assert_flow(path, flows.flow).all())
        self.cut_files_are_refused("a.exo")

    @unittest.skipUnless(importlib.util.find_spec("h5py"), "python3-h5py is not installed")
    def test_vtkhdf(self):
        import h5py  # pylint: disable=import-outside-toplevel

        grid, image = flows.tetrahedra(), flows.image()
        with h5py.File(self.folder / "mesh.vtkhdf", "w") as file:
            root = file.create_group("VTKHDF")
            root.attrs["Version"] = [1, 0]
            root.attrs.create("Type", numpy.string_("UnstructuredGrid"))
            for name, values in (
                    ("NumberOfPoints", [grid.GetNumberOfPoints()]), ("NumberOfCells", [grid.GetNumberOfCells()]),
                    ("NumberOfConnectivityIds", [grid.GetCells().GetNumberOfConnectivityIds()]),
                    ("Connectivity", vtk_to_numpy(grid.GetCells().GetConnectivityArray())),
                    ("Offsets", vtk_to_numpy(grid.GetCells().GetOffsetsArray())),
                    ("Points", vtk_to_numpy(grid.GetPoints().GetData())), ("Types", vtk_to_numpy(grid.GetCellTypesArray())),
                    ("PointData/U", vtk_to_numpy(grid.GetPointData().GetArray("U")))):
                root[name] = values
        with h5py.File(self.folder / "image.vtkhdf", "w") as file:
            root = file.create_group("VTKHDF")
            root.attrs.create("Type", numpy.string_("ImageData"))
            for name, values in (("Version", [1, 0]), ("WholeExtent", image.GetExtent()), ("Origin", image.GetOrigin()),
                                 ("Spacing", image.GetSpacing()), ("Direction", numpy.eye(3).ravel())):
                root.attrs[name] = values
            root["PointData/U"] = vtk_to_numpy(image.GetPointData().GetArray("U")).reshape(5, 7, 9, 3)
        for name, size in ("mesh", (15, 11, 7)), ("image", (9, 7, 5)):
            path, = self.imports(f"{name}.vtkhdf", "-o", f"{name}.vdb")
            self.assert_flow(path, flows.flow, size)
            self.cut_files_are_refused(f"{name}.vtkhdf")

    def test_tecplot(self):
        """A grid of points, and tetrahedra; one time. VTK takes zeros for what a cut file lacks."""
        head = 'TITLE = "a flow"\nVARIABLES = "X" "Y" "Z" "U" "V" "W"\n'
        at = flows.grid_positions(*flows.axes())
        grid = flows.tetrahedra()
        rows = lambda *tables: lines(" ".join(f"{x:.8g}" for x in row) for row in numpy.concatenate(tables, axis=-1).reshape(-1, 6))
        (self.folder / "points.tec").write_text(
            f'{head}ZONE T="box", I=9, J=7, K=5, SOLUTIONTIME=2.5, F=POINT\n{rows(at, flows.flow(at))}\n', encoding="ascii")
        places = vtk_to_numpy(grid.GetPoints().GetData())
        corners = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4) + 1
        (self.folder / "cells.tec").write_text(
            f"{head}ZONE N={len(places)}, E={len(corners)}, F=FEPOINT, ET=TETRAHEDRON\n{rows(places, flows.flow(places))}\n"
            + lines(" ".join(map(str, row)) for row in corners) + "\n", encoding="ascii")
        for name, size in ("points", (9, 7, 5)), ("cells", (15, 11, 7)):
            path, = self.imports(f"{name}.tec", "-o", f"{name}.vdb")
            self.assert_flow(path, flows.flow, size)
            text = self.contents(f"{name}.tec")
            self.cut_files_are_refused(f"{name}.tec")
            (self.folder / f"{name}.tec").write_bytes(text)
        self.assertEqual(vdb.readMetadata(str(self.folder / "points.vdb"))["time"], 2.5)
        zones = self.contents("points.tec").decode()
        (self.folder / "two.tec").write_text(zones + zones[zones.index("ZONE"):].replace("2.5", "3"), encoding="ascii")
        self.assertIn("two.tec: zones of several times or with shared arrays are not read",
                      self.refuses(3, "two.tec", "-o", "w.vdb"))

    def test_fluent(self):
        """The cells of an OpenFOAM case, whose faces Fluent turns round."""
        flows.write_foam(self.folder / "case", [0.0], sizes=SIZE)
        inside = lambda name: (self.folder / "case" / name).read_text().split("\n(\n")[1].split("\n)")[0].split("\n")
        points = [row.strip("()") for row in inside("constant/polyMesh/points")]
        faces = [list(map(int, row[2:-1].split())) for row in inside("constant/polyMesh/faces")]
        owners, neighbours = (list(map(int, inside(f"constant/polyMesh/{name}"))) for name in ("owner", "neighbour"))
        velocity = [row.strip("()").split() for row in inside("0/U")]
        cells, inner = len(velocity), len(neighbours)
        neighbours += [-1] * (len(owners) - inner)
        section = lambda zone, first, last, kind: f"(13 ({zone} {first + 1:x} {last:x} {kind} 4)(\n" + lines(
            " ".join(f"{number + 1:x}" for number in (*faces[i][::-1], owners[i], neighbours[i])) for i in range(first, last)) + "))\n"
        (self.folder / "a.cas").write_text(
            f'(0 "a box")\n(2 3)\n(10 (0 1 {len(points):x} 0 3))\n(12 (0 1 {cells:x} 0))\n(13 (0 1 {len(faces):x} 0))\n'
            f"(12 (2 1 {cells:x} 1 4))\n{section(3, 0, inner, 2)}{section(4, inner, len(faces), 3)}"
            f"(10 (1 1 {len(points):x} 1 3)(\n{lines(points)}))\n(45 (2 fluid fluid)())\n(45 (3 interior inside)())\n"
            "(45 (4 wall walls)())\n", encoding="ascii")
        self.assertIn("a.cas: its data are in a.dat, which does not exist", self.refuses(3, "a.cas", "-o", "v.vdb"))
        (self.folder / "a.dat").write_text(
            f'(0 "data")\n(33 ({cells} {len(faces)} {len(points)}))\n' + "".join(
                f"(300 ({111 + axis} 2 1 0 0 1 {cells})(\n{lines(row[axis] for row in velocity)}\n))\n" for axis in range(3)),
            encoding="ascii")
        path, = self.imports("a.cas", "-o", "v.vdb")
        self.assert_flow(path, flows.flow, SIZE)
        whole = self.contents("a.cas")
        self.cut_files_are_refused("a.cas")
        (self.folder / "a.cas").write_bytes(whole)
        self.cut_files_are_refused("a.dat", "a.cas")

    def test_other_programs(self):
        for name, kind in (("a.cas.h5", "Fluent's form in HDF5"), ("a.xdmf", "Xdmf"), ("a.plt", "Tecplot's binary form"),
                           ("a.nek5000", "Nek5000")):
            (self.folder / name).write_text("something", encoding="ascii")
            self.assertIn(f"{name}: {kind} is not read; ParaView's File > Save Data writes it as .vtm or .vtu",
                          self.refuses(3, name, "-o", "v.vdb"))
        (self.folder / "a.vtu").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\n", encoding="ascii")
        self.assertIn("a.vtu: it is a pointer of Git LFS to the file, which 'git lfs pull' fetches",
                      self.refuses(3, "a.vtu", "-o", "v.vdb"))


if __name__ == "__main__":
    unittest.main()
