"""Streaks as lines: vdblic_advect --draw lines, and vdblic_export of them, as VTK and OpenUSD read them."""

import json
import subprocess

import numpy
import pyopenvdb as vdb

import python_module  # pylint: disable=unused-import
from support import ToolTest, peer

from vdblic._core import read_lines

USD = peer("usd", "pxr")
TURN = 0.2  # radians in a second
READ_CURVES = """
import json, sys
from pxr import Usd, UsdGeom, UsdValidation
stage = Usd.Stage.Open(sys.argv[1])
curves = UsdGeom.BasisCurves(stage.GetPrimAtPath("/flow/streaks"))
frame = float(sys.argv[2])
api = UsdGeom.PrimvarsAPI(curves)
found = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators()).Validate(stage)
extent = curves.GetExtentAttr().Get(frame)
print(json.dumps({
    "errors": [error.GetErrorAsString() for error in found],
    "type": curves.GetTypeAttr().Get(), "counts": list(curves.GetCurveVertexCountsAttr().Get(frame)),
    "points": [list(point) for point in curves.GetPointsAttr().Get(frame)],
    "velocities": [list(vector) for vector in curves.GetVelocitiesAttr().Get(frame)],
    "widths": list(curves.GetWidthsAttr().Get(frame)), "widths_at": curves.GetWidthsInterpolation(),
    "extent": [list(corner) for corner in extent],
    "primvars": {p.GetPrimvarName(): [p.GetInterpolation(), len(p.Get(frame))] for p in api.GetPrimvars()},
    "without": sum(value != value for value in api.GetPrimvar("heat").Get(frame)),
    "rate": stage.GetTimeCodesPerSecond()}))
"""


