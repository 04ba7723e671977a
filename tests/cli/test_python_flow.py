"""The Python module's streams that are interrupted, or shared by ranks of mpi4py, and its streaks."""

import datetime
import os
import pathlib
import pickle
import shutil
import subprocess
import sys
import unittest

import numpy

from support import BIN, MPI_ENVIRONMENT, ToolTest, skip

MODULE = BIN.parent / "python"
if os.environ.get("VDBLIC_SANITIZED") == "1":
    skip("a sanitized module needs a sanitized Python")
if not list(MODULE.glob("vdblic/_core*.so")):
    skip("the module is not built, because pybind11 is missing")
sys.path.insert(0, str(MODULE))
import vdblic  # pylint: disable=wrong-import-position

SIZE = 24, 20, 16
START = datetime.datetime(2026, 2, 28, 23, 59, 59, 123456)


def fields(count, size=SIZE):
    """The velocities of a known flow, with their times."""
    return [(volume.time, volume["velocity"].values) for volume in vdblic.synth("abc", size, range(1, count + 1))]


def pushed(flow, frames):
    """The textures of a stream that is not closed."""
    return [texture for time, values in frames for texture in flow.push(values, time)]


class FlowTest(ToolTest):
    def assert_same(self, made, expected):
        self.assertEqual(len(made), len(expected))
        for texture, known in zip(made, expected):
            self.assertEqual(texture.metadata, known.metadata)
            self.assertEqual(list(texture), list(known))
            for name in known:
                self.assertEqual(texture[name].values.tobytes(), known[name].values.tobytes())
                self.assertEqual(texture[name].active.tobytes(), known[name].active.tobytes())
                self.assertEqual(texture[name].origin, known[name].origin)
                self.assertEqual(texture[name].metadata, known[name].metadata)


class Checkpoints(FlowTest):
    def test_a_resumed_stream_goes_on_as_if_it_had_not_ended(self):
        dated = [(START + datetime.timedelta(hours=number), values / 1e5) for number, (_, values) in enumerate(fields(6))]
        timed, untimed = fields(6), [(None, values) for _, values in fields(6)]
        for options, frames in (({"refine": 2, "with_": "q"}, timed), ({"substeps": 3}, dated), ({"method": "lea"}, timed),
                                ({"method": "streaks", "refine": 3}, timed), ({"dt": 0.1}, untimed)):
            with self.subTest(options=options):
                whole = vdblic.Flow(voxel_size=0.1, **options)
                expected = pushed(whole, frames) + whole.close()
                flow = vdblic.Flow(voxel_size=0.1, **options)
                made = pushed(flow, frames[:4])
                flow.save(self.folder / "flow.vdb")
                pushed(flow, frames[4:5])  # which the resumed one makes again
                flow.close()
                flow = vdblic.Flow(voxel_size=0.1, resume=self.folder / "flow.vdb", **options)
                made += pushed(flow, frames[3:5])
                flow.save(self.folder / "flow.vdb")
                flow = vdblic.Flow(voxel_size=0.1, resume=str(self.folder / "flow.vdb"), **options)
                made += pushed(flow, frames[4:]) + flow.close()
                self.assert_same(made, expected)
                self.assertEqual(self.files(), ["flow.vdb"])

    def test_mistakes(self):
        path, frames = self.folder / "flow.vdb", fields(4)
        with vdblic.Flow() as flow:
            pushed(flow, frames[:1])
            with self.assertRaisesRegex(ValueError, "no step to save; the second frame makes the first one"):
                flow.save(path)
            pushed(flow, frames[1:3])
            with self.assertRaisesRegex(OSError, "no/flow.vdb"):
                flow.save(self.folder / "no/flow.vdb")
            flow.save(path)
        with self.assertRaisesRegex(ValueError, "the flow is closed"):
            flow.save(path)
        with self.assertRaisesRegex(ValueError, "none.vdb: no such file"):
            vdblic.Flow(resume=self.folder / "none.vdb")
        with vdblic.Flow(resume=path) as flow, self.assertRaisesRegex(
                ValueError, r"goes on from velocity 3 at 0\.0833\d*; push its velocity first, not velocity 3 at 0\.125"):
            pushed(flow, frames[3:])
        with vdblic.Flow(resume=path, life=3) as flow, self.assertRaisesRegex(ValueError, "`life` 4, this one has `life` 3"):
            pushed(flow, frames[2:])
        vdblic.write(self.folder / "other.vdb", {"velocity": frames[0][1]})
        with self.assertRaisesRegex(ValueError, "other.vdb: is no checkpoint that Flow.save"):
            vdblic.Flow(resume=self.folder / "other.vdb")
        with vdblic.Flow() as flow:
            pushed(flow, frames[:3])
            with self.assertRaisesRegex(OSError, "other.vdb: is no checkpoint, and one would replace it"):
                flow.save(self.folder / "other.vdb")


