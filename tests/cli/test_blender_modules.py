"""What the Blender add-on knows without Blender: headers of files, sequences, commands, runs in the background."""

import importlib
import os
import re
import sys
import time
import tomllib
import types
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, SOURCE, ToolTest

FOLDER = SOURCE / "tools/blender/vdblic_blender"
package = types.ModuleType("vdblic_blender")  # whose own __init__ needs Blender
package.__path__ = [str(FOLDER)]
sys.modules["vdblic_blender"] = package
headers, sequences, commands, jobs, tools, mantaflow, looks, usd_lines = (
    importlib.import_module(f"vdblic_blender.{name}")
    for name in ("vdb_header", "sequences", "commands", "jobs", "tools", "mantaflow", "looks", "usd_lines")
)


class Modules(ToolTest):
    def test_versions_agree(self):
        project = re.search(r"project\(vdblic VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text())[1]
        manifest = tomllib.loads((FOLDER / "blender_manifest.toml").read_text())
        legacy = re.search(r'"version": \((.*)\)', (FOLDER / "__init__.py").read_text())[1].replace(", ", ".")
        self.assertEqual({tools.VERSION, manifest["version"], legacy}, {project})

    def test_headers_are_those_of_openvdb(self):
        half = 0.5**0.5
        rows = {
            "uniform": vdb.createLinearTransform(0.25),
            "scaled": vdb.createLinearTransform([[0.1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1]]),
            "moved": vdb.createLinearTransform([[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [1, -2, 5, 1]]),
            "turned": vdb.createLinearTransform([[half, half, 0, 0], [-half, half, 0, 0], [0, 0, 1, 0], [7, 8, 9, 1]]),
            "mirrored": vdb.createLinearTransform([[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
        }
        grids = []
        for name, transform in rows.items():
            grid = vdb.FloatGrid() if name != "moved" else vdb.Vec3SGrid()
            grid.fill((-3, 2, 1), (11, 9, 5), 1 if name != "moved" else (1, 2, 3))
            grid.name, grid.transform = name, transform
            grids.append(grid)
        vdb.write(
            str(self.folder / "a.vdb"),
            grids=grids,
            metadata={"inactive": "empty", "dt": 0.5, "n": 7, "texture": "turned"},
        )
        header = headers.read_header(self.folder / "a.vdb")
        self.assertEqual(
            (header.metadata["dt"], header.metadata["n"], header.is_sparse, header.texture), (0.5, 7, True, "turned")
        )
        for grid in header.grids:
            expected = rows[grid.name].indexToWorld((3.0, -4.0, 6.0))
            numpy.testing.assert_allclose(grid.to_world((3, -4, 6)), expected, atol=1e-12)
            self.assertEqual(grid.is_mirrored, grid.name == "mirrored")
            self.assertEqual(grid.box, ((-3, 2, 1), (11, 9, 5)))
        self.assertEqual(header.scalars, ["uniform", "scaled", "turned", "mirrored"])
        data = self.contents("a.vdb")
        for size in range(0, len(data), 97):
            (self.folder / "cut.vdb").write_bytes(data[:size])
            with self.assertRaisesRegex(headers.DamagedFile, "cut.vdb: this is no whole .vdb file"):
                headers.read_header(self.folder / "cut.vdb")

    def test_a_dt_that_is_no_time(self):
        grid = vdb.FloatGrid()
        for told in 0.0, -1.0, float("nan"), float("inf"), 0, True, "1/24 s", (1, 2, 3):
            vdb.write(str(self.folder / "odd.vdb"), grids=[grid], metadata={"dt": told})
            self.assertIsNone(headers.read_header(self.folder / "odd.vdb").dt, told)
        vdb.write(str(self.folder / "odd.vdb"), grids=[grid], metadata={"dt": 0.25})
        self.assertEqual(headers.read_header(self.folder / "odd.vdb").dt, 0.25)

    def test_our_textures(self):
        self.outputs("vdblic_synth", "ring", "-o", "v.vdb", "--size", 12, 12, 12, "--frames", 1)
        for name, *options in ("lic", "--refine", 2), ("s", "--method", "streaks", "--spacing", 3, "--refine", 3):
            self.outputs("vdblic_advect", "v.vdb", "-o", f"{name}.vdb", *options)
        dense, sparse = (headers.read_header(self.folder / f"{name}.vdb") for name in ("lic", "s"))
        self.assertEqual(
            (dense.texture, dense.scalars, dense.refinement), ("density", ["density", "magnitude"], (2, 2, 2))
        )
        self.assertEqual(
            (looks.kind_of(dense), looks.kind_of(sparse), sparse.refinement), ("DENSE", "STREAKS", (3, 3, 3))
        )

    def test_sequences(self):
        folder = self.folder / "Träger raum"
        folder.mkdir()
        for name in (
            "a.0008.vdb",
            "a.0009.vdb",
            "a.0010.vdb",
            "b_7.vdb",
            "b_8.vdb",
            "still.vdb",
            "gap.1.vdb",
            "gap.3.vdb",
        ):
            (folder / name).touch()
        found = sequences.sequence_of(folder / "a.0009.vdb")
        self.assertEqual(
            (found.first, found.last, [path.name for path in found.files]),
            (8, 10, ["a.0008.vdb", "a.0009.vdb", "a.0010.vdb"]),
        )
        self.assertEqual(sequences.sequence_of(folder / "still.vdb").first, None)
        for name, pattern, frames in (("a.0009.vdb", "a.%04d.vdb", [8, 9, 10]), ("b_7.vdb", "b_%d.vdb", [7, 8])):
            self.assertEqual(sequences.pattern_of(folder / name), str(folder / pattern))
            self.assertEqual(sequences.frames_of(folder / pattern), frames)
        with self.assertRaisesRegex(sequences.SequenceError, "frame 2 is missing"):
            sequences.sequence_of(folder / "gap.1.vdb")

    def test_commands_and_estimates(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 24, 24, 24, "--frames", "1-3")
        pattern = str(self.folder / "v.%04d.vdb")
        recipe = commands.Recipe(
            pattern,
            str(self.folder / "out"),
            "STREAKS",
            3,
            2,
            "1-2",
            box=(0, 0, 0, 1, 1, 1),
            derived=("q",),
            about_velocity=("--fps", "25"),
        )
        self.assertEqual(
            recipe.command(),
            [
                pattern,
                "-o",
                str(self.folder / "out/streaks.%04d.vdb"),
                "--resume",
                "--method",
                "streaks",
                "--spacing",
                "3",
                "--refine",
                "2",
                "--frames",
                "1-2",
                "--clamp-frames",
                "--bbox-world",
                "0",
                "0",
                "0",
                "1",
                "1",
                "1",
                "--with",
                "q",
                "--fps",
                "25",
            ],
        )
        (self.folder / "out").mkdir()
        self.outputs("vdblic_advect", *recipe.command())
        dense = [commands.estimate(commands.Recipe(pattern, "", "DENSE", refine=n), str(BIN)) for n in (1, 2)]
        self.assertEqual([estimate.voxels for estimate in dense], [24**3, 48**3])
        self.assertAlmostEqual(dense[1].seconds / dense[0].seconds, 8)
        self.assertTrue(dense[0].memory < dense[1].memory < 8 * dense[0].memory)
        thin, thick = (commands.estimate(commands.Recipe(pattern, "", "STREAKS", n), str(BIN)) for n in (2, 6))
        self.assertGreater(thin.seconds, thick.seconds)
        self.assertRegex(str(thick), "^3 frames, about 60 streaks: ")  # of 24³ voxels, each 6³
        with self.assertRaisesRegex(tools.ToolError, "no file matches"):
            commands.estimate(commands.Recipe(str(self.folder / "none.%04d.vdb"), ""), str(BIN))

    def test_lines_of_a_layer(self):
        """What a layer has is read frame by frame; what is no layer of lines is told."""
        if os.environ["VDBLIC_SANITIZED"] == "1" or not (BIN / "vdblic_export").exists():
            self.skipTest("vdblic_export is not built, or sanitized, which needs a sanitized Python")
        sys.path.insert(0, str(BIN.parent / "python"))
        from vdblic._core import read_lines

        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 24, 24, 24, "--frames", "1-3")
        recipe = commands.Recipe(str(self.folder / "v.%04d.vdb"), str(self.folder), "STREAKS", 4, 3, "1-3", lines=True)
        files = self.outputs("vdblic_advect", *recipe.command())
        self.outputs("vdblic_export", *recipe.export(), "--stretch", 1, 1, 2)
        layer = usd_lines.Layer(recipe.layer)
        self.assertEqual((layer.frames, layer.span, layer.is_y_up, layer.scale), ([1, 2, 3], (1, 3), False, (1, 1, 2)))
        self.assertEqual([layer.sample_at(frame) for frame in (-5, 1, 2, 7)], [1, 1, 2, 3])
        for frame, file in enumerate(files, 1):
            moment, truth = layer.moment(frame), read_lines(file)[0]
            numpy.testing.assert_array_equal(moment.counts, truth["counts"])
            numpy.testing.assert_allclose(moment.points, truth["points"], rtol=1e-6)
            numpy.testing.assert_allclose(moment.radius, truth["radius"], rtol=1e-5)
            numpy.testing.assert_allclose(moment.scalars["q"], truth["scalars"]["q"], rtol=1e-5)
            numpy.testing.assert_allclose(moment.scalars["displayOpacity"], truth["opacity"], atol=1e-6)
        self.outputs("vdblic_export", "lines.0002.vdb", "-o", "one.usda", "--up", "y")
        one = usd_lines.Layer(self.folder / "one.usda")
        self.assertEqual((one.frames, one.span[0], one.is_y_up), ([], 2, True))
        self.assertEqual(len(one.moment(one.sample_at(9)).counts), len(layer.moment(2).counts))
        text = (self.folder / "one.usda").read_text()
        for change, told in (("points = ", "no lines"), ("widths = ", "no 'widths'"), ("[(", "do not have the points")):
            by = "[(0, 0, 0), (" if change == "[(" else f"x{change}"
            (self.folder / "wrong.usda").write_text(text.replace(change, by))
            with self.assertRaisesRegex(usd_lines.LayerError, f"wrong.usda: .*{told}"):
                wrong = usd_lines.Layer(self.folder / "wrong.usda")
                wrong.moment(wrong.sample_at(2))

    def wait(self, job):
        while job.state == jobs.RUNNING:
            time.sleep(0.02)
        return job.state

    def test_runs_are_cancelled_resumed_and_found_again(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 32, 32, 32, "--frames", "1-8")
        folder = self.folder / "out"
        recipe = commands.Recipe(str(self.folder / "v.%04d.vdb"), str(folder), "DENSE", refine=2)
        command = [str(BIN / "vdblic_advect"), *recipe.command()]
        job = jobs.Job.start(folder, [command], 8, recipe.output)
        with self.assertRaisesRegex(jobs.JobError, "already going on"):
            jobs.Job.start(folder, [command], 8, recipe.output)
        while len(job.finished) < 2:
            time.sleep(0.01)
        jobs.Job(folder).cancel()
        self.assertEqual(self.wait(jobs.Job(folder)), jobs.STOPPED)
        self.assertTrue((folder / "checkpoint.lic.vdb").is_file())
        first = self.contents("out/lic.0001.vdb")
        job = jobs.Job.start(folder, [command], 8, recipe.output)
        self.assertEqual(self.wait(job), jobs.DONE)
        self.assertEqual((len(job.finished), self.contents("out/lic.0001.vdb")), (8, first))
        self.assertFalse(jobs.Job(self.folder).is_known)

    def test_what_fails_is_told_once(self):
        job = jobs.Job.start(self.folder / "out", [[str(BIN / "vdblic_advect"), "none.vdb", "-o", "x.vdb"]], 1, "x.vdb")
        self.assertEqual(self.wait(job), jobs.FAILED)
        self.assertRegex(job.message, "^vdblic_advect: none.vdb: no such file")
        (self.folder / "file").touch()
        with self.assertRaisesRegex(jobs.JobError, "a run cannot be begun"):
            jobs.Job.start(self.folder / "file", [["true"]], 1, "x.vdb")
        with self.assertRaisesRegex(tools.ToolError, "not found in"):
            tools.check_tools(str(self.folder))
        self.assertIn("1.0.0, in", tools.check_tools(str(BIN)))

    def test_caches(self):
        take = lambda **changes: mantaflow.cache_of(
            **{
                "name": "Box",
                "folder": self.folder,
                "data_format": "OPENVDB",
                "is_adaptive": False,
                "time_scale": 0.5,
                "rate": 25,
            }
            | changes
        )
        with self.assertRaisesRegex(mantaflow.NotBaked, "Box: not baked"):
            take()
        (self.folder / "data").mkdir()
        grid = vdb.Vec3SGrid()
        grid.fill((0, 0, 0), (4, 4, 4), (1, 0, 0))
        grid.name = "velocity"
        for frame in 1, 2:
            vdb.write(str(self.folder / f"data/fluid_data_{frame:04}.vdb"), grids=[grid])
        cache = take()
        self.assertEqual((cache.frames, cache.options), ([1, 2], ["--fps", "25", "--velocity-scale", "0.5"]))
        with self.assertRaisesRegex(mantaflow.NotBaked, "adaptive"):
            take(is_adaptive=True)
        with self.assertRaisesRegex(mantaflow.NotBaked, "OpenVDB's format"):
            take(data_format="UNI")


if __name__ == "__main__":
    unittest.main()
