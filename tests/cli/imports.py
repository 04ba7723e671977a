"""Shared by the tests of vdblic_import: running it, and reading the flow that it wrote."""

import contextlib
import io
import os
import subprocess
import sys
import warnings

import numpy
import pyopenvdb as vdb

import python_module  # pylint: disable=unused-import
from support import BIN, ToolTest

TIMES = [0.0, 0.5, 1.25]


def velocity_of(path, name="velocity"):
    """Values (x, y, z, 3), active voxels and world positions over the box of a grid's active voxels."""
    grid = vdb.read(str(path), name)
    low, high = grid.evalActiveVoxelBoundingBox()
    size = [b - a + 1 for a, b in zip(low, high)]
    values = numpy.zeros((*size, 3) if name == "velocity" else size, numpy.float32)
    grid.copyToArray(values, low)
    marks = vdb.FloatGrid()
    for voxel in grid.citerOnValues():
        marks.fill(voxel.min, voxel.max, 1)
    active = numpy.zeros(size, numpy.float32)
    marks.copyToArray(active, low)
    z, y, x = numpy.meshgrid(*(numpy.arange(n) + a for n, a in zip(size[::-1], low[::-1])), indexing="ij")
    indices = numpy.stack([x, y, z], axis=-1).transpose(2, 1, 0, 3)
    scale, origin = grid.transform.voxelSize(), grid.transform.indexToWorld((0, 0, 0))
    return values, active > 0, indices * scale + origin


class ImportTest(ToolTest):
    def imports(self, *arguments, **options):
        return self.outputs("vdblic_import", *arguments, **options)

    def refuses(self, status, *arguments, **options):
        before = self.files()
        message = self.fails(status, "vdblic_import", *arguments, **options)
        self.assertEqual(self.files(), before, arguments)
        self.assertEqual(len(message.splitlines()), 2 if "lists the options" in message else 1, message)
        return message

    def assert_flow(self, path, expected, voxels=None, tolerance=1e-5):
        """The volume holds a flow (a function of positions) at every active voxel. Returns the mask."""
        values, active, positions = velocity_of(path)
        scale = numpy.abs(expected(positions)).max()
        numpy.testing.assert_allclose(values[active], expected(positions)[active], atol=tolerance * scale, rtol=0)
        if voxels:
            self.assertEqual(active.shape, voxels)
            self.assertTrue(active.all(), path)
        return active

    def assert_advects(self, pattern):
        """vdblic_advect takes frame spacing and velocity from the files."""
        done = self.run_tool("vdblic_advect", pattern, "-o", "lic.%04d.vdb", "-v", "--preroll", 0)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("velocity: grid velocity", done.stderr)
        self.assertRegex(done.stderr, r"s between frames \(by the files' times\)")


class ImportHere(ImportTest):
    """Tests that run vdblic_import many times: in this process, because a start of Python takes longer than an import."""

    def run_tool(self, tool, *arguments, stdin="", **options):
        if tool != "vdblic_import" or stdin or options:
            return super().run_tool(tool, *arguments, stdin=stdin, **options)
        sys.path.insert(0, str(BIN.parent / "python"))
        from vdblic_convert import import_tool  # pylint: disable=import-outside-toplevel,import-error

        here, messages = os.getcwd(), io.StringIO()
        output = io.TextIOWrapper(io.BytesIO(), encoding="utf-8")
        os.chdir(self.folder)
        try:
            with contextlib.redirect_stdout(output), contextlib.redirect_stderr(messages), warnings.catch_warnings():
                warnings.simplefilter("ignore")  # those of packages, which a tool does not show
                status = import_tool.main("test", list(map(str, arguments)))
        finally:
            os.chdir(here)
            sys.path.pop(0)
        printed = output.buffer.getvalue().decode()
        return subprocess.CompletedProcess(arguments, status, printed, messages.getvalue())
