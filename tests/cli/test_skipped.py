"""tests/skipped.sh, which names what a run of ctest did not run: of made-up tests here."""

import os
import shutil
import subprocess
import unittest

from support import SOURCE, ToolTest

WHOLE = """from support import skip
skip({!r})
"""
IN_PART = """import unittest
from support import SOURCE, ToolTest
class Part(ToolTest):
    def test_it(self):
        self.skipTest({!r})
    def test_another(self):
        pass
unittest.main()
"""


class Skipped(ToolTest):
    def setUp(self):
        super().setUp()
        self.build = self.folder / "build" / "release"
        for folder in self.folder / "tests", self.build:
            folder.mkdir(parents=True)
        shutil.copy(SOURCE / "tests" / "skipped.sh", self.folder / "tests")

    def run_tests(self, **tests):
        """Run tests of these names and texts by ctest."""
        listed = ""
        for name, text in tests.items():
            (self.build / f"{name}.py").write_text(text, encoding="utf-8")
            listed += f'add_test({name} "/usr/bin/python3" "-B" "{name}.py")\n'
            listed += f"set_tests_properties({name} PROPERTIES SKIP_RETURN_CODE 77)\n"
        (self.build / "CTestTestfile.cmake").write_text(listed, encoding="utf-8")
        environment = os.environ | {"PYTHONPATH": str(SOURCE / "tests" / "cli")}
        done = subprocess.run(["ctest"], cwd=self.build, env=environment, text=True, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def said(self, *options):
        """The exit status and the lines of the script."""
        done = subprocess.run([self.folder / "tests" / "skipped.sh", *options], text=True, capture_output=True)
        self.assertEqual(done.stderr, "")
        return done.returncode, done.stdout.splitlines()

    def test_what_ran_is_not_named(self):
        self.run_tests(whole="", part=IN_PART.replace("self.skipTest({!r})", "pass"))
        for options in (), ("--fail",):
            self.assertEqual(self.said(*options), (0, []))

    def test_what_may_be_skipped(self):
        """Packages that .ci/packages.sh does not install are named, and fail nothing."""
        self.run_tests(whole=WHOLE.format("usd-core is not installed"), part=IN_PART.format("tests/nightly.sh runs it"))
        self.assertEqual(self.said(), (0, ["did not run:", "    part in part: tests/nightly.sh runs it",
                                           "    whole: usd-core is not installed"]))
        self.assertEqual(self.said("--fail"), (0, []))

    def test_what_must_run(self):
        """What .ci/packages.sh installs: the test fails, and it alone is named."""
        for name, text in ("whole", WHOLE), ("whole in part", IN_PART):
            self.run_tests(whole=text.format("xvfb is not installed"), other=WHOLE.format("bpy is not installed"))
            self.assertEqual(self.said("--fail"), (1, ["did not run, though .ci/packages.sh has what is missing:",
                                                       f"    {name}: xvfb is not installed"]))
            self.assertEqual(self.said(), (0, ["did not run:", "    other: bpy is not installed",
                                               f"    {name}: xvfb is not installed"]))


if __name__ == "__main__":
    unittest.main()
