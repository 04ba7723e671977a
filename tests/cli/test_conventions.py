"""vdblic_advect on the conventions of docs/formats.md, in files written by pyopenvdb."""

import math
import os
import pathlib
import re
import unittest

import numpy
import pyopenvdb as vdb

from support import ToolTest

SIZE = (26, 18, 14)
DATA = os.environ.get("VDBLIC_DATA")


def swirl(frame=1):
    """A rotating, drifting flow in voxels per second, a few voxels a frame at 24 fps."""
    x, y, z = numpy.meshgrid(*(numpy.arange(n, dtype=float) for n in SIZE), indexing="ij")
    x, y = x - 13, y - 9
    flow = numpy.stack([30 - 3 * y, 3 * x + 6 * math.sin(frame), 8 * numpy.sin(0.4 * x) + 2], axis=-1)
    return flow.astype(numpy.float32)


def vector_grid(array, name="velocity", first=(3, -5, 8)):
    grid = vdb.Vec3SGrid((0, 0, 0))
    grid.name = name
    grid.copyFromArray(numpy.ascontiguousarray(array), ijk=first, tolerance=(-1, -1, -1))
    return grid


def scalar_grid(array, name, first=(3, -5, 8)):
    grid = vdb.FloatGrid(0)
    grid.name = name
    grid.copyFromArray(numpy.ascontiguousarray(array), ijk=first, tolerance=-1)
    return grid


def texture(path, name="density"):
    grid = vdb.read(str(path), name)
    low, high = grid.evalActiveVoxelBoundingBox()
    array = numpy.zeros([h - l + 1 for l, h in zip(low, high)], numpy.float32)
    grid.copyToArray(array, ijk=low)
    return array