RANKS = """
import pickle, sys
import numpy
from mpi4py import MPI
import vdblic

comm = MPI.COMM_WORLD
options, frames, save, resume = pickle.load(open("given", "rb"))
size = frames[0][1].shape[0]
first, end = (size * part // comm.size for part in (comm.rank, comm.rank + 1))
textures = []
with vdblic.Flow(voxel_size=0.1, comm=comm, origin=(first, 0, 0), resume=resume, **options) as flow:
    for time, values in frames:
        textures += flow.push(values[first:end], time)
    if save:
        flow.save(save)
    textures += flow.close()
if comm.rank == 0:
    pickle.dump([(t.metadata, [vars(grid) for grid in t.grids]) for t in textures], open("made", "wb"))
    for number, texture in enumerate(textures):
        vdblic.write(f"made.{number}.vdb", texture)
else:
    assert textures == []
"""
ENVIRONMENT = MPI_ENVIRONMENT | {"PYTHONPATH": str(MODULE)}


def lacking():
    """What this system lacks for ranks; empty if nothing."""
    if not shutil.which("mpirun"):
        return "mpirun is not installed"
    has = subprocess.run(["/usr/bin/python3", "-c", "import mpi4py"], capture_output=True).returncode == 0
    return "" if has else "mpi4py is not installed"


@unittest.skipIf(lacking(), lacking())
class Ranks(FlowTest):
    def run_ranks(self, ranks, script):
        command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), "/usr/bin/python3", "-B", "-c", script]
        return subprocess.run(command, cwd=self.folder, env=ENVIRONMENT, text=True, capture_output=True, timeout=300)

    def by_ranks(self, ranks, frames, options, save=None, resume=None):
        (self.folder / "given").write_bytes(pickle.dumps((options, frames, save, resume)))
        done = self.run_ranks(ranks, RANKS)
        self.assertEqual(done.returncode, 0, done.stderr)
        made = pickle.loads(self.contents("made"))
        return [vdblic.Volume((vdblic.Grid(**grid) for grid in grids), metadata) for metadata, grids in made]

    def test_textures_are_those_of_one_process(self):
        """Parts that end within leaves, of which some ranks have none."""
        for ranks, options in (3, {"refine": 2, "with_": ["vorticity", "hits"]}), (2, {"substeps": 2, "scalars": "texture"}), (
                5, {"method": "streaks", "refine": 3}), (2, {"method": "ibfv"}):
            frames = fields(3, (37, 20, 16))
            alone = vdblic.Flow(voxel_size=0.1, **options)
            expected = pushed(alone, frames) + alone.close()
            with self.subTest(options):
                self.assert_same(self.by_ranks(ranks, frames, options), expected)

    def test_lines_are_those_of_one_process(self):
        frames, options = fields(3, (37, 20, 16)), {"method": "streaks", "draw": "lines", "spacing": 3, "with_": ["q"]}
        alone = vdblic.Flow(voxel_size=0.1, **options)
        expected = pushed(alone, frames) + alone.close()
        self.by_ranks(3, frames, options)
        self.assertEqual(len(expected), 3)
        for number, volume in enumerate(expected):
            self.assertGreater(len(volume.lines), 20)
            self.assertEqual(vdblic.diff(f"{self.folder}/made.{number}.vdb", volume)["verdict"], "same")

    def test_checkpoints_go_on_with_other_ranks(self):
        frames, options = fields(5, (37, 20, 16)), {"refine": 2}
        alone = vdblic.Flow(voxel_size=0.1, **options)
        expected = pushed(alone, frames) + alone.close()
        self.by_ranks(3, frames[:3], options, save="flow.vdb")
        self.assert_same(self.by_ranks(2, frames[2:], options, resume="flow.vdb"), expected[2:])

    def test_mistakes_end_all_ranks(self):
        begin = ("import os, numpy\nfrom mpi4py import MPI\nfrom vdblic import Flow\ncomm = MPI.COMM_WORLD\n"
                 "field = numpy.ones((8, 8, 8, 3), numpy.float32)\norigin = 8 * comm.rank, 0, 0\n")
        for script, words in (
                ("Flow(comm=comm).close()", "no frame to compute"),
                ("flow = Flow(comm=comm); flow.push(field); flow.push(field)", r"two ranks have the voxel \[0, 0, 0\]"),
                ("Flow(comm=comm, origin=origin).push(field[..., comm.rank:])", "frame 1: "),
                ("Flow(comm=comm, origin=origin, voxel_size=1 + comm.rank).push(field)", "differ in name, transform or time"),
                ("field[0, 0, 0] += comm.rank and numpy.nan\n"
                 "flow = Flow(comm=comm, origin=origin); flow.push(field); flow.push(field)",
                 r"1 voxel is not finite, the first at \[8, 0, 0\]"),
                ("Flow(comm=comm, carry='q')", "`carry` is of one process"), ("Flow(comm=1)", "`comm` cannot be 1"),
                ("Flow(comm=comm, origin=(1, 2))", r"`origin` cannot be \(1, 2\)")):
            # One write for a line: those of two ranks mix otherwise.
            report = "\nexcept (ValueError, TypeError) as error: os.write(1, f'{comm.rank}: {error}\\n'.encode())"
            body = "".join(f"\n    {line}" for line in script.splitlines())
            done = self.run_ranks(2, f"{begin}try:{body}{report}")
            with self.subTest(script):
                self.assertEqual(done.returncode, 0, done.stderr)
                for rank in (0, 1):
                    self.assertRegex(done.stdout, f"(?m)^{rank}: .*{words}")


