"""vdblic_import at a thousand random points of random flows, against VTK and netCDF4 read directly."""

import unittest

import numpy

from support import skip

try:
    import netCDF4
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData
    from vtkmodules.vtkFiltersCore import vtkProbeFilter
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLStructuredGridReader, vtkXMLUnstructuredGridReader
except ImportError as error:
    skip(f"{error.name} is missing")

import flows
import netcdf_flows
from imports import ImportTest, velocity_of

POINTS = 1000


class Points(ImportTest):
    def points(self, path):
        """Positions and velocities of random active voxels."""
        values, active, positions = velocity_of(path)
        chosen = numpy.random.default_rng(1).choice(numpy.argwhere(active), POINTS)
        at = tuple(chosen.T)
        return positions[at], values[at]

    def randomize(self, data, name):
        """Replace the velocity of VTK's data by random numbers."""
        shape = data.GetPointData().GetArray(name).GetNumberOfTuples(), 3
        vtk_to_numpy(data.GetPointData().GetArray(name))[:] = numpy.random.default_rng(2).uniform(-1, 1, shape)

    def test_vtk(self):
        readers = {"vti": vtkXMLImageDataReader, "vts": vtkXMLStructuredGridReader, "vtu": vtkXMLUnstructuredGridReader}
        for ending, made in ("vti", flows.image()), ("vts", flows.structured()), ("vtu", flows.tetrahedra()):
            with self.subTest(ending=ending):
                name = next(made.GetPointData().GetArrayName(i) for i in range(made.GetPointData().GetNumberOfArrays())
                            if made.GetPointData().GetArray(i).GetNumberOfComponents() == 3)
                self.randomize(made, name)
                flows.write_vtk(made, self.folder / f"flow.{ending}")
                path, = self.imports(f"flow.{ending}", "-o", f"{ending}.vdb", "--size", 24, 20, 16)
                positions, velocities = self.points(path)

                reader = readers[ending]()
                reader.SetFileName(str(self.folder / f"flow.{ending}"))
                places, cloud, probe = vtkPoints(), vtkPolyData(), vtkProbeFilter()
                for position in positions:
                    places.InsertNextPoint(position)
                cloud.SetPoints(places)
                probe.SetSourceConnection(reader.GetOutputPort())
                probe.SetInputData(cloud)
                probe.Update()
                found = vtk_to_numpy(probe.GetOutput().GetPointData().GetArray(name))
                inside = vtk_to_numpy(probe.GetOutput().GetPointData().GetArray("vtkValidPointMask")) > 0
                self.assertGreater(inside.mean(), 0.99)  # all but some on the faces of the box
                numpy.testing.assert_allclose(velocities[inside], found[inside], atol=2e-5)

    def test_netcdf(self):
        """Axes of 9 x 6 x 5 values in km and m: the voxels lie between them."""
        netcdf_flows.write_heights(self.folder / "winds.nc", terrain=False)
        with netCDF4.Dataset(self.folder / "winds.nc", "r+") as data:
            for i, name in enumerate("uvw"):
                data[name][:] = numpy.random.default_rng(i).uniform(-1, 1, data[name].shape)
        path, = self.imports("winds.nc", "-o", "v.vdb", "--size", 24, 20, 16)
        positions, velocities = self.points(path)
        with netCDF4.Dataset(self.folder / "winds.nc") as data:
            axes = [1000 * data["x"][:].data, 1000 * data["y"][:].data, data["z"][:].data]
            winds = numpy.stack([data[name][:].data.transpose(2, 1, 0) for name in "uvw"], axis=-1)
        expected = 0
        place = [numpy.interp(positions[:, i], axis, numpy.arange(len(axis))) for i, axis in enumerate(axes)]
        low = [numpy.minimum(p.astype(int), len(axis) - 2) for p, axis in zip(place, axes)]
        for corner in numpy.ndindex(2, 2, 2):
            weights = numpy.prod([1 - abs(p - a - c) for p, a, c in zip(place, low, corner)], axis=0)
            expected = expected + weights[:, None] * winds[tuple(a + c for a, c in zip(low, corner))]
        numpy.testing.assert_allclose(velocities, expected, atol=2e-5)


if __name__ == "__main__":
    unittest.main()
