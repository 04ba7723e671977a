"""The programs of docs/library.md, compiled against an installed copy."""

import os
import pathlib
import re
import subprocess
import unittest

import numpy
import pyopenvdb as vdb

from support import BIN, ToolTest

SOURCE = pathlib.Path(os.environ["VDBLIC_SOURCE"])
DOCUMENT = (SOURCE / "docs/library.md").read_text(encoding="utf-8")


class Library(ToolTest):
    def run_command(self, *command):
        done = subprocess.run(list(map(str, command)), cwd=self.folder, text=True, capture_output=True, timeout=600)
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    @unittest.skipIf(os.environ.get("VDBLIC_SANITIZED") == "1", "a program of its own has no sanitizer")
    def test_programs(self):
        self.run_command("cmake", "--install", BIN.parent, "--prefix", self.folder / "installed")
        lists, = re.findall(r"^```cmake\n(.*?)^```", DOCUMENT, re.MULTILINE | re.DOTALL)
        (self.folder / "CMakeLists.txt").write_text(lists)
        programs = re.findall(r"^`(\w+\.cpp)`.*?^```cpp\n(.*?)^```", DOCUMENT, re.MULTILINE | re.DOTALL)
        self.assertEqual([name for name, _ in programs], ["sequence.cpp", "field.cpp"])
        for name, text in programs:
            (self.folder / name).write_text(text)
        self.run_command("cmake", "-S", ".", "-B", "build", "-DCMAKE_PREFIX_PATH=" + str(self.folder / "installed"),
                         "-DCMAKE_BUILD_TYPE=Release")
        self.run_command("cmake", "--build", "build")

        paths = self.run_command("build/sequence").split()
        self.assertEqual(paths, [f"{name}.{k:04}.vdb" for name in ("v", "lic") for k in (1, 2, 3, 4)])
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "tool.%04d.vdb", "--life", 3)
        self.assertEqual(self.contents("lic.0004.vdb"), self.contents("tool.0004.vdb"))
        self.assertEqual(self.run_command("build/field"), f"{48 * 48 * 16} voxels\n")
        values = numpy.zeros((48, 48, 16), numpy.float32)
        vdb.read(str(self.folder / "field.vdb"), "density").copyToArray(values)
        self.assertTrue(0 <= values.min() < values.max() <= 1)
        self.assertGreater(values.std(), 0.05)

    def test_headers_are_installed(self):
        lists = (SOURCE / "lib/CMakeLists.txt").read_text(encoding="utf-8")
        for folder, name in re.findall(r"vdblic/(\w+)/(\w+\.h)", DOCUMENT):
            self.assertTrue((SOURCE / "lib/vdblic" / folder / name).is_file(), name)
            self.assertIn(f" {name}", lists)


if __name__ == "__main__":
    unittest.main()
