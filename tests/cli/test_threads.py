"""Tools whose threads share much: textures rendered as they come, a film, the viewer, a comparison of several frames.

The answers are compared with those of one thread. Under the thread sanitizer (tests/tsan.sh) a race ends a tool with
status 66. Names are long: std::string keeps up to 15 characters in itself, where a string that is written under its readers
may go unseen.
"""

import concurrent.futures
import signal
import subprocess
import unittest

from support import BIN
from viewer import ViewerTest

GRID = "a_texture_with_a_long_name"


class Threads(ViewerTest):
    def setUp(self):
        super().setUp()
        self.outputs("vdblic_synth", "tornado", "-o", "velocity.%04d.vdb", "--size", 24, 24, 24, "--frames", "1-8")

    def textures(self, name, threads):
        return self.outputs("vdblic_advect", "velocity.%04d.vdb", "-o", f"{name}.%04d.vdb", "--preroll", 1, "--texture-name",
                            GRID, "--with", "q,vorticity", "--threads", threads)

    def test_textures_are_rendered_as_they_come(self):
        look = "--size 48 32 --opacity-by q --color-by vorticity"
        command = (f"{BIN}/vdblic_advect velocity.%04d.vdb -o lic.%04d.vdb --preroll 1 --threads 4 --texture-name {GRID} "
                   f"--with q,vorticity | {BIN}/vdblic_render - -o many.%04d.exr --threads 4 {look}")
        done = subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=self.folder, text=True, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(done.stdout.split()), 8)
        for threads in 4, 1:  # many frames at a time, because all textures are there
            self.outputs("vdblic_render", "-", "-o", f"ready-{threads}.%04d.exr", "--threads", threads, *look.split(),
                         stdin="".join(f"lic.{frame:04}.vdb\n" for frame in range(1, 9)))
        for frame in range(1, 9):
            for name in "many", "ready-4":
                self.assertEqual(self.contents(f"{name}.{frame:04}.exr"), self.contents(f"ready-1.{frame:04}.exr"))

    def test_a_film(self):
        films = [self.outputs("vdblic_film", "velocity.%04d.vdb", "-o", f"film-{threads}.mp4", "--size", 48, 32, "--threads",
                              threads, "--seconds", 0.3)[0] for threads in (4, 1)]
        self.assertEqual(films[0].read_bytes(), films[1].read_bytes())

    def test_a_comparison(self):
        self.textures("one", 1)
        self.textures("many", 4)
        done = self.run_tool("vdblic_diff", "one.%04d.vdb", "many.%04d.vdb", "--threads", 4)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_viewer(self):
        self.textures("lic", 4)
        self.start("lic.%04d.vdb", "--texture", GRID, "--threads", 4)
        states = {}, {"opacity-by": "q"}, {"color-by": "vorticity"}, {"shadows": 0.5}
        ask = lambda number: self.picture(states[number % 4], frame=1 + number % 8, client=f"client-{number}")
        with concurrent.futures.ThreadPoolExecutor(4) as clients:
            pictures = list(clients.map(ask, range(16)))
        self.assertEqual(pictures[:8], pictures[8:])
        self.assertEqual(self.stop(), -signal.SIGTERM)


if __name__ == "__main__":
    unittest.main()
