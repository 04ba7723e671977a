"""The Python module with the oldest and the newest NumPy that it takes: the same textures, pictures and metadata."""

import os
import subprocess
import unittest

from python_module import MODULE
from support import ToolTest, peer


SCRIPT = """
import sys
import numpy
import vdblic

velocity = numpy.zeros((16, 12, 8, 3), numpy.float32)
velocity[..., 0] = 20 + numpy.arange(12)[:, None]
velocity[..., 1] = numpy.sin(numpy.arange(16))[:, None, None]
texture = list(vdblic.advect([velocity] * 2))[-1]
picture = vdblic.Renderer(size=(40, 24))(texture)
numbers = {"whole": numpy.int32(7), "large": numpy.int64(2**40), "single": numpy.float32(0.1), "double": 0.1,
           "place": numpy.array([1, 2, 3]), "offset": numpy.array([0.5, 1.5, 2.5], numpy.float32)}
vdblic.write("numbers.vdb", vdblic.Grid(velocity, metadata=numbers, name="velocity"))
stored = vdblic.read("numbers.vdb")["velocity"]
with open(sys.argv[1], "wb") as file:
    file.write(texture["density"].values.tobytes())
    file.write(picture.linear.tobytes())
    file.write(picture._repr_png_())
    file.write(numpy.asarray(picture).tobytes())
    file.write(stored.values.tobytes())
    for name in numbers:
        value = stored.metadata[name]
        file.write(f"{name} {numpy.asarray(value).dtype} {numpy.asarray(value).tolist()}\\n".encode())
print(numpy.__version__.split(".")[0], int(picture.linear[..., :3].max() > picture.linear[..., :3].min()), repr(stored))
"""


class NumPy(ToolTest):
    def made_by(self, python, name):
        """What the script makes with a Python's NumPy: what it prints, and the bytes of its results."""
        done = subprocess.run(
            [python, "-B", "-c", SCRIPT, name],
            cwd=self.folder,
            env=os.environ | {"PYTHONPATH": str(MODULE)},
            text=True,
            capture_output=True,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.split(maxsplit=2), self.contents(name)

    def test_results_are_equal(self):
        newest = peer("numpy", "numpy")
        if newest is None:
            self.skipTest("NumPy 2 is missing: tests/peers.sh gets it")
        old, expected = self.made_by("/usr/bin/python3", "old")
        new, made = self.made_by(newest, "new")
        self.assertEqual(int(old[0]), 1)
        self.assertGreaterEqual(int(new[0]), 2)
        self.assertEqual(old[1], "1")  # the picture shows something
        self.assertEqual(old[1:], new[1:])
        self.assertEqual(made, expected)

    def test_a_grid_is_shown_in_a_line(self):
        (_, _, line), _ = self.made_by("/usr/bin/python3", "one")
        self.assertEqual(line.strip(), "<vdblic.Grid 'velocity' (x: 16, y: 12, z: 8, 3) float32, voxel size 1>")


if __name__ == "__main__":
    unittest.main()
