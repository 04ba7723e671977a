"""vdblic_export: textures and velocities as VTK and NumPy read them back."""

import resource
import unittest
import xml.etree.ElementTree

import numpy
import pyopenvdb as vdb
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

from flows import flow
import python_module  # pylint: disable=unused-import
from support import ToolTest



def image_of(path):
    """Arrays (x, y, z[, 3]) of a .vti file by name, the positions of its points, its time."""
    reader = vtkXMLImageDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    shape = image.GetDimensions()[::-1]
    order = lambda values: values.reshape(*shape, -1).transpose(2, 1, 0, 3)
    data = image.GetPointData()
    arrays = {data.GetArrayName(i): order(vtk_to_numpy(data.GetArray(i))) for i in range(data.GetNumberOfArrays())}
    positions = order(numpy.array([image.GetPoint(i) for i in range(image.GetNumberOfPoints())]))
    time = image.GetFieldData().GetArray("TimeValue")
    return arrays, positions, time and time.GetValue(0)


def dense(path, name, low, shape):
    values = numpy.zeros(shape, numpy.float32)
    vdb.read(str(path), name).copyToArray(values, low)
    return values


def limited(size):
    """For a process: limits its data."""
    return lambda: resource.setrlimit(resource.RLIMIT_DATA, (size, size))


