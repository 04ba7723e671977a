"""Damaged files of every kind through the tools and the module that read them: status 0 or 3, one message, no output.

Bytes change anywhere, or one number that tells how to read the rest. A few of each kind for every push; at night
(tests/nightly.sh) two thousand. The files are the same in every run. Volumes have no checksums, which would refuse nearly all
of them before they are parsed.
"""

import json
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy

from fields import misplaced
from support import BIN, HAS_MODULE, MODULE, ToolTest, often
from vdb_bytes import IDENTITY

FILES, MISPLACED = often(4, 1000), often(3, 1000)
SMALL = ("--size", 12, 8)
READ = ("import sys; sys.path.insert(0, sys.argv[1]); import vdblic\n"
        "try: vdblic.read(sys.argv[2])\n"
        "except ValueError as error: sys.exit(f'python: error: {error}'[:1000])\n")


def mutated(data, number):
    """Damaged bytes of a file."""
    choice = random.Random(number)
    data, what = bytearray(data), choice.random()
    at = choice.randrange(min(len(data), 2000) if choice.random() < 0.6 else len(data))
    if what < 0.15:
        del data[at:]
    elif what < 0.6:
        data[at] ^= choice.randrange(1, 256)
    elif what < 0.8:
        data[at:at + 4] = choice.choice([b"\xff" * 4, b"\0" * 4, b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0\0\x10\0"])
    elif what < 0.9:
        data[at:at] = data[at // 2:at]
    else:
        del data[at:at + choice.randrange(1, 64)]
    return bytes(data)


class Mutations(ToolTest):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="vdblic-")
        cls.addClassCleanup(folder.cleanup)
        cls.whole = pathlib.Path(folder.name)
        for command in (("vdblic_synth", "abc", "-o", "flow.%04d.vdb", "--size", 12, 10, 8, "--frames", "1-3"),
                        ("vdblic_advect", "flow.%04d.vdb", "-o", "lic.%04d.vdb", "--frames", "1-2", "--preroll", 0),
                        ("vdblic_advect", "flow.0001.vdb", "-o", "streaks.vdb", "--method", "streaks", "--draw", "lines"),
                        ("vdblic_advect", "flow.%04d.vdb", "-o", "c.%04d.vdb", "--frames", "1-2", "--preroll", 0,
                         "--keep-checkpoint")):
            subprocess.run([BIN / command[0], *map(str, command[1:])], cwd=folder.name, check=True, capture_output=True)
        for path in cls.whole.glob("*.vdb"):
            data = bytearray(path.read_bytes())
            data[IDENTITY] = b"00000000-0000-4000-8000-000000000000"  # then the checksums are not its own
            path.write_bytes(data)
        (cls.whole / "transfer.json").write_text(json.dumps(
            {"range": [0, 2], "colors": [[0, 0, 0, 1], [1, 1, 0, 0]], "opacity": [[0, 0], [1, 1]], "unit": "m/s"}))
        (cls.whole / "camera.json").write_text(json.dumps(
            {"keys": [{"frame": 1, "eye": [3, 3, 3], "target": [0, 0, 0], "fov": 30}, {"frame": 9, "eye": [3, 3, 4]}]}))
        numpy.save(cls.whole / "flow.npy", numpy.ones((6, 5, 4, 3), numpy.float32))
        numpy.savez(cls.whole / "flow.npz", velocity=numpy.ones((6, 5, 4, 3), numpy.float32), time=[0.5],
                    origin=[1, 2, 3])

    def check(self, name, *commands, status=(0, 3)):
        """Give damaged copies of a file to commands, in turn."""
        whole = (self.whole / name).read_bytes()
        for number in range(FILES + (0 if name.endswith(".json") else MISPLACED)):
            command = commands[number % len(commands)]
            what, data = "bytes", mutated(whole, f"{name} {number}")
            if number >= FILES:
                what, data = misplaced(whole, random.Random(f"{name} {number}"))
            with self.subTest(name, number=number, what=what, command=command), tempfile.TemporaryDirectory() as folder:
                shutil.copytree(self.whole, folder, dirs_exist_ok=True)
                bad = pathlib.Path(folder) / name
                bad.write_bytes(data)
                before = {path.name for path in bad.parent.iterdir()}
                done = subprocess.run([command[0] if command[0] == sys.executable else BIN / command[0],
                                       *map(str, command[1:])], cwd=folder, capture_output=True, timeout=120)
                said = done.stderr.decode(errors="replace")
                self.assertIn(done.returncode, status, said)
                if done.returncode == 3:
                    errors = [line for line in said.splitlines() if "error: " in line]
                    self.assertEqual(len(errors), 1, said)
                    left = {path.name for path in bad.parent.iterdir()} - before
                    self.assertFalse({path for path in left if "out" in path and not done.stdout}, said)
                self.assertNotIn("Traceback", said)

    def test_velocity(self):
        self.check("flow.0001.vdb", ("vdblic_advect", "flow.%04d.vdb", "-o", "out.%04d.vdb", "--preroll", 0),
                   ("vdblic_info", "flow.%04d.vdb", "--values"), ("vdblic_noise", "--like", "flow.0001.vdb", "-o", "out.vdb"),
                   ("vdblic_coherence", "flow.%04d.vdb", "lic.%04d.vdb", "--samples", 200))

    def test_texture(self):
        self.check("lic.0001.vdb", ("vdblic_render", "lic.0001.vdb", "-o", "out.png", *SMALL),
                   ("vdblic_diff", "lic.0001.vdb", "lic.0002.vdb", "-o", "out.vdb"),
                   ("vdblic_info", "lic.%04d.vdb", "--values"),
                   ("vdblic_render", "lic.%04d.vdb", "--frames", "1-2", "-o", "out.%04d.exr", *SMALL), status=(0, 1, 3))

    def test_streaks(self):
        self.check("streaks.vdb", ("vdblic_render", "streaks.vdb", "-o", "out.png", *SMALL),
                   ("vdblic_info", "streaks.vdb", "--values"))
        if HAS_MODULE:
            self.check("streaks.vdb", ("vdblic_export", "streaks.vdb", "-o", "out.vtp"),
                       ("vdblic_export", "streaks.vdb", "-o", "out.usda"))

    def test_checkpoint(self):
        """Without its checksums it is refused, whatever else it has; as any volume it is parsed."""
        self.check("checkpoint.c.vdb", ("vdblic_info", "checkpoint.c.vdb", "--values"),
                   ("vdblic_diff", "checkpoint.c.vdb", "checkpoint.c.vdb"),
                   ("vdblic_render", "checkpoint.c.vdb", "--texture", "noise", "-o", "out.png", *SMALL), status=(0, 1, 3))
        self.check("checkpoint.c.vdb", ("vdblic_advect", "flow.%04d.vdb", "-o", "c.%04d.vdb", "--preroll", 0, "--resume"),
                   status=(3,))

    def test_json(self):
        render = ("vdblic_render", "lic.0001.vdb", "-o", "out.png", *SMALL)
        self.check("transfer.json", (*render, "--transfer", "transfer.json"))
        self.check("camera.json", (*render, "--camera", "camera.json"))

    @unittest.skipUnless(HAS_MODULE, "the module is not built, or a sanitized one")
    def test_imports(self):
        for name in "flow.npy", "flow.npz":
            self.check(name, ("vdblic_import", name, "-o", "out.vdb", "--layout", "xyzc"))

    @unittest.skipUnless(HAS_MODULE, "the module is not built, or a sanitized one")
    def test_netcdf(self):
        import netCDF4

        for name, form in ("wind.nc", "NETCDF4"), ("old.nc", "NETCDF3_CLASSIC"), ("wide.nc", "NETCDF3_64BIT_DATA"):
            with netCDF4.Dataset(self.whole / name, "w", format=form) as data:
                for axis, count in ("z", 4), ("y", 5), ("x", 6):
                    data.createDimension(axis, count)
                    places = data.createVariable(axis, "f8", (axis,))
                    places[:] = numpy.arange(count)
                    places.units = "m"
                    places.axis = axis.upper()
                for component in "uvw":
                    data.createVariable(component, "f4", ("z", "y", "x"))[:] = 1
            self.check(name, ("vdblic_import", name, "-o", "out.vdb"))

    @unittest.skipUnless(HAS_MODULE, "the module is not built, or a sanitized one")
    def test_export_and_module(self):
        module = (sys.executable, "-c", READ, MODULE, "lic.0001.vdb")
        self.check("lic.0001.vdb", ("vdblic_export", "lic.0001.vdb", "-o", "out.npz"),
                   ("vdblic_export", "lic.0001.vdb", "-o", "out.usda"), ("vdblic_export", "lic.0001.vdb", "-o", "out.vti"))
        # A file that crashes OpenVDB in it ends a program, as docs/CONTRIBUTING.md says.
        self.check("lic.0001.vdb", module, status=(0, 1, -6, -8, -11))


if __name__ == "__main__":
    unittest.main()