class Conventions(ToolTest):
    def write(self, name, *grids, **metadata):
        vdb.write(str(self.folder / name), grids=list(grids), metadata=metadata)

    def write_swirls(self, prefix, make, frames=range(1, 4)):
        for frame in frames:
            grids = make(swirl(frame))
            self.write(f"{prefix}.{frame:04}.vdb", *grids)

    def advect(self, prefix, *options):
        """Run on `prefix.%04d.vdb`; returns the outputs and the messages."""
        done = self.run_tool("vdblic_advect", f"{prefix}.%04d.vdb", "-o", f"{prefix}-lic.%04d.vdb", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [self.folder / line for line in done.stdout.splitlines()], done.stderr

    def last_texture(self, prefix, *options):
        return texture(self.advect(prefix, "--velocity-unit", "voxel/s", *options)[0][-1])

    def test_houdini_half_components_equal_their_float_vectors_within_half_rounding(self):
        def components(array):
            grids = [scalar_grid(array[..., axis], f"vel.{'xyz'[axis]}") for axis in range(3)]
            for grid in grids:
                grid.saveFloatAsHalf = True
            return grids

        self.write_swirls("vectors", lambda array: [vector_grid(array.astype(numpy.float16).astype(numpy.float32))])
        self.write_swirls("halves", components)
        vectors, halves = self.last_texture("vectors"), self.last_texture("halves")
        # Values that a half represents exactly: the same texture.
        self.assertEqual(vectors.tobytes(), halves.tobytes())
        # Rounded values: nearly the same texture.
        self.write_swirls("floats", lambda array: [vector_grid(array)])
        floats = self.last_texture("floats")
        self.assertGreater(numpy.corrcoef(floats.ravel(), halves.ravel())[0, 1], 0.99)

    def test_a_rotated_domain_gives_the_texture_of_the_unrotated_one(self):
        angle = 0.6
        c, s = math.cos(angle), math.sin(angle)
        turn = numpy.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])

        def rotated(array):
            grid = vector_grid((array @ turn.T * 0.1).astype(numpy.float32))
            # pyopenvdb multiplies rows: p' = p M
            matrix = numpy.eye(4)
            matrix[:3, :3] = turn.T * 0.1
            matrix[3, :3] = 5, 6, 7
            grid.transform = vdb.createLinearTransform(matrix.tolist())
            return [grid]

        self.write_swirls("straight", lambda array: [vector_grid(array)])
        self.write_swirls("turned", rotated)
        straight = self.last_texture("straight")
        turned = texture(self.advect("turned")[0][-1])
        # Products with a sine are rounded, so a few particles take up other voxels.
        self.assertGreater(numpy.corrcoef(straight.ravel(), turned.ravel())[0, 1], 0.98)

    def test_active_tiles_are_voxels(self):
        for frame in 1, 2:
            for name, sparse in ("tiles", True), ("voxels", False):
                grid = vdb.Vec3SGrid()
                grid.name = "v"
                grid.fill((0, 0, 0), (23, 15, 15), (1, 0.5, 0.25))
                if not sparse:
                    array = numpy.zeros((24, 16, 16, 3), numpy.float32)
                    grid.copyToArray(array)
                    grid = vector_grid(array, "v", (0, 0, 0))
                self.write(f"{name}.{frame:04}.vdb", grid)
        self.assertGreater(vdb.readAllGridMetadata(str(self.folder / "voxels.0001.vdb"))[0]["file_voxel_count"], 6000)
        tiles, voxels = (self.advect(n, "--velocity-unit", "voxel/frame")[0][-1] for n in ("tiles", "voxels"))
        self.assertEqual(texture(tiles).tobytes(), texture(voxels).tobytes())

    def test_frame_spacing_by_order_of_precedence(self):
        def spacing(prefix, *options):
            path = self.advect(prefix, *options)[0][0]
            return vdb.readMetadata(str(path))["dt"]

        for prefix, times, dt in ("both", (0.0, 0.5, 2.0), 0.125), ("dt", None, 0.125), ("none", None, None):
            for frame in 1, 2, 3:
                grid = vector_grid(swirl(frame) * 0.01)
                if times:
                    grid["time"] = times[frame - 1]
                if dt:
                    grid["dt"] = dt
                self.write(f"{prefix}.{frame:04}.vdb", grid)
        self.assertEqual(spacing("both", "--dt", "0.3"), 0.3)
        self.assertAlmostEqual(spacing("both", "--fps", "30"), 1 / 30)
        self.assertEqual(spacing("both"), 0.5)
        self.assertEqual(spacing("dt"), 0.125)
        self.assertAlmostEqual(spacing("none"), 1 / 24)
        self.assertIn("24 frames a second", self.advect("none")[1])
        # Selecting fewer frames lengthens the time step.
        self.assertEqual(spacing("dt", "--frames", "1-3x2"), 0.25)
        self.assertEqual(spacing("both", "--frames", "1-3x2"), 2.0)
        # Frames with different intervals.
        dts = [vdb.readMetadata(str(p))["dt"] for p in self.advect("both")[0]]
        self.assertEqual(dts, [0.5, 1.5, 1.5])

    def test_a_dt_that_is_no_time(self):
        """Every tool that reads it says so once, with file, grid, value and mend."""
        for value, words in ((0.0, "dt 0,"), (-1.0, "dt -1,"), (float("nan"), "dt nan,"), (float("inf"), "dt inf,"), (0, "dt 0,"),
                             (1e300, r"dt 1e\+300,"), ("1/25 s\x1b", r"dt (?:1/25 s\\x1b|nan),"), (True, "dt (?:true|nan),")):
            grid = vector_grid(swirl(1) * 0.01)
            grid["dt"] = value
            for frame in 1, 2, 3:
                self.write(f"odd.{frame:04}.vdb", grid)
            tools = (("vdblic_advect", "odd.%04d.vdb", "-o", "odd-lic.%04d.vdb"), ("vdblic_info", "odd.%04d.vdb"),
                     ("vdblic_coherence", "odd.%04d.vdb", "odd-lic.%04d.vdb", "--samples", 100),
                     ("vdblic_film", "odd.%04d.vdb", "-o", "odd.png", "--size", 24, 16))
            for tool in tools if value == -1 else tools[:3]:
                with self.subTest(value=value, tool=tool):
                    done = self.run_tool(*tool)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    said = re.findall(f".*odd.000[12].vdb: grid 'velocity' has the {words} which is no number of seconds.*",
                                      done.stderr)
                    self.assertEqual(len(said), 1, done.stderr)
                    self.assertRegex(said[0], "24 frames a second|taking 0.0416667 s")
                    self.assertRegex(said[0], "(give|takes) --dt")
                    self.assertNotIn("no time or dt", done.stderr)
                    self.assertNotIn("\x1b", done.stderr)
            for path in self.folder.glob("odd*"):
                path.unlink()

    def test_times_that_do_not_rise(self):
        for frame, time in (1, 2.0), (2, 2.0):
            grid = vector_grid(swirl(frame) * 0.01)
            grid["time"] = time
            self.write(f"still.{frame:04}.vdb", grid)
        words = "still.0002.vdb: its time 2 does not come after the time 2 of the frame before; give the frame spacing"
        self.assertIn(words, self.fails(3, "vdblic_advect", "still.%04d.vdb", "-o", "out.%04d.vdb"))
        self.assertIn(words[:-18], self.run_tool("vdblic_info", "still.%04d.vdb").stderr)

    def test_a_flow_of_many_voxels_a_step_is_warned_of(self):
        self.write_swirls("fast", lambda array: [vector_grid(array)])
        self.assertIn("voxels a step", self.advect("fast", "--velocity-scale", "10")[1])
        self.assertNotIn("voxels a step", self.advect("fast")[1])

    def test_the_transform_may_not_change(self):
        def write(prefix, mantaflow):
            for frame, size in (1, 0.1), (2, 0.15):
                grid = vector_grid(swirl(frame))
                grid.transform = vdb.createLinearTransform(size)
                if mantaflow:
                    grid.gridClass = vdb.GridClass.STAGGERED
                    grid["file_base_resolution"] = (26, 18, 14)
                self.write(f"{prefix}.{frame:04}.vdb", grid)

        write("moved", False)
        message = self.fails(3, "vdblic_advect", "moved.%04d.vdb", "-o", "lic.%04d.vdb", "--preroll", "0")
        self.assertIn("moved.0002.vdb", message)
        write("adaptive", True)
        message = self.fails(3, "vdblic_advect", "adaptive.%04d.vdb", "-o", "lic.%04d.vdb")
        self.assertIn("adaptive domain", message)

    def test_an_empty_frame_in_the_middle(self):
        self.write_swirls("gap", lambda array: [vector_grid(array)], range(1, 5))
        empty = vdb.Vec3SGrid()
        empty.name = "velocity"
        self.write("gap.0003.vdb", empty)
        paths, messages = self.advect("gap", "--velocity-unit", "voxel/s")
        self.assertEqual([vdb.read(str(p), "density").activeVoxelCount() for p in paths], [6552, 6552, 0, 6552])
        self.assertIn("frame 3", messages)
        self.assertIn("empty", messages)

    def test_frames_beyond_the_files(self):
        self.write_swirls("v", lambda array: [vector_grid(array)], (4, 5, 6))
        message = self.fails(3, "vdblic_advect", "v.%04d.vdb", "-o", "l.%04d.vdb", "--frames", "1-9")
        self.assertIn("frame 1 is missing", message)
        self.assertIn("--clamp-frames", message)
        paths, _ = self.advect("v", "--frames", "1-9", "--clamp-frames", "--velocity-unit", "voxel/s")
        self.assertEqual([p.name for p in paths], [f"v-lic.000{k}.vdb" for k in (4, 5, 6)])

    def test_a_part_of_a_sequence(self):
        """Earlier frames lead in, the frame after the last ends its step: the textures are those of the whole run."""
        self.write_swirls("v", lambda array: [vector_grid(array * 0.3)], range(1, 8))
        for frame in range(1, 8):
            mask = vdb.BoolGrid()
            mask.name = "mask"
            mask.fill((3, -5, 8), (28, 12, 12 + frame % 3), True)
            self.write(f"m.{frame:04}.vdb", mask)
        for options in ((), ("--mask", "m.%04d.vdb"), ("--dt", 0.02, "--substeps", 2), ("--method", "lic")):
            options = ("--velocity-unit", "voxel/s", *options)
            whole = {path.name[-8:]: path.read_bytes() for path in self.advect("v", *options)[0]}
            for frames in ("1-3", "1", "3-5", "5", "6-7") if "--substeps" not in options else ("1-3", "1"):
                paths, _ = self.advect("v", "--frames", frames, *options)
                for path in paths:
                    self.assertEqual(path.read_bytes(), whole[path.name[-8:]], (frames, options, path))
        # In the middle of a longer sequence the lead-in stands in for the preroll.
        path, = self.advect("v", "--frames", "6", "--lead-in", "2")[0]
        metadata = vdb.readMetadata(str(path))
        self.assertEqual((metadata["lead_in"], metadata["preroll"]), (2, 0))
        _, messages = self.advect("v", "--frames", "6", "--lead-in", "2")
        self.assertIn("frames 4 to 5 are computed first and not written; with --lead-in 5 the textures would be those of a "
                      "run over all frames", messages)
        for options, expected in ((("--lead-in", 0), (0, 4)), (("--lead-in", 2, "--preroll", 3), (2, 3))):
            metadata = vdb.readMetadata(str(self.advect("v", "--frames", "6", *options)[0][0]))
            self.assertEqual((metadata["lead_in"], metadata["preroll"]), expected)
        # A damaged frame after the last is not needed.
        damaged = self.folder / "v.0004.vdb"
        damaged.write_bytes(damaged.read_bytes()[:-50])
        self.assertRegex(self.advect("v", "--frames", "2-3")[1], "warning: v.0004.vdb.*; frame 4 is not used")

    def test_paths_on_standard_input(self):
        for hour in range(3):
            self.write(f"wrfout_d01_2005-08-28_0{hour}:00:00", vector_grid(swirl(hour)))
            self.write(f"v.{hour:04}.vdb", vector_grid(swirl(hour)))
        dated = [f"wrfout_d01_2005-08-28_0{hour}:00:00" for hour in range(3)]
        for tool, output in ("vdblic_advect", "l.%04d.vdb"), ("vdblic_render", "l.%04d.png"):
            message = self.fails(3, tool, "-", "-o", output, stdin="\n".join(dated))
            self.assertIn(f"{dated[0]}: the name does not end in a frame number; --renumber START", message)
            self.assertIn("standard input named none", self.fails(3, tool, "-", "-o", output))
            self.assertIn("a pattern has the numbers", self.fails(2, tool, "v.%04d.vdb", "-o", output, "--renumber", 3))
        for separator in "\n", "\r\n", "\r", "\0":
            paths = self.outputs("vdblic_advect", "-", "-o", "l.%04d.vdb", "--renumber", -1, stdin=separator.join(dated))
            self.assertEqual([path.name for path in paths], ["l.-001.vdb", "l.0000.vdb", "l.0001.vdb"])
            paths = self.outputs("vdblic_advect", "-", "-o", "l.%04d.vdb",
                                 stdin="".join(f"v.{frame:04}.vdb{separator}" for frame in range(3)))
            self.assertEqual([path.name for path in paths], ["l.0000.vdb", "l.0001.vdb", "l.0002.vdb"])

    def test_names_as_they_come(self):
        names = {"shot [v2] a.-001.vdb": "shot [v2] a.%04d.vdb", "take2_run3_1.vdb": "take2_run3_#.vdb",
                 "wide000000007.vdb": "wide@@@@@@@@@.vdb", "12345.vdb": "<F4>.vdb", "f0012.vdb": "f$F4.vdb"}
        for name, pattern in names.items():
            self.write(name, vector_grid(swirl()))
            path = self.outputs("vdblic_advect", pattern, "-o", "out.%d.vdb", "--velocity-unit", "voxel/s")[0]
            number = int(name.rsplit(".", 1)[0].split("_")[-1].split(".")[-1].lstrip("wideaf"))
            self.assertEqual(path.name, f"out.{number}.vdb")

    def test_carry(self):
        density = scalar_grid(numpy.full(SIZE, 0.75, numpy.float32), "density")
        heat = scalar_grid(numpy.full(SIZE, 2.5, numpy.float32), "heat")
        self.write("v.0001.vdb", density, heat, vector_grid(swirl()))
        path = self.advect("v", "--carry", "density,heat", "--texture-name", "lic")[0][0]
        self.assertEqual({g.name for g in vdb.readAllGridMetadata(str(path))}, {"lic", "magnitude", "density", "heat"})
        self.assertEqual(vdb.read(str(path), "heat").getConstAccessor().getValue((5, 0, 10)), 2.5)
        self.fails(2, "vdblic_advect", "v.%04d.vdb", "-o", "l.%04d.vdb", "--carry", "density")
        self.fails(3, "vdblic_advect", "v.%04d.vdb", "-o", "l.%04d.vdb", "--carry", "fuel")

    def test_mask_and_boxes(self):
        self.write("v.0001.vdb", vector_grid(swirl()))
        mask = vdb.BoolGrid()
        mask.name = "keep"
        mask.fill((5, -3, 9), (8, 0, 10), True)
        self.write("mask.vdb", mask)
        for options, voxels in ((("--mask", "mask.vdb:keep"), 32), (("--bbox", 5, -3, 9, 5, 0, 10), 8),
                                (("--bbox-world", 4.9, -3.1, 8.9, 6.1, -1.9, 9.1), 4)):
            path = self.advect("v", *options)[0][0]
            self.assertEqual(vdb.read(str(path), "density").activeVoxelCount(), voxels)
        self.fails(2, "vdblic_advect", "v.%04d.vdb", "-o", "l.%04d.vdb", "--bbox", 5, 0, 0, 4, 0, 0)
        self.fails(3, "vdblic_advect", "v.%04d.vdb", "-o", "l.%04d.vdb", "--mask", "none.vdb")

    def test_where_a_file_came_from(self):
        self.write("v.0001.vdb", vector_grid(swirl()), creator="Houdini/SOP_OpenVDB")
        metadata = vdb.readMetadata(str(self.advect("v")[0][0]))
        self.assertEqual(metadata["source_creator"], "Houdini/SOP_OpenVDB")
        self.assertTrue(metadata["creator"].startswith("VDBLIC"))

    def test_dates_and_lengths_reach_the_textures(self):
        for place in "file", "grid":
            grid, metadata = vector_grid(swirl()), {"start": "2005-08-28T12:00:00", "length_unit": "m"}
            for key, value in (metadata if place == "grid" else {}).items():
                grid[key] = value
            self.write("v.0001.vdb", grid, **(metadata if place == "file" else {}))
            texture = self.advect("v")[0][0]
            found = vdb.readMetadata(str(texture))
            self.assertEqual((found["start"], found["length_unit"]), ("2005-08-28T12:00:00", "m"))
            pictures = [self.rendered("v-lic.0001.vdb", annotation) for annotation in ("time", "colorbar", "axes")]
            found = vdb.readMetadata(str(self.advect("v", "--dt", 1)[0][0]))  # the times are no longer the files'
            self.assertNotIn("start", found)
            self.write("v.0001.vdb", vector_grid(swirl()))
            self.advect("v")
            for picture, annotation in zip(pictures, ("time", "colorbar", "axes")):
                self.assertNotEqual(self.rendered("v-lic.0001.vdb", annotation), picture, annotation)

    def rendered(self, name, annotation):
        path, = self.outputs("vdblic_render", name, "-o", "i.png", "--size", 200, 200, "--annotate", annotation)
        return path.read_bytes()

    def test_skip_existing(self):
        self.write_swirls("v", lambda array: [vector_grid(array)])
        self.advect("v", "--velocity-unit", "voxel/s")
        runs = (("vdblic_render", "v-lic.%04d.vdb", "-o", "r.%04d.png", "--size", 32, 32),
                ("vdblic_diff", "v-lic.%04d.vdb", "v-lic.%04d.vdb", "-o", "d.%04d.vdb"),
                ("vdblic_noise", "--size", 8, 8, 8, "-o", "n.vdb"))
        for run in runs:
            first = self.outputs(*run)
            whole, other = [path.read_bytes() for path in first], first[0].read_bytes()
            if len(first) == 1:
                other = self.outputs(*run, "--seed", 7)[0].read_bytes()
                self.assertNotEqual(other, whole[0])
            first[0].unlink()
            first[-1].write_bytes(other)
            self.assertEqual(self.outputs(*run, "--skip-existing"), first)
            self.assertEqual(first[-1].read_bytes(), other)
            for damaged in b"", b"no volume", whole[-1][:-20]:
                first[-1].write_bytes(damaged)
                done = self.run_tool(*run, "--skip-existing")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertRegex(done.stderr, f"warning: {first[-1].name}: .*made again")
                self.assertEqual(first[-1].read_bytes(), whole[-1])

    def test_a_frame_rendered_alone_is_the_frame_of_the_sequence(self):
        self.write_swirls("v", lambda array: [vector_grid(array)])
        self.advect("v", "--velocity-unit", "voxel/s")
        render = ("vdblic_render", "v-lic.%04d.vdb", "--size", 48, 32)
        self.outputs(*render, "-o", "all.%04d.png")
        self.outputs(*render, "-o", "one.%04d.png", "--frames", "3")
        self.assertEqual(self.contents("all.0003.png"), self.contents("one.0003.png"))


@unittest.skipUnless(DATA, "VDBLIC_DATA does not name the folder of the large data sets")
class RealData(ToolTest):
    def test_every_set_runs_without_options(self):
        for pattern, frames in (("wake/wake.%04d.vdb", 28), ("era5_west_europe/era5.%04d.vdb", 24),
                                ("katrina_wrf/katrina.%04d.vdb", 4), ("mantaflow_drift/fluid_data_%04d.vdb", 26)):
            done = self.run_tool("vdblic_advect", pathlib.Path(DATA) / pattern, "-o", "lic.%04d.vdb")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(len(done.stdout.splitlines()), frames)
            self.assertEqual("voxels a step" in done.stderr, "katrina" in pattern)


if __name__ == "__main__":
    unittest.main()
