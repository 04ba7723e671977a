"""Long sequences: memory does not grow, and files are closed."""

import os
import pathlib
import subprocess
import time
import unittest

from support import BIN, ToolTest

SANITIZED = os.environ.get("VDBLIC_SANITIZED") == "1"


class LongRun(ToolTest):
    def loop(self, name, frames, made):
        """Extend a sequence of `made` frames to `frames` frames by repetition."""
        for frame in range(made + 1, frames + 1):
            os.link(self.folder / f"{name}.{(frame - 1) % made + 1:04}.vdb", self.folder / f"{name}.{frame:04}.vdb")

    def watched(self, tool, *arguments):
        """Run a tool that must succeed; returns the results of watch() every hundredth of a second."""
        seen = []
        with open(self.folder / "messages", "w+", encoding="utf-8") as messages:
            run = subprocess.Popen([BIN / tool, *map(str, arguments)], cwd=self.folder, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=messages)
            self.addCleanup(lambda: run.poll() is None and run.kill())
            while run.poll() is None:
                seen.append(self.watch(pathlib.Path(f"/proc/{run.pid}")))
                time.sleep(0.01)
            messages.seek(0)
            self.assertEqual(run.returncode, 0, messages.read())
        return [sample for sample in seen if sample]

    @staticmethod
    def watch(process):
        """A process's resident memory in MiB and number of open files, or None after its end."""
        try:
            status = (process / "status").read_text(encoding="ascii")
            memory = [int(line.split()[1]) / 1024 for line in status.splitlines() if line.startswith("VmRSS")]
            return (memory[0], len(list((process / "fd").iterdir()))) if memory else None
        except OSError:
            return None

    @unittest.skipIf(SANITIZED, "sanitizers keep memory that was freed")
    def test_memory_stays_flat(self):
        self.outputs("vdblic_synth", "tornado", "-o", "v.%04d.vdb", "--size", 24, 24, 24, "--frames", "1-25")
        self.loop("v", 300, 25)
        seen = self.watched("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--dt", 1, "--velocity-scale", 0.5,
                            "--threads", 2, "--checkpoint-every", 20)
        memory = [sample[0] for sample in seen]
        tenth = len(memory) // 10
        self.assertGreater(tenth, 20)
        self.assertLess(max(memory[-tenth:]), 1.1 * max(memory[tenth:2 * tenth]) + 4)

    def test_a_thousand_frames_need_few_open_files(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 6, 6, 6, "--frames", "1-2")
        self.loop("v", 1000, 2)
        for tool, *arguments in (
                ("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--dt", 0.04, "--checkpoint-every", 100),
                ("vdblic_render", "lic.%04d.vdb", "-o", "i.%04d.png", "--size", 8, 8),
                ("vdblic_coherence", "v.%04d.vdb", "lic.%04d.vdb", "--dt", 0.04, "--samples", 1000,
                 "--json", "c.json")):
            seen = self.watched(tool, *arguments)
            self.assertGreater(len(seen), 20, tool)
            self.assertLess(max(sample[1] for sample in seen), 20, tool)
        self.assertEqual(len(list(self.folder.glob("i.*.png"))), 1000)


if __name__ == "__main__":
    unittest.main()
