"""The notebooks of samples/python run, in Jupyter's kernel with current packages, and show their pictures."""

import json
import os
import subprocess
import unittest

from support import BIN, SOURCE, ToolTest, peer, skip

MODULE = BIN.parent / "python"
if os.environ.get("VDBLIC_SANITIZED") == "1":
    skip("a sanitized module needs a sanitized Python")
if not list(MODULE.glob("vdblic/_core*.so")):
    skip("the module is not built, because pybind11 is missing")
PYTHON = peer("notebooks", "nbclient")
if PYTHON is None:
    skip("nbclient is missing: tests/peers.sh gets it")

RUN = """
import json, sys
import jupytext, nbclient
notebook = jupytext.read(sys.argv[1])
nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
print(json.dumps([sorted(output.get("data", {})) for output in outputs]))
"""


class Notebooks(ToolTest):
    def shown(self, name):
        """The kinds of data that each output of a notebook has."""
        path = f"{MODULE}:{SOURCE / 'tools/python'}"
        done = subprocess.run([PYTHON, "-B", "-c", RUN, SOURCE / f"samples/python/{name}.py"], cwd=self.folder, text=True,
                              env=os.environ | {"PYTHONPATH": path, "IPYTHONDIR": str(self.folder / "ipython")}, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr[-3000:])
        self.assertEqual((self.folder / f"{name}.png").read_bytes()[:4], b"\x89PNG")
        return json.loads(done.stdout)

    def test_arrays(self):
        shown = self.shown("arrays")
        self.assertIn("text/html", shown[0])  # slices of a grid
        self.assertEqual(sum("image/png" in kinds for kinds in shown), 2)

    def test_weather(self):
        self.assertEqual(sum("image/png" in kinds for kinds in self.shown("weather")), 2)

    def test_stream(self):
        self.assertIn("image/png", self.shown("stream")[-1])
        self.assertTrue((self.folder / "flow.vdb").exists())


if __name__ == "__main__":
    unittest.main()
