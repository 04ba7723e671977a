"""The memory that vdblic_advect says it takes, against what it takes."""

import os
import re
import subprocess
import unittest

from support import BIN, ToolTest, skip

if os.environ.get("VDBLIC_SANITIZED") == "1":
    skip("sanitizers hold more memory than there is")


class MemoryEstimate(ToolTest):
    def peak_and_estimate(self, *arguments, threads=1):
        """The most memory that a run held, and its estimate [MiB]."""
        command = [BIN / "vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "-v", "--preroll", 0, "--threads", threads, *arguments]
        run = subprocess.Popen(list(map(str, command)), cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               text=True)
        messages = run.stderr.read()
        run.stderr.close()
        _, status, usage = os.wait4(run.pid, 0)
        run.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(run.returncode, 0, messages)
        said = float(re.search(r"texture voxels: about (\S+) MiB of memory", messages)[1])
        return usage.ru_maxrss / 1024, said

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