class Lines(ToolTest):
    def rotation(self, frames=4, hole=None):
        """A solid body's rotation about the axis z through the middle, in voxels a second; frames of a second."""
        place = numpy.indices((32, 32, 12)).transpose(1, 2, 3, 0) - numpy.array([15.5, 15.5, 5.5])
        velocity = numpy.stack([-TURN * place[..., 1], TURN * place[..., 0], 0 * place[..., 0]], axis=-1)
        grid, grids = vdb.Vec3SGrid(), []
        grid.name = "velocity"
        grid.copyFromArray(velocity.astype(numpy.float32))
        heat = vdb.FloatGrid()
        heat.name = "heat"
        values = place[..., 0].astype(numpy.float32)
        if hole is not None:
            values[:] = hole
        heat.copyFromArray(values)
        for frame in range(1, frames + 1):
            vdb.write(str(self.folder / f"v.{frame:04}.vdb"), [grid, heat])
        return "v.%04d.vdb", "--dt", 1, "--spacing", 3, "--tail", 3

    def advect(self, *arguments, output="s.%04d.vdb", **options):
        return self.outputs("vdblic_advect", *arguments, "--method", "streaks", "--refine", 4, "-o", output, **options)

    def inside(self, points):
        """Whether points are away from the rims, where a flow goes on as it is at the rim."""
        return (abs(points - [15.5, 15.5, 5.5]) < [14.5, 14.5, 4.5]).all(axis=1)

    def test_lines_are_paths_of_the_flow(self):
        """In a rotation the points of a line are at one distance from the axis, as far behind the head as they are old."""
        path = self.advect(*self.rotation(), "--carry", "heat", "--draw", "lines", "--with", "q")[-1]
        lines, metadata = read_lines(path)
        self.assertEqual(metadata["frame"], 4)
        self.assertGreater(len(lines["counts"]), 50)
        self.assertEqual(len(set(lines["id"].tolist())), len(lines["id"]))
        self.assertEqual(sorted(lines["scalars"]), ["heat", "magnitude", "q"])
        seam = 1e-3
        for count, end in zip(lines["counts"], numpy.cumsum(lines["counts"])):
            line = slice(end - count, end)
            place = lines["points"][line, :2] - 15.5
            distance, age = numpy.hypot(*place.T), lines["age"][line]
            self.assertLess(numpy.ptp(distance), 0.03)
            turned = numpy.unwrap(numpy.arctan2(place[:, 1], place[:, 0]))
            if distance[0] > 2:
                numpy.testing.assert_allclose(turned[-1] - turned, TURN * (age - age[-1]), atol=0.01)
            if (abs(place) < 15).all():  # the head of a line may have left
                self.assertEqual(age[-1], 0)
            self.assertTrue((numpy.diff(age) < 0).all())
            self.assertTrue((numpy.diff(lines["opacity"][line]) >= -seam).all())
            self.assertTrue((numpy.diff(lines["radius"][line]) >= -seam).all())
        inside = self.inside(lines["points"])
        self.assertGreater(inside.sum(), 100)
        points, scalars = lines["points"][inside], lines["scalars"]
        numpy.testing.assert_allclose(scalars["heat"][inside], points[:, 0] - 15.5, atol=0.01)
        numpy.testing.assert_allclose(scalars["q"][inside], TURN**2, rtol=1e-3)
        # Halfs, of a value that is linear from voxel to voxel only along rays from the axis.
        speed = TURN * numpy.hypot(*(points[:, :2] - 15.5).T)
        numpy.testing.assert_allclose(scalars["magnitude"][inside], speed, atol=0.05)

    def test_a_line_keeps_its_id(self):
        first, second = (read_lines(path)[0] for path in self.advect(
            *self.rotation(), "--draw", "lines", "--frames", "2-3"))
        heads = [dict(zip(one["id"].tolist(), one["points"][numpy.cumsum(one["counts"]) - 1])) for one in (first, second)]
        common = [name for name in set(heads[0]) & set(heads[1]) if self.inside(numpy.array([one[name] for one in heads])).all()]
        self.assertGreater(len(common), 0.3 * len(heads[0]))
        for name in common:
            a, b = (head[name][:2] - 15.5 for head in heads)
            turned = numpy.array([[numpy.cos(TURN), -numpy.sin(TURN)], [numpy.sin(TURN), numpy.cos(TURN)]]) @ a
            self.assertLess(numpy.linalg.norm(turned - b), 0.03)

    def test_any_number_of_threads_writes_the_same_bytes(self):
        flow = self.rotation()
        paths = [self.advect(*flow, "--draw", "lines", "--frames", "1-2", "--threads", threads, output=f"t{threads}.%04d.vdb")
                 for threads in (1, 2, 5)]
        for one, *others in zip(*paths):
            for other in others:
                self.assertEqual(one.read_bytes(), other.read_bytes())

    def test_a_resumed_run_writes_the_same_lines(self):
        flow = (*self.rotation(), "--draw", "lines")
        whole = self.advect(*flow)
        self.advect(*flow, "--frames", "1-2", "--keep-checkpoint", output="r.%04d.vdb")
        resumed = self.advect(*flow, "--resume", output="r.%04d.vdb")
        for a, b in zip(whole, resumed):
            self.assertEqual(a.read_bytes(), b.read_bytes())

    def test_what_cannot_be_is_told(self):
        flow = self.rotation()
        told = self.fails(2, "vdblic_advect", *flow, "-o", "l.%04d.vdb", "--method", "streaks", "--draw", "lines", "--carry", "age")
        self.assertIn("age", told)
        self.advect(*flow, "--frames", "1-1")
        told = self.fails(3, "vdblic_export", "s.0001.vdb", "-o", "s.vtp")
        self.assertIn("no grid 'streaks'", told)

    def test_vtk_reads_the_lines(self):
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

        (source,) = self.advect(*self.rotation(hole=numpy.nan), "--carry", "heat", "--draw", "lines", "--frames", "3-3")
        lines, metadata = read_lines(source)
        (path,) = self.outputs("vdblic_export", source, "-o", "s.vtp")
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(path))
        reader.Update()
        data = reader.GetOutput()
        numpy.testing.assert_array_equal(vtk_to_numpy(data.GetPoints().GetData()), lines["points"])
        self.assertEqual(numpy.diff(vtk_to_numpy(data.GetLines().GetOffsetsArray())).tolist(), lines["counts"].tolist())
        self.assertEqual(vtk_to_numpy(data.GetCellData().GetArray("id")).tolist(), lines["id"].tolist())
        for name, values in (lines["scalars"] | {name: lines[name] for name in ("radius", "opacity", "age")}).items():
            numpy.testing.assert_array_equal(vtk_to_numpy(data.GetPointData().GetArray(name)), values)
        self.assertTrue(numpy.isnan(lines["scalars"]["heat"]).all())
        self.assertEqual(vtk_to_numpy(data.GetFieldData().GetArray("TimeValue")).tolist(), [metadata["time"]])
        paths = self.outputs("vdblic_export", "s.%04d.vdb", "-o", "all_%04d.vtp")
        self.assertEqual([path.name for path in paths], ["all_0003.vtp", "all.pvd"])

    def test_openusd_reads_the_lines(self):
        if USD is None:
            self.skipTest("usd-core is missing: tests/peers.sh gets it")
        sources = self.advect(*self.rotation(hole=numpy.nan), "--carry", "heat", "--draw", "lines", "--frames", "2-4")
        (path,) = self.outputs("vdblic_export", "s.%04d.vdb", "-o", "flow.usda")
        box = 32
        for frame, source in zip((2, 3, 4), sources):
            done = subprocess.run([USD, "-c", READ_CURVES, path, str(frame)], text=True, capture_output=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            told, (lines, _) = json.loads(done.stdout), read_lines(source)
            self.assertEqual((told["errors"], told["type"], told["widths_at"]), ([], "linear", "vertex"))
            self.assertEqual(told["counts"], lines["counts"].tolist())
            self.assertLess(abs(numpy.array(told["points"]) - lines["points"]).max(), 1e-6 * box)
            numpy.testing.assert_allclose(told["widths"], 2 * lines["radius"], rtol=1e-6)
            points = len(lines["points"])
            self.assertEqual(
                told["primvars"],
                {name: ["vertex", points] for name in ("displayColor", "displayOpacity", "age", "heat", "magnitude")} | {"id": ["uniform", len(lines["counts"])]},
            )
            self.assertEqual(told["without"], points)  # a scalar without values is not 0
            low, high = told["extent"]
            self.assertTrue((lines["points"] > low).all() and (lines["points"] < high).all())
            # The particles' velocity by their path, in units a second of the time codes.
            inside = self.inside(lines["points"])
            place = lines["points"][inside, :2] - 15.5
            speed = numpy.linalg.norm(told["velocities"], axis=1)[inside] / told["rate"]
            numpy.testing.assert_allclose(speed, TURN * numpy.hypot(*place.T), atol=0.05)


if __name__ == "__main__":
    import unittest

    unittest.main()
