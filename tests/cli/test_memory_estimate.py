"""The memory that vdblic_advect says it takes, against what it takes.

A preloaded library counts what a run allocates. What the system's allocator keeps beside that differs from run to run.
"""

import os
import re
import unittest

from support import ToolTest, skip

if os.environ.get("VDBLIC_SANITIZED") == "1":
    skip("sanitizers hold more memory than there is")

COUNTER = os.environ["VDBLIC_TEST_SUPPORT"] + "/libcount_memory.so"
CODE = 40  # MiB, of the tool and its libraries


class MemoryEstimate(ToolTest):
    def peak_and_estimate(self, *arguments, threads=1):
        """The most memory that a run took, and its estimate [MiB]."""
        counted = self.folder / "counted"
        run = self.run_tool("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "-v", "--preroll", 0, "--threads", threads,
                            *arguments, env={**os.environ, "LD_PRELOAD": COUNTER, "VDBLIC_COUNTED": str(counted)})
        self.assertEqual(run.returncode, 0, run.stderr)
        said = float(re.search(r"texture voxels: about (\S+) MiB of memory", run.stderr)[1])
        return CODE + int(counted.read_text()) / (1 << 20), said

    def test_it_is_within_a_quarter(self):
        for size, *choices in ((96, (), ("--substeps", 2), ("--method", "uflic"), ("--method", "ibfv"),
                                    ("--method", "lea"), ("--method", "ufac")),
                               (64, ("--refine", 2), ("--refine", 2, "--method", "ibfv"), ("--refine", 2, "--interpolation", "cubic"))):
            self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", size, size, size, "--frames", "1-3")
            for choice in choices:
                peak, said = self.peak_and_estimate("--frames", "1-3", *choice)
                self.assertAlmostEqual(peak / said, 1, delta=0.25, msg=(size, choice, peak, said))

    def test_small_grids_and_threads(self):
        """Bricks are most of a small grid's memory: with two threads there are ten times as many."""
        for size in 46, 63, 100:
            self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", size, size, size, "--frames", "1-3")
            for threads in 1, 2:
                peak, said = self.peak_and_estimate(threads=threads)
                self.assertAlmostEqual(peak / said, 1, delta=0.25, msg=(size, threads, peak, said))


if __name__ == "__main__":
    unittest.main()
