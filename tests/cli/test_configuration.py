"""A package that is installed after a first configuration is used by the next one of the same tree."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from support import BIN, SOURCE, ToolTest

HIDDEN = "MPI", "GTest", "pybind11"  # as if they were not installed
OF_PKG_CONFIG = ("libturbojpeg",)
# What is built because of them.
TARGETS = {"tool_advect_mpi", "tool_render_mpi", "vdblic_mpi", "vdblic_tests", "vdblic_python", "tool_view",
           "vdblic_viewer"}


class Configuration(ToolTest):
    def configure(self, *options, **environment):
        """The targets of the tree of this test, after a configuration."""
        command = ["cmake", "-S", SOURCE, "-B", self.folder, "-G", "Ninja", *options]
        done = subprocess.run(command, env={**os.environ, **environment}, text=True, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        listed = subprocess.run(["ninja", "-t", "targets", "all"], cwd=self.folder, text=True, capture_output=True, check=True)
        return set(re.findall(r"^(\w+): phony", listed.stdout, re.MULTILINE))

    def without_packages(self):
        """The folder of pkg-config's packages, but for OF_PKG_CONFIG."""
        variable = ["pkg-config", "--variable", "pc_path", "pkg-config"]
        folders = subprocess.run(variable, text=True, capture_output=True, check=True).stdout.strip().split(":")
        fewer = tempfile.TemporaryDirectory(prefix="vdblic-")
        self.addCleanup(fewer.cleanup)
        for folder in reversed(folders):
            for package in pathlib.Path(folder).glob("*.pc"):
                if package.stem not in OF_PKG_CONFIG:
                    link = pathlib.Path(fewer.name) / package.name
                    link.unlink(missing_ok=True)
                    link.symlink_to(package)
        return fewer.name

    def built_here(self):
        """Those of TARGETS that the build under test has: the packages that are installed."""
        listed = subprocess.run(["ninja", "-t", "targets", "all"], cwd=BIN.parent, text=True, capture_output=True, check=True)
        return TARGETS & set(re.findall(r"^(\w+): phony", listed.stdout, re.MULTILINE))

    def test_packages_that_come_later(self):
        hide = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{package}=ON" for package in HIDDEN]
        self.assertEqual(self.configure(*hide, PKG_CONFIG_LIBDIR=self.without_packages()) & TARGETS, set())
        show = [f"-UCMAKE_DISABLE_FIND_PACKAGE_{package}" for package in HIDDEN]
        self.assertEqual(self.configure(*show) & TARGETS, self.built_here())
        # A choice stays.
        for choice in ("-DVDBLIC_MPI=OFF",), ():
            self.assertNotIn("tool_advect_mpi", self.configure(*choice))


if __name__ == "__main__":
    unittest.main()
