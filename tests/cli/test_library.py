"""The programs of samples/library, compiled against an installed copy."""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import unittest.mock

import numpy
import pyopenvdb as vdb

from support import BIN, SOURCE, ToolTest

PROGRAMS = SOURCE / "samples/library"

CCACHE = [ccache] if (ccache := shutil.which("ccache")) else []


class Library(ToolTest):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="vdblic-")
        cls.addClassCleanup(folder.cleanup)
        cls.installed = pathlib.Path(folder.name)
        subprocess.run(["cmake", "--install", BIN.parent, "--prefix", cls.installed], check=True, capture_output=True)

    def setUp(self):
        """The programs are below what is installed, so that their compilers' calls are the same in every run."""
        self.folder = self.installed / "programs" / self.id().split(".")[-1]
        self.folder.mkdir(parents=True)
        for name, value in ("CCACHE_BASEDIR", str(self.installed)), ("CCACHE_NOHASHDIR", "1"):
            self.enterContext(unittest.mock.patch.dict(os.environ, {name: value}))

    def run_command(self, *command):
        done = subprocess.run(list(map(str, command)), cwd=self.folder, text=True, capture_output=True, timeout=600)
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    @unittest.skipIf(os.environ.get("VDBLIC_SANITIZED") == "1", "a program of its own has no sanitizer")
    def test_programs(self):
        shutil.copytree(PROGRAMS, self.folder, dirs_exist_ok=True)
        self.run_command("cmake", "-S", ".", "-B", "build", f"-DCMAKE_PREFIX_PATH={self.installed}",
                         "-DCMAKE_BUILD_TYPE=Release", f"-DCMAKE_CXX_COMPILER_LAUNCHER={';'.join(CCACHE)}")
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

    @unittest.skipIf(os.environ.get("VDBLIC_SANITIZED") == "1", "a program of its own has no sanitizer")
    @unittest.skipUnless(shutil.which("pkg-config"), "pkg-config is not installed")
    def test_pkg_config(self):
        """A program that uses folders from the top to the bottom."""
        (self.folder / "film.cpp").write_text("""
            #include <vdblic/compare/compare.h>
            #include <vdblic/coherence/coherence_sequence.h>
            #include <vdblic/core/version.h>
            #include <vdblic/film/film.h>
            #include <vdblic/render/render_sequence.h>
            #include <iostream>
            int main(int count, char**)
            {
                if (count > 1) {
                    std::istringstream none;
                    vdblic::Reporter reporter;
                    vdblic::renderSequence(vdblic::RenderParams{}, none, reporter);
                }
                std::cout << vdblic::kVersion << '\\n';
            }
        """)
        os.environ["PKG_CONFIG_PATH"] = ":".join(map(str, self.installed.glob("lib*/**/pkgconfig")))
        self.run_command("bash", "-c", f"{' '.join(CCACHE)} c++ -c film.cpp $(pkg-config --cflags vdblic)")
        self.run_command("bash", "-c", "c++ film.o -o film $(pkg-config --libs vdblic)")
        version = self.run_command("pkg-config", "--modversion", "vdblic")
        self.assertEqual(self.run_command("./film"), version)
        self.assertEqual(self.run_tool("vdblic_advect", "--version").stdout.split()[-1], version.strip())

    def test_installed_headers_are_whole_and_portable(self):
        headers = list((self.installed / "include").rglob("*.h"))
        self.assertGreater(len(headers), 50)
        for header in headers:
            text = header.read_text(encoding="utf-8")
            with self.subTest(header=header.name):
                self.assertNotRegex(text, r"vector_size|__builtin_|target_clones|\b(Float|Int|Double)[248]\b")
                for name in re.findall(r'#include "(vdblic/[^"]+)"', text):
                    self.assertTrue((self.installed / "include" / name).is_file(), name)

    def test_headers_are_installed(self):
        lists = (SOURCE / "lib/CMakeLists.txt").read_text(encoding="utf-8")
        for folder, name in re.findall(r"vdblic/(\w+)/(\w+\.h)", (SOURCE / "docs/architecture.md").read_text(encoding="utf-8")):
            self.assertTrue((SOURCE / "lib/vdblic" / folder / name).is_file(), name)
            self.assertIn(f" {name}", lists)


if __name__ == "__main__":
    unittest.main()
