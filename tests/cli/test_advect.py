"""vdblic_advect on the command line."""

import json
import resource
import unittest

import numpy
import pyopenvdb as vdb

from support import WAKE, ToolTest



def values(path, name="density"):
    """A grid's active values, as an array over its bounding box, and the box's lower corner."""
    grid = vdb.read(str(path), name)
    low, high = grid.evalActiveVoxelBoundingBox()
    array = numpy.zeros([high[i] - low[i] + 1 for i in range(3)], numpy.float32)
    grid.copyToArray(array, ijk=low)
    return array, low


class Advect(ToolTest):
    def test_wake(self):
        paths = self.outputs("vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "1-4", "--precision", "float")
        self.assertEqual([p.name for p in paths], [f"lic.{k:04}.vdb" for k in range(1, 5)])
        self.assertEqual(self.files(), [p.name for p in paths])
        velocity = vdb.read(str(WAKE) % 3, "velocity")
        texture = vdb.read(str(paths[2]), "density")
        magnitude = vdb.read(str(paths[2]), "magnitude")
        for grid in texture, magnitude:
            self.assertEqual(grid.activeVoxelCount(), velocity.activeVoxelCount())
            self.assertEqual(grid.transform, velocity.transform)
            self.assertEqual(grid.gridClass, "fog volume")
            # Leaves hold voxels: Blender draws active tiles blank.
            self.assertEqual(grid.leafCount(), velocity.leafCount())
        array, low = values(paths[2])
        active = array[array > 0]
        self.assertGreaterEqual(array.min(), 0)
        self.assertLessEqual(array.max(), 1)
        self.assertGreater(active.std(), 0.09)
        vectors = numpy.zeros([*array.shape, 3], numpy.float32)
        velocity.copyToArray(vectors, ijk=low)
        numpy.testing.assert_allclose(values(paths[2], "magnitude")[0], numpy.linalg.norm(vectors, axis=3), rtol=1e-5)

    def test_vorticity_and_q(self):
        path = self.outputs("vdblic_advect", "-o", "lic.%04d.vdb", "--frames", "3-4", "--with", "vorticity,q", "--precision",
                            "float", WAKE)[0]
        velocity = vdb.read(str(WAKE) % 3, "velocity")
        vorticity, low = values(path, "vorticity")
        q = values(path, "q")[0]
        self.assertEqual(vdb.read(str(path), "q").activeVoxelCount(), velocity.activeVoxelCount())
        vectors = numpy.zeros([*vorticity.shape, 3], numpy.float64)
        velocity.copyToArray(vectors, ijk=low)
        active = values(path)[0] > 0
        # numpy's derivatives, compared where all neighbours are active.
        j = numpy.stack([numpy.gradient(vectors, 0.0025, axis=a) for a in range(3)], axis=-1)  # [..., i, a] = dv_i/dx_a
        curl = numpy.stack([j[..., 2, 1] - j[..., 1, 2], j[..., 0, 2] - j[..., 2, 0], j[..., 1, 0] - j[..., 0, 1]], -1)
        inside = active.copy()
        for axis in range(3):
            for step in (-1, 1):
                inside &= numpy.roll(active, step, axis)
        inside[[0, -1]] = inside[:, [0, -1]] = inside[:, :, [0, -1]] = False
        self.assertGreater(inside.sum(), 50000)  # where no texture is exactly 0
        numpy.testing.assert_allclose(vorticity[inside], numpy.linalg.norm(curl, axis=-1)[inside], rtol=1e-4, atol=1e-4)
        expected = -0.5 * numpy.einsum("...ia,...ai->...", j, j)
        numpy.testing.assert_allclose(q[inside], expected[inside], rtol=1e-3, atol=1e-2)
        for bad in "helicity", "q,q", "":
            self.fails(2, "vdblic_advect", WAKE, "-o", "x.%04d.vdb", "--with", bad)

    def test_lic_of_each_frame_on_its_own(self):
        """A frame does not depend on earlier frames and is smoother than its noise."""
        lic = "--method", "lic"
        paths = self.outputs("vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "2-4", *lic)
        alone = self.outputs("vdblic_advect", WAKE, "-o", "alone.%04d.vdb", "--frames", "3-4", *lic)[0]
        numpy.testing.assert_array_equal(values(paths[1])[0], values(alone)[0])
        metadata = vdb.readMetadata(str(alone))
        self.assertEqual(metadata["method"], "lic")
        self.assertNotIn("release_window", metadata)
        array, _ = values(alone)
        self.assertLess(array[array > 0].std(), 0.2)  # the noise has 0.29

    def test_metadata(self):
        path = self.outputs("vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "3-4", "--life", "5", "--seed", "9")[0]
        metadata = vdb.readMetadata(str(path))
        self.assertTrue(metadata["creator"].startswith("VDBLIC "))
        self.assertEqual(metadata["frame"], 3)
        self.assertAlmostEqual(metadata["time"], 0.1, 5)
        self.assertAlmostEqual(metadata["dt"], 0.05, 5)
        self.assertEqual((metadata["method"], metadata["life_span"], metadata["seed"]), ("auflic", 5, 9))

    def test_half_precision_is_the_rounded_float(self):
        common = WAKE, "--frames", "3-3", "--with", "vorticity,q"
        half = self.outputs("vdblic_advect", *common, "-o", "half.%04d.vdb")[0]
        full = self.outputs("vdblic_advect", *common, "-o", "float.%04d.vdb", "--precision", "float")[0]
        self.assertLess(half.stat().st_size, 0.6 * full.stat().st_size)
        for name in "density", "magnitude", "vorticity", "q":
            exact, rounded = values(full, name)[0], values(half, name)[0]
            # vdb files hold halves rounded to nearest, as numpy rounds.
            numpy.testing.assert_array_equal(rounded, exact.astype(numpy.float16).astype(numpy.float32), name)
            self.assertTrue((rounded != exact).any(), name)
            self.assertEqual(vdb.read(str(half), name)["is_saved_as_half_float"], True)

    def test_scalars_beyond_half_precision_stay_single(self):
        for scale in 1e-6, 1e6:
            path = self.outputs("vdblic_advect", WAKE, "--frames", "3-3", "-o", "scaled.%04d.vdb",
                                "--velocity-scale", scale, "--dt", 0.05 / scale)[0]
            speed = numpy.linalg.norm(self.velocities(), axis=3) * scale
            numpy.testing.assert_allclose(values(path, "magnitude")[0], speed, rtol=1e-5)

    def velocities(self):
        grid = vdb.read(str(WAKE) % 3, "velocity")
        low, high = grid.evalActiveVoxelBoundingBox()
        vectors = numpy.zeros([*(high[i] - low[i] + 1 for i in range(3)), 3], numpy.float32)
        grid.copyToArray(vectors, ijk=low)
        return vectors

    def test_compression(self):
        speed = numpy.zeros((32, 32, 32, 3), numpy.float32)
        speed[..., 0] = 1  # compresses well; a texture hardly does
        grid = vdb.Vec3SGrid()
        grid.name = "velocity"
        grid.copyFromArray(speed, tolerance=(-1, -1, -1))
        vdb.write(str(self.folder / "even.vdb"), grid)
        sizes, arrays = {}, []
        for compression in "none", "blosc":
            path = self.outputs("vdblic_advect", "even.vdb", "-o", f"{compression}.vdb", "--carry", "velocity",
                                "--compression", compression)[0]
            sizes[compression] = path.stat().st_size
            arrays.append(values(path)[0].tobytes())
        self.assertEqual(len(set(arrays)), 1)
        self.assertLess(sizes["blosc"], 0.7 * sizes["none"])
        self.fails(2, "vdblic_advect", WAKE, "-o", "x.%04d.vdb", "--compression", "lzma")
        self.fails(2, "vdblic_advect", WAKE, "-o", "x.%04d.vdb", "--precision", "double")

    def test_scalars_on_the_textures_voxels(self):
        common = WAKE, "--frames", "3-3", "--bbox", 60, 10, 10, 90, 30, 30, "--refine", 2, 1, 3, "--precision", "float"
        coarse = self.outputs("vdblic_advect", *common, "-o", "coarse.%04d.vdb", "--carry", "velocity")[0]
        fine = self.outputs("vdblic_advect", *common, "-o", "fine.%04d.vdb", "--carry", "velocity", "--scalars",
                            "texture")[0]
        self.assertEqual(values(coarse)[0].tobytes(), values(fine)[0].tobytes())
        texture = vdb.read(str(fine), "density")
        magnitude = vdb.read(str(fine), "magnitude")
        self.assertEqual(magnitude.transform, texture.transform)
        self.assertEqual(magnitude.activeVoxelCount(), texture.activeVoxelCount())
        self.assertEqual(vdb.read(str(fine), "velocity").transform, vdb.read(str(WAKE) % 3, "velocity").transform)
        there, here = values(coarse, "magnitude")[0], values(fine, "magnitude")[0]
        for axis, factor in enumerate((2, 1, 3)):  # linear interpolation, continued at the rim
            at = numpy.clip((numpy.arange(there.shape[axis] * factor) + 0.5) / factor - 0.5, 0, there.shape[axis] - 1)
            low = numpy.minimum(at.astype(int), there.shape[axis] - 2)
            shape = [-1 if a == axis else 1 for a in range(3)]
            fraction = (at - low).reshape(shape)
            there = numpy.take(there, low, axis) * (1 - fraction) + numpy.take(there, low + 1, axis) * fraction
        numpy.testing.assert_allclose(here, there, rtol=1e-5)
        self.fails(2, "vdblic_advect", WAKE, "-o", "x.%04d.vdb", "--scalars", "both")

    def test_substeps(self):
        def run(name, *arguments, **options):
            paths = self.outputs("vdblic_advect", *arguments, "-o", f"{name}.%04d.vdb", "--life", 2, **options)
            return [path.name for path in paths], [vdb.readMetadata(str(path)) for path in paths]

        lines = "".join(f"{str(WAKE) % k}\n" for k in (13, 15))
        names, metadata = run("a", WAKE, "--frames", "13,15", "--substeps", 4, "--lead-in", 0)
        self.assertEqual(names, [f"a.{k:04}.vdb" for k in (13, 14, 15, 16, 21)])  # 15 is 13 + (15 - 13) 4
        for key, expected in (("frame", [13, 14, 15, 16, 21]), ("source_frame", [13, 13.5, 14, 14.5, 15]),
                              ("time", [0.6, 0.625, 0.65, 0.675, 0.7]), ("dt", 5 * [0.025]), ("substeps", 5 * [4])):
            numpy.testing.assert_allclose([m[key] for m in metadata], expected, rtol=1e-6, err_msg=key)
        self.assertEqual(run("b", "-", "--substeps", 4, stdin=lines)[0], [name.replace("a", "b", 1) for name in names])
        self.assertEqual(self.run_tool("vdblic_diff", "a.%04d.vdb", "b.%04d.vdb", "--ignore-metadata", "lead_in").returncode, 0)
        self.assertEqual(run("c", WAKE, "--frames", "7", "--substeps", 64)[0], ["c.0007.vdb"])
        # Scalars are those of the velocity between the frames.
        vectors = []
        for frame in 13, 15:
            grid = vdb.read(str(WAKE) % frame, "velocity")
            low, high = grid.evalActiveVoxelBoundingBox()
            vectors.append(numpy.zeros([*(high[i] - low[i] + 1 for i in range(3)), 3], numpy.float32))
            grid.copyToArray(vectors[-1], ijk=low)
        speed = numpy.linalg.norm(0.25 * vectors[0] + 0.75 * vectors[1], axis=3)
        numpy.testing.assert_allclose(values(self.folder / names[3], "magnitude")[0], speed, rtol=1e-3, atol=1e-3)
        for bad in 0, 257, "many":
            self.fails(2, "vdblic_advect", WAKE, "-o", "x.%04d.vdb", "--substeps", bad)
        self.fails(2, "vdblic_advect", WAKE, "-o", "x.vdb", "--frames", "1-2", "--substeps", 2)

    def test_substeps_of_frames_that_come_and_go(self):
        box = numpy.full((12, 12, 12, 3), 0.5, numpy.float32)
        for frame, origin in ((1, (0, 0, 0)), (2, None), (3, (4, 0, 0)), (4, (30, 0, 0))):
            grid = vdb.Vec3SGrid()
            grid.name = "velocity"
            if origin:
                grid.copyFromArray(box, ijk=origin, tolerance=(-1, -1, -1))
            vdb.write(str(self.folder / f"v.{frame:04}.vdb"), grid)
        paths = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "t.%04d.vdb", "--substeps", 3, "--dt", 1)
        counts = [vdb.read(str(path), "density").activeVoxelCount() for path in paths]
        self.assertEqual(counts, 3 * [1728] + 3 * [0] + 4 * [1728])
        again = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "u.%04d.vdb", "--substeps", 3, "--dt", 1,
                             "--refine", 2, "--threads", 1)
        self.assertEqual([vdb.read(str(path), "density").activeVoxelCount() for path in again],
                         3 * [8 * 1728] + 3 * [0] + 4 * [8 * 1728])

    def test_memory_is_told_and_checked_before_the_start(self):
        run = self.run_tool("vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "3-3", "--refine", 2)
        self.assertRegex(run.stderr, r"864896 texture voxels: about \d+\.\d MiB of memory")
        message = self.fails(4, "vdblic_advect", WAKE, "-o", "x.%04d.vdb", "--refine", 6, "--max-memory", "600M",
                             preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20,) * 2))
        self.assertRegex(message, r"\.: there is no room for a scratch file of .*: File too large; make room, or give "
                                  "another folder with --scratch")
        self.assertEqual([name for name in self.files() if name.startswith("x.")], [])

    def test_work_and_time_as_json(self):
        run = self.run_tool("vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "1-4", "--json", "run.json", "-v")
        self.assertEqual(run.returncode, 0, run.stderr)
        report = json.loads((self.folder / "run.json").read_text())
        self.assertEqual([frame["frame"] for frame in report["frames"]], [1, 2, 3, 4])
        for frame in report["frames"]:
            # Every voxel releases one seed: on a continuing pathline, downstream on a new one, or as a new one.
            self.assertEqual(frame["reused"] + frame["copied"] + frame["released"], frame["voxels"])
            self.assertGreater(frame["steps"], frame["went_on"])
            self.assertGreater(frame["deposits"], frame["voxels"])
            stages = ["read", "load", "scatter", "convolve", "filter", "write"]
            self.assertEqual(list(frame["seconds"]), stages)
            self.assertTrue(all(frame["seconds"][stage] > 0 for stage in stages), frame["seconds"])
        steps = [frame["steps"] / frame["voxels"] for frame in report["frames"]]
        self.assertAlmostEqual(report["steps_per_voxel"]["mean"], sum(steps) / 4, places=9)
        self.assertLess(report["steps_per_voxel"]["deviation"], 0.05 * sum(steps) / 4)
        self.assertIn("balance: ", run.stderr)
        for line in "plan: --frames 1-4 (given)", "plan: --preroll 4 (chosen)", "plan: --finish 2 (chosen)":
            self.assertIn(line, run.stderr)

    def test_a_report_that_cannot_be_written_fails_at_once(self):
        message = self.fails(4, "vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "1-2", "--json", "no/run.json")
        self.assertIn("no", message)
        self.assertEqual(self.files(), [])

    def test_same_voxels_for_any_number_of_threads(self):
        for method in "auflic", "uflic", "ibfv", "lea", "ufac":
            arrays = []
            for threads in 1, 2, 7:
                path = self.outputs("vdblic_advect", WAKE, "-o", f"{method}.{threads}.%04d.vdb", "--frames", "1-3",
                                    "--method", method, "--threads", threads)[-1]
                arrays.append(values(path)[0])
            self.assertEqual(arrays[0].tobytes(), arrays[1].tobytes())
            self.assertEqual(arrays[0].tobytes(), arrays[2].tobytes())

    def test_noise_from_a_file_is_the_noise_of_its_seed(self):
        self.outputs("vdblic_noise", "-o", "noise.vdb", "--like", str(WAKE) % 1, "--seed", "4")
        generated = self.outputs("vdblic_advect", WAKE, "-o", "a.%04d.vdb", "--frames", "1-1", "--seed", "4")[0]
        read = self.outputs("vdblic_advect", WAKE, "-o", "b.%04d.vdb", "--frames", "1-1", "--seed", "4",
                            "--noise", "noise.vdb")[0]
        other = self.outputs("vdblic_advect", WAKE, "-o", "c.%04d.vdb", "--frames", "1-1", "--seed", "5")[0]
        self.assertEqual(values(generated)[0].tobytes(), values(read)[0].tobytes())
        self.assertNotEqual(values(generated)[0].tobytes(), values(other)[0].tobytes())

    def test_paths_on_standard_input(self):
        named = self.outputs("vdblic_advect", WAKE, "-o", "a.%04d.vdb", "--frames", "14-16", "--lead-in", 0)
        lines = "".join(f"{str(WAKE) % k}\n" for k in (14, 15, 16))
        piped = self.outputs("vdblic_advect", "-", "-o", "b.%04d.vdb", stdin=lines)
        self.assertEqual([p.name for p in piped], [f"b.{k:04}.vdb" for k in (14, 15, 16)])
        for a, b in zip(named, piped):
            self.assertEqual(values(a)[0].tobytes(), values(b)[0].tobytes())

    def test_usage(self):
        output = ("-o", "lic.%04d.vdb")
        for arguments in (
            (), (WAKE,), output, (WAKE, *output, "--no-such-option"), (WAKE, *output, "--alpha", "0.2"),
            (WAKE, *output, "--method", "ibfv", "--alpha", "0"), (WAKE, *output, "--method", "ufac", "--alpha", "0.2"),
            (WAKE, *output, "--life", "0"), (WAKE, *output, "--life", "nan"), (WAKE, *output, "--dt", "0"),
            (WAKE, *output, "--dt", "nan"), (WAKE, *output, "--fps", "0"), (WAKE, *output, "--dt", "1", "--fps", "1"),
            (WAKE, *output, "--frames", "9-1"), (WAKE, *output, "--threads", "0"), (WAKE, *output, "--seed", "-1"),
            (WAKE, *output, "--release-window", "1.5"), (WAKE, *output, "--method", "auflic-2005"), (WAKE, "-o", "lic.vdb"),
            (WAKE, *output, "--velocity-unit", "knots"), (WAKE, *output, "--preroll", "-1"),
        ):
            with self.subTest(arguments=arguments):
                self.fails(2, "vdblic_advect", *arguments)
        self.assertEqual(self.files(), [])

    def test_two_outputs_of_one_name(self):
        for name in "lic.0003.vdb", "./checkpoint.0002.lic.vdb":
            message = self.fails(2, "vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "2-3", "--json", name)
            self.assertIn(name, message)
        self.assertEqual(self.files(), [])

    def test_bad_input(self):
        message = self.fails(3, "vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--frames", "15-17")
        self.assertIn("frame 17 is missing", message)
        self.fails(3, "vdblic_advect", "none.%04d.vdb", "-o", "lic.%04d.vdb")
        message = self.fails(3, "vdblic_advect", WAKE, "-o", "lic.%04d.vdb", "--velocity", "wind")
        self.assertIn("velocity (vec3s)", message)
        (self.folder / "vel.0001.vdb").write_bytes(b"not a vdb file")
        self.fails(3, "vdblic_advect", "vel.%04d.vdb", "-o", "lic.%04d.vdb")
        grid = vdb.Vec3SGrid()
        grid.name = "velocity"
        grid.fill((0, 0, 0), (7, 7, 7), (1, 0, 0))
        grid.getAccessor().setValueOn((3, 2, 1), (1, float("nan"), 0))
        vdb.write(str(self.folder / "nan.0001.vdb"), grids=[grid])
        message = self.fails(3, "vdblic_advect", "nan.%04d.vdb", "-o", "lic.%04d.vdb")
        for part in "nan.0001.vdb", "velocity", "1 voxel", "[3, 2, 1]":
            self.assertIn(part, message)
        self.assertEqual(self.files(), ["nan.0001.vdb", "vel.0001.vdb"])

    def test_unwritable_output(self):
        self.fails(4, "vdblic_advect", WAKE, "-o", "no/folder/lic.%04d.vdb", "--frames", "1-2")
        self.assertEqual(self.files(), [])


if __name__ == "__main__":
    unittest.main()
