"""Long sequences: memory does not grow, and files are closed."""

import os
import pathlib
import re
import resource
import subprocess
import unittest

from support import BIN, ToolTest

SANITIZED = os.environ.get("VDBLIC_SANITIZED") == "1"


class LongRun(ToolTest):
    def loop(self, name, frames, made):
        """Extend a sequence of `made` frames to `frames` frames by repetition."""
        for frame in range(made + 1, frames + 1):
            os.link(self.folder / f"{name}.{(frame - 1) % made + 1:04}.vdb", self.folder / f"{name}.{frame:04}.vdb")

    @staticmethod
    def peak(process):
        """The most memory that a process has held [MiB]."""
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text(encoding="ascii")
        return int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024

    @unittest.skipIf(SANITIZED, "sanitizers keep memory that was freed")
    def test_memory_stays_flat(self):
        self.outputs("vdblic_synth", "tornado", "-o", "v.%04d.vdb", "--size", 24, 24, 24, "--frames", "1-25")
        self.loop("v", 300, 25)
        run = subprocess.Popen([BIN / "vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "-q", "--dt", "1",
                                "--velocity-scale", "0.5", "--threads", "2", "--checkpoint-every", "20"],
                               cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
        self.addCleanup(run.wait)
        self.addCleanup(run.stdout.close)
        peaks = [self.peak(run) for _ in iter(run.stdout.readline, "lic.0300.vdb\n")]
        self.assertEqual(len(peaks), 299)
        self.assertLess(peaks[-1], 1.1 * peaks[60] + 4)

    def test_long_sequences_need_few_open_files(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 6, 6, 6, "--frames", "1-2")
        self.loop("v", 300, 2)
        few = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (20, 20))}
        for tool, *arguments in (
                ("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--dt", 0.04, "--checkpoint-every", 5),
                ("vdblic_render", "lic.%04d.vdb", "-o", "i.%04d.png", "--size", 8, 8),
                ("vdblic_coherence", "v.%04d.vdb", "lic.%04d.vdb", "--dt", 0.04, "--samples", 1000, "--json", "c.json")):
            self.outputs(tool, *arguments, **few)
        self.assertEqual(len(list(self.folder.glob("i.*.png"))), 300)


if __name__ == "__main__":
    unittest.main()