class StreakLines(FlowTest):
    def test_lines_are_those_of_the_files(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *SIZE, "--frames", "1-3")
        options = {"spacing": 3, "tail": 4, "with_": "q"}
        paths = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "s.%04d.vdb", "--method", "streaks", "--draw", "lines",
                             "--spacing", 3, "--tail", 4, "--with", "q")
        with vdblic.Flow(method="streaks", draw="lines", voxel_size=0.1, **options) as flow:
            pushed_ones = pushed(flow, fields(3)) + flow.close()
        for velocities in fields(3), f"{self.folder}/v.%04d.vdb", None:
            made = pushed_ones if velocities is None else list(vdblic.streaks(velocities, voxel_size=0.1, **options))
            self.assertEqual(len(made), 3)
            for volume, path in zip(made, paths):
                known = vdblic.read(path)
                self.assertGreater(len(volume.lines), 20)
                for name in "ids", "counts", "source", "points", "radius", "opacity", "age":
                    self.assertEqual(getattr(volume.lines, name).tobytes(), getattr(known.lines, name).tobytes(), name)
                self.assertEqual(sorted(volume.lines.scalars), ["magnitude", "q"])
                vdblic.write(self.folder / "copy.vdb", volume)
                for copy in volume, self.folder / "copy.vdb":
                    self.assertEqual(vdblic.diff(copy, path, ignore_metadata="source_creator")["verdict"], "same")

    def test_lines_are_arrays_and_drawn(self):
        volume = list(vdblic.streaks(fields(2), voxel_size=0.1, spacing=3, tail=4))[-1]
        lines = volume.lines
        self.assertRegex(repr(lines), r"^<vdblic.Lines: \d+ lines, \d+ points>$")
        self.assertRegex(repr(volume), rf"; {len(lines)} lines; frame 2")
        numpy.testing.assert_array_equal(numpy.concatenate(list(lines)), lines.points)
        self.assertEqual([len(line) for line in lines], lines.counts.tolist())
        numpy.testing.assert_array_equal(lines[-1], list(lines)[-1])
        with self.assertRaises(ValueError):
            lines.points[0, 0] = 1
        vdblic.write(self.folder / "s.vdb", volume)
        picture = vdblic.Renderer(size=(80, 60))(volume)
        self.assertGreater((picture.linear[..., 3] > 0).mean(), 0.05)
        numpy.testing.assert_array_equal(vdblic.Renderer(size=(80, 60))(vdblic.read(self.folder / "s.vdb")).linear, picture.linear)
        self.outputs("vdblic_render", "s.vdb", "-o", "tool.png", "--size", 80, 60)
        picture.save(self.folder / "picture.png")
        subprocess.run(["idiff", "-fail", "0", "tool.png", "picture.png"], cwd=self.folder, check=True, capture_output=True)

    def test_voxels_and_mistakes(self):
        drawn, = vdblic.streaks(fields(1), voxel_size=0.1, draw="voxels", refine=3)
        expected, = vdblic.advect(fields(1), voxel_size=0.1, method="streaks", refine=3)
        self.assert_same([drawn], [expected])
        self.assertIsNone(drawn.lines)
        with self.assertRaisesRegex(TypeError, r"streaks\(\) has no parameter 'life'"):
            vdblic.streaks(fields(1), life=3)
        with self.assertRaisesRegex(ValueError, "`spacing` cannot be -1"):
            vdblic.streaks(fields(1), spacing=-1)


if __name__ == "__main__":
    unittest.main()