class Export(ToolTest):
    def exports(self, *arguments, **options):
        return [path.name for path in self.outputs("vdblic_export", *arguments, **options)]

    def velocity(self, name, transform, low=(0, 0, 0), size=(6, 5, 4), staggered=False):
        """Write the known flow, sampled in world space."""
        grid = vdb.Vec3SGrid()
        grid.transform = transform
        values = numpy.zeros((*size, 3), numpy.float32)
        for index in numpy.ndindex(*size):
            at = [numpy.array(index, float) + low] * 3
            if staggered:
                at = [at[axis] - 0.5 * numpy.eye(3)[axis] for axis in range(3)]
            values[index] = [flow(numpy.array(transform.indexToWorld(tuple(at[axis]))))[axis] for axis in range(3)]
        grid.copyFromArray(values, low)
        grid.name = "velocity"
        grid.gridClass = "staggered" if staggered else "unknown"
        vdb.write(str(self.folder / name), grid)

    def test_textures(self):
        self.outputs("vdblic_synth", "ring", "-o", "v.%04d.vdb", "--size", 16, 12, 10, "--frames", "3-5", "--dt", 0.25)
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--preroll", 0)
        names = [f"lic_{frame:04}.vti" for frame in (3, 4, 5)]
        self.assertEqual(self.exports("lic.%04d.vdb", "-o", "lic_%04d.vti"), [*names, "lic.pvd"])
        for frame, name in zip((3, 4, 5), names):
            path = self.folder / f"lic.{frame:04}.vdb"
            grid = vdb.read(str(path), "density")
            low, high = grid.evalActiveVoxelBoundingBox()
            arrays, positions, time = image_of(self.folder / name)
            shape = tuple(b - a + 1 for a, b in zip(low, high))
            self.assertEqual(arrays["density"].shape[:3], shape)
            for scalar in "density", "magnitude":
                numpy.testing.assert_array_equal(arrays[scalar][..., 0], dense(path, scalar, low, shape))
            self.assertEqual(arrays["active"].sum(), grid.activeVoxelCount())
            place = grid.transform.indexToWorld(tuple(float(a + b) for a, b in zip(low, (2, 3, 4))))
            numpy.testing.assert_allclose(positions[2, 3, 4], place)
            self.assertEqual(time, (frame - 1) * 0.25)
        entries = xml.etree.ElementTree.parse(self.folder / "lic.pvd").iter("DataSet")
        self.assertEqual([(entry.get("file"), float(entry.get("timestep"))) for entry in entries],
                         list(zip(names, (0.5, 0.75, 1))))
        # What is there stays, and is in the list.
        before = self.contents("lic_0004.vti")
        (self.folder / "lic_0003.vti").write_bytes(b"mine</VTKFile>")
        self.exports("-", "-o", "lic_%04d.vti", "--skip-existing", stdin="lic.0003.vdb\nlic.0004.vdb\n")
        self.assertEqual((self.contents("lic_0003.vti"), self.contents("lic_0004.vti")), (b"mine</VTKFile>", before))
        self.assertIn(b"lic_0003.vti", self.contents("lic.pvd"))

    def test_grids_of_other_voxels_are_interpolated(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.vdb", "--size", 8, 8, 8, "--frames", "1")
        refined = ("vdblic_advect", "v.vdb", "--preroll", 0, "--refine", 2, "--precision", "float", "--finish", 0)
        self.outputs(*refined, "-o", "own.vdb")
        self.outputs(*refined, "-o", "same.vdb", "--scalars", "texture")
        self.exports("own.vdb", "-o", "own.vti")
        arrays, _, _ = image_of(self.folder / "own.vti")
        expected = dense(self.folder / "own.vdb", "density", (0, 0, 0), (16,) * 3)
        numpy.testing.assert_array_equal(arrays["density"][..., 0], expected)
        expected = dense(self.folder / "same.vdb", "magnitude", (0, 0, 0), (16,) * 3)
        numpy.testing.assert_allclose(arrays["magnitude"][..., 0], expected, rtol=1e-5)

    def test_velocities(self):
        turned = vdb.createLinearTransform([[0, 0.2, 0, 0], [-0.3, 0, 0, 0], [0, 0, 0.1, 0], [5, 6, 7, 1]])
        self.velocity("turned.vdb", turned, (-3, 2, 1))
        self.velocity("faces.vdb", vdb.createLinearTransform(0.5), staggered=True)
        for name, inside in ("turned", slice(None)), ("faces", slice(0, -1)):  # the last face is missing
            self.assertEqual(self.exports(f"{name}.vdb", "-o", f"{name}.vti"), [f"{name}.vti"])
            arrays, positions, _ = image_of(self.folder / f"{name}.vti")
            part = inside, inside, inside
            numpy.testing.assert_allclose(arrays["velocity"][part], flow(positions)[part], rtol=1e-5, atol=1e-5)

    def test_numpy_and_back(self):
        self.outputs("vdblic_synth", "ring", "-o", "v.%04d.vdb", "--size", 16, 12, 10, "--frames", "1-2")
        self.assertEqual(self.exports("v.%04d.vdb", "-o", "v_%04d.npz"), ["v_0001.npz", "v_0002.npz"])
        loaded = numpy.load(self.folder / "v_0002.npz")
        grid = vdb.read(str(self.folder / "v.0002.vdb"), "velocity")
        self.assertEqual(loaded["active"].sum(), grid.activeVoxelCount())
        self.outputs("vdblic_import", "v_%04d.npz", "-o", "back.%04d.vdb")
        done = self.run_tool("vdblic_diff", "v.%04d.vdb", "back.%04d.vdb", "--ignore-metadata", "source,velocity_array")
        self.assertNotRegex(done.stdout + done.stderr, "voxels differ|topology|transform")
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "a.%04d.vdb")
        self.outputs("vdblic_advect", "back.%04d.vdb", "-o", "b.%04d.vdb")
        low, high = vdb.read(str(self.folder / "a.0002.vdb"), "density").evalActiveVoxelBoundingBox()
        shape = [b - a + 1 for a, b in zip(low, high)]
        self.assertEqual(low, (0, 0, 0))  # noise, and so the texture, belongs to voxel indices
        numpy.testing.assert_array_equal(dense(self.folder / "a.0002.vdb", "density", low, shape),
                                         dense(self.folder / "b.0002.vdb", "density", low, shape))

    def test_inactive_voxels_come_back_inactive(self):
        x, y, z = numpy.meshgrid(*(numpy.arange(n) for n in (12, 10, 8)), indexing="ij")
        active = (x - 6) ** 2 + (y - 5) ** 2 + (z - 4) ** 2 > 9
        numpy.savez(self.folder / "v.npz", velocity=flow(numpy.stack([x, y, z], axis=-1)), active=active)
        self.outputs("vdblic_import", "v.npz", "-o", "v.vdb")
        self.exports("v.vdb", "-o", "v.vti")
        reader = vtkXMLImageDataReader()
        reader.SetFileName(str(self.folder / "v.vti"))
        reader.Update()
        image = reader.GetOutput()
        visible = [bool(image.IsPointVisible(i)) for i in range(image.GetNumberOfPoints())]  # as ParaView sees them
        numpy.testing.assert_array_equal(numpy.reshape(visible, active.shape[::-1]).transpose(2, 1, 0), active)
        self.outputs("vdblic_import", "v.vti", "-o", "back.vdb")
        done = self.run_tool("vdblic_diff", "v.vdb", "back.vdb", "--ignore-metadata", "source,velocity_array")
        self.assertEqual(done.returncode, 0, done.stdout)
        # Of other voxels, those in a cell that lacks a corner are inactive.
        path, = self.outputs("vdblic_import", "v.vti", "-o", "fine.vdb", "--voxel-size", 0.5)
        accessor = vdb.read(str(path), "velocity").getConstAccessor()
        whole = lambda cell: active[tuple(slice(i, i + 2) for i in cell)].all()
        for cell in numpy.ndindex(11, 9, 7):
            voxel = tuple(2 * i + 1 for i in cell)
            self.assertEqual(accessor.isValueOn(voxel), whole(cell), cell)

    def test_sparse_textures(self):
        """What is empty is 0 and not hidden; a message tells how much that is, once."""
        self.outputs("vdblic_synth", "ring", "-o", "v.%04d.vdb", "--size", 24, 16, 16, "--frames", "1-2")
        paths = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "s.%04d.vdb", "--method", "streaks", "--spacing", 3,
                             "--refine", 4)
        done = self.run_tool("vdblic_export", "s.%04d.vdb", "-o", "s_%04d.vti")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"s.0001.vdb: [\d.]+% of the 0\.\d+ million voxels of the texture's box are active")
        self.assertEqual(done.stderr.count("are active"), 1)
        arrays, *_ = image_of(self.folder / "s_0001.vti")
        self.assertNotIn("vtkGhostType", arrays)
        active = arrays["active"][..., 0] > 0
        self.assertEqual(active.sum(), vdb.read(str(paths[0]), "density").activeVoxelCount())
        self.assertTrue((arrays["density"][..., 0][~active] == 0).all())
        self.assertGreater(arrays["magnitude"][..., 0][~active].max(), 0)

    def test_what_takes_too_much_memory_is_refused_before_it_is_read(self):
        grid = vdb.FloatGrid()
        for corner in ((0, 0, 0), (1200, 1200, 1200)):
            grid.fill(corner, corner, 1)
        grids = [grid.deepCopy() for _ in range(3)]
        for name, one in zip(("density", "a", "b"), grids):
            one.name = name
        vdb.write(str(self.folder / "s.vdb"), grids)
        # The box of each takes 8 GiB of memory.
        message = self.fails(3, "vdblic_export", "s.vdb", "-o", "s.vti", preexec_fn=limited(20 << 30))
        self.assertIn("and 2 others: the bounding box (1.73e+03 million voxels", message)
        self.assertIn("choose fewer with --grids", message)

    def test_names_of_lists(self):
        self.outputs("vdblic_noise", "-o", "n.1.vdb", "--size", 4, 4, 4)
        for pattern, name in ("exp %d.vti", "exp.pvd"), ("a_%04d.vti", "a.pvd"), ("%d.vti", "frames.pvd"):
            self.assertEqual(self.exports("n.%d.vdb", "-o", pattern)[-1], name)

    def test_mistakes(self):
        self.outputs("vdblic_noise", "-o", "n.vdb", "--size", 4, 4, 4)
        (self.folder / "broken.vdb").write_bytes(self.contents("n.vdb")[:200])
        huge = vdb.FloatGrid()
        huge.fill((0, 0, 0), (0, 0, 0), 1)
        huge.fill((100000, 100000, 100000), (100000, 100000, 100000), 1)
        huge.name = "huge"
        vdb.write(str(self.folder / "huge.vdb"), huge)
        before = self.files()
        for status, words, *arguments in (
                (3, "no grid 'p' of numbers or vectors; present: noise", "n.vdb", "-o", "n.vti", "--grids", "p"),
                (3, "broken.vdb: cannot be read", "broken.vdb", "-o", "n.vti"),
                (3, "huge.vdb: grid 'huge': the bounding box (1e+09 million voxels, 2e-13 % of them active) would take", "huge.vdb", "-o", "n.vti"),
                (3, "no such file", "nothing.vdb", "-o", "n.vti"),
                (3, "names no files", "-", "-o", "n.vti"),
                (2, "must end in .vti or .vtp or .npz or .usda or .vdb", "n.vdb", "-o", "n.vtk"),
                (2, "would replace an input", "n.vdb", "-o", "link.vti"),
                (4, "make it first", "n.vdb", "-o", "nowhere/n.vti")):
            with self.subTest(words):
                if "link.vti" in arguments:
                    (self.folder / "link.vti").symlink_to("n.vdb")
                    before = self.files()
                self.assertIn(words, self.fails(status, "vdblic_export", *arguments))
                self.assertEqual(self.files(), before)


if __name__ == "__main__":
    unittest.main()
