"""The Python module's runs: a solver's stream, films, progress, and the types and names that editors see."""

import inspect
import os
import re
import resource
import signal
import subprocess
import sys
import unittest

import numpy

from python_module import MODULE
from support import SOURCE, ToolTest, peer

import vdblic

SIZE = 24, 20, 16


def fields(count):
    """The velocities of a known flow, with their times."""
    return [(volume.time, volume["velocity"].values) for volume in vdblic.synth("abc", SIZE, range(1, count + 1))]


class Streams(ToolTest):
    def pushed(self, frames, **options):
        """The textures of a stream, and how many each frame finished; the solver overwrites its only array."""
        flow = vdblic.Flow(voxel_size=0.1, **options)
        velocity = numpy.zeros((*SIZE, 3), numpy.float32)
        textures, counts = [], []
        for time, values in frames:
            velocity[:] = values
            made = flow.push(velocity, time)
            textures += made
            counts.append(len(made))
            velocity[:] = numpy.nan
        last = flow.close()
        self.assertEqual(flow.close(), [])
        return textures + last, [*counts, len(last)]

    def test_textures_are_those_of_the_files(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *SIZE, "--frames", "1-4")
        for arguments, options, counts in (
                (("--refine", 2, "--with", "q"), {"refine": 2, "with_": "q"}, [0, 1, 1, 1, 1]),
                (("--substeps", 3), {"substeps": 3}, [0, 3, 3, 3, 1]),
                (("--method", "streaks", "--refine", 3), {"method": "streaks", "refine": 3}, [0, 1, 1, 1, 1]),
                (("--method", "lic"), {"method": "lic"}, [0, 1, 1, 1, 1])):
            paths = self.outputs("vdblic_advect", "v.%04d.vdb", "-o", f"{len(options)}{arguments[1]}.%04d.vdb", *arguments)
            textures, made = self.pushed(fields(4), **options)
            self.assertEqual((made, len(textures)), (counts, len(paths)))
            for texture, path in zip(textures, paths):
                report = vdblic.diff(texture, path, ignore_metadata="source_creator")  # which the velocity's file tells
                self.assertEqual(report["verdict"], "same", [grid["name"] for grid in report["frames"][0]["grids"]])
                known = vdblic.read(path)
                for name in known:
                    self.assertEqual(texture[name].values.tobytes(), known[name].values.tobytes())
                    self.assertEqual(texture[name].active.tobytes(), known[name].active.tobytes())

    def test_short_streams(self):
        alone, counts = self.pushed(fields(1))
        self.assertEqual(counts, [0, 1])
        expected, = vdblic.advect(fields(1), voxel_size=0.1)
        numpy.testing.assert_array_equal(alone[0]["density"], expected["density"])
        with self.assertRaisesRegex(ValueError, "no frame to compute"):
            vdblic.Flow().close()

    def test_memory_is_flat_over_1000_frames(self):
        flow, velocity, peaks = vdblic.Flow(life=2), numpy.ones((16, 16, 16, 3), numpy.float32), []
        for number in range(1000):
            flow.push(velocity, number / 24)
            if number in (200, 999):
                peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
        flow.close()
        self.assertLess(peaks[1] - peaks[0], 8 << 10)

    def test_errors(self):
        for push, words in (([numpy.zeros((4, 4))], r"frame 1: .* is no field"), ([numpy.zeros((4, 4, 4))], "frame 1 has the shape"),
                            ([fields(1)[0][1], fields(1)[0][1] * numpy.nan], "^frame 2: grid velocity: .* not finite")):
            with self.subTest(words), vdblic.Flow() as flow:
                with self.assertRaisesRegex(ValueError, words):
                    for velocity in push:
                        flow.push(velocity)
        with self.assertRaisesRegex(ValueError, "the flow is closed"):
            flow.push(fields(1)[0][1])
        for options, words in (({"steady_frames": 2}, "steady_frames"), ({"frames": "1"}, "frames"), ({"refin": 2}, "'refine' is one")):
            with self.assertRaisesRegex(TypeError, words):
                vdblic.Flow(**options)


class Progress(ToolTest):
    def test_steps_are_counted(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *SIZE, "--frames", "1-3")
        for velocities, options, total in (
                (fields(3), {}, 7), (iter(fields(3)), {}, None), (fields(3), {"substeps": 2, "preroll": 1}, 7),
                (fields(1), {"steady_frames": 3}, 7), (f"{self.folder}/v.%04d.vdb", {}, 7),
                (numpy.stack([values for _, values in fields(3)]), {"layout": "txyz"}, 7)):
            told = []
            list(vdblic.advect(velocities, progress=lambda *step: told.append(step), **options))
            with self.subTest(options=options):
                self.assertEqual([done for done, _ in told], list(range(1, (total or 7) + 1)))
                self.assertEqual({of for _, of in told}, {total})

    def test_an_error_of_the_callback_ends_the_run(self):
        def refuse(*_):
            raise RuntimeError("enough")

        with self.assertRaisesRegex(RuntimeError, "enough"):
            list(vdblic.advect(fields(2), progress=refuse))

    def test_a_bar_is_shown_where_somebody_watches(self):
        (self.folder / "tqdm").mkdir()
        (self.folder / "tqdm/__init__.py").write_text("")
        (self.folder / "tqdm/auto.py").write_text(
            "import sys\n"
            "class tqdm:\n"
            "    def __init__(self, desc, unit): self.n, self.total = 0, None; print('bar', desc, unit)\n"
            "    def update(self, more): self.n += more; print(self.n, self.total)\n"
            "    def close(self): print('closed')\n")
        for value, shown in ("None", ""), ("False", ""), ("True", "bar advect steps 1 6 2 6 3 6 4 6 5 6 6 6 closed"):
            program = f"import vdblic; list(vdblic.advect(list(vdblic.synth('abc', 8, [1, 2])), progress={value}))"
            done = subprocess.run([sys.executable, "-B", "-c", program], text=True, capture_output=True, check=True,
                                  env=os.environ | {"PYTHONPATH": f"{MODULE}:{self.folder}"})
            self.assertEqual(" ".join(done.stdout.split()), shown)

    def test_an_interruption_ends_films_and_measures(self):
        begin = ("import vdblic\n"
                 "def told(done, total): print(done, flush=True)\n"
                 "flow = list(vdblic.synth('abc', 32, range(1, 30)))\n")
        for call in "vdblic.film(flow, 'f.mp4', progress=told)", "vdblic.film(flow, progress=told)":
            run = subprocess.Popen([sys.executable, "-B", "-c", begin + call], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, cwd=self.folder, env=os.environ | {"PYTHONPATH": str(MODULE), "TMPDIR": str(self.folder)})
            self.assertEqual(run.stdout.readline(), "1\n")
            run.send_signal(signal.SIGINT)
            _, messages = run.communicate(timeout=60)
            self.assertIn("KeyboardInterrupt", messages)
            self.assertEqual(self.files(), [])


class Films(ToolTest):
    def test_a_film_in_a_line(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *SIZE, "--frames", "1-3")
        options = {"size": (64, 48), "seconds": 0.5}
        arguments = "--size", 64, 48, "--seconds", 0.5
        self.outputs("vdblic_film", "v.%04d.vdb", "-o", "tool.mp4", *arguments)
        told = []
        film = vdblic.film(fields(3), self.folder / "flow.mp4", voxel_size=0.1, progress=lambda *step: told.append(step), **options)
        self.assertEqual(film.data, self.contents("flow.mp4"))
        self.assertEqual(film.data, self.contents("tool.mp4"))
        self.assertEqual(told[-1][0], told[-1][1])
        self.assertEqual(vdblic.film(f"{self.folder}/v.%04d.vdb", self.folder / "files.mp4", **options).data, film.data)
        self.assertEqual(vdblic.film(fields(3), voxel_size=0.1, **options).data, film.data)
        self.assertRegex(film._repr_html_(), '^<video .*src="data:video/mp4;base64,')
        self.assertRegex(repr(film), r"^<vdblic.Film .mp4, \d+ bytes>$")
        still = vdblic.film([values for _, values in fields(3)], self.folder / "still.png", voxel_size=0.1, size=64)
        self.assertRegex(still._repr_html_(), "^<img ")
        self.assertEqual(self.contents("still.png")[:4], b"\x89PNG")
        film.save(self.folder / "copy.mp4")
        self.assertEqual(self.contents("copy.mp4"), film.data)
        self.assertEqual([name for name in self.files() if "textures" in name or name.startswith(".")], [])

    def test_mistakes(self):
        for arguments, options, words in (
                ((fields(1), self.folder / "f.gif"), {}, "f.gif"), (("v.vdb", "f.html"), {}, "must end in .mp4 or .png"),
                ((fields(1), self.folder / "no/f.mp4"), {}, "no"),
                (([], self.folder / "f.mp4"), {}, "there is no velocity"), (("v.vdb", "f.mp4"), {"dt": 1}, "`dt` is of velocities in memory"),
                (("none.vdb", self.folder / "f.mp4"), {}, "none.vdb: no such file"), ((fields(1),), {"seconds": -1}, "`seconds` cannot be -1"),
                (([numpy.zeros((3, 3))],), {}, "frame 1: ")):
            with self.subTest(words), self.assertRaisesRegex((ValueError, OSError), words):
                vdblic.film(*arguments, **options)
        broken = fields(1)[0][1].copy()
        broken[1, 2, 3] = numpy.nan
        for call, words in (
                (lambda: vdblic.film([fields(1)[0][1], broken]), "^frame 2: velocity 2: grid velocity: .* give `nonfinite` zero$"),
                (lambda: vdblic.film({"p": broken[..., 0], "q": broken[..., 1]}), "^velocity: holds no velocity"),
                (lambda: vdblic.coherence(fields(2), vdblic.advect(fields(3))), "^texture 3: |^velocity 3: the velocity of frame 3 is missing")):
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                call()
        with self.assertRaisesRegex(TypeError, r"film\(\) has no parameter 'sice'; 'size' is one"):
            vdblic.film(fields(1), sice=64)
        self.assertEqual(self.files(), [])

    def test_the_coherence_of_arrays(self):
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *SIZE, "--frames", "1-3")
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb")
        velocity, texture = f"{self.folder}/v.%04d.vdb", f"{self.folder}/lic.%04d.vdb"
        expected = vdblic.coherence(velocity, texture, samples=2000)["frames"]
        textures = list(vdblic.advect(fields(3), voxel_size=0.1))
        for arguments in (fields(3), textures), (velocity, textures), (fields(3), texture):
            self.assertEqual(vdblic.coherence(*arguments, voxel_size=0.1, samples=2000)["frames"], expected)
        single = vdblic.coherence(fields(1)[0][1], textures[0], voxel_size=0.1, samples=100)
        self.assertEqual(len(single["frames"]), 1)


class Names(ToolTest):
    def test_signatures_name_every_parameter(self):
        for function, known in ((vdblic.advect, vdblic.flow.PARAMETERS), (vdblic.Renderer, vdblic.pictures.OPTIONS),
                                (vdblic.film, vdblic.films.OPTIONS), (vdblic.Flow, vdblic.flow.FLOW_PARAMETERS),
                                (vdblic.streaks, vdblic.flow.STREAK_PARAMETERS),
                                (vdblic.diff, vdblic.measures.DIFF_OPTIONS), (vdblic.coherence, vdblic.measures.COHERENCE_OPTIONS)):
            named = inspect.signature(function).parameters
            self.assertLessEqual(known, set(named))
            self.assertFalse([p for p in named.values() if p.kind == p.VAR_KEYWORD])
        named = inspect.signature(vdblic.advect).parameters
        self.assertEqual([named[key].default for key in ("method", "life", "sharpen", "clamp_frames", "dt", "with_")],
                         ["auflic", 4, 1.0, False, None, None])
        self.assertEqual(inspect.signature(vdblic.Renderer).parameters["size"].default, (1024, 1024))
        self.assertEqual(list(inspect.signature(vdblic.Renderer(size=8)).parameters), ["texture", "frame"])

    def test_help_reads_as_a_page(self):
        for name in set(vdblic.__all__) - {"__version__"}:
            self.assertTrue(getattr(vdblic, name).__doc__, name)
        for name in re.findall(r"^    (\w+)\(", vdblic.__doc__, re.MULTILINE):
            self.assertIn(name, vdblic.__all__)

    def test_types(self):
        """mypy finds what is misspelled and takes what is right, in the samples too."""
        python = peer("mypy", "mypy")
        if python is None:
            self.skipTest("mypy is missing: tests/peers.sh gets it")
        (self.folder / "good.py").write_text(
            "import datetime\nimport numpy\nimport vdblic\n"
            "field = numpy.ones((4, 4, 4, 3), numpy.float32)\n"
            "for texture in vdblic.advect([field], refine=2.0, dt=datetime.timedelta(seconds=1), with_=['q'], method='lic'):\n"
            "    picture = vdblic.Renderer(size=64, look='ink', opacity=[(0, 0), (1, 0.5)])(texture)\n"
            "    picture.save('a.png')\n"
            "    print(texture['density'].shape, texture.to_xarray(), vdblic.diff(texture, 'a.vdb', fail=1)['verdict'])\n"
            "flow = vdblic.Flow(bbox_world=(0, 0, 0, 1, 1, 1), progress=lambda done, total: print(done))\n"
            "print(flow.push(field, 1)[0].time, vdblic.film([field], 'f.mp4', size=(64, 48)).data)\n")
        wrong = {"advect(x, refin=2)": "refin", "advect(x, method='lik')": "method", "Renderer(sice=3)": "sice",
                 "Renderer(look='nice')": "look", "film(x, orbits=1)": "orbits", "Flow(frames='1')": "frames",
                 "streaks(x, life=3)": "life",
                 "coherence(x, x, sample=3)": "sample", "write('a.vdb', x, voxel=3)": "voxel"}
        (self.folder / "bad.py").write_text("import vdblic\nx = 'v.vdb'\n" + "".join(f"vdblic.{call}\n" for call in wrong))

        def mypy(*paths):
            return subprocess.run([python, "-m", "mypy", "--strict", "--ignore-missing-imports",
                                   "--follow-imports=silent", "--cache-dir",
                                   self.folder / "cache", *paths], cwd=self.folder,
                                  env=os.environ | {"MYPYPATH": str(MODULE)}, text=True, capture_output=True)

        done = mypy("good.py", *sorted((SOURCE / "samples/python").glob("*.py")))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        found = mypy("bad.py").stdout
        for line, name in enumerate(wrong.values(), 3):
            self.assertRegex(found, rf'bad.py:{line}: error: .*"{name}"')
        command = [python, "-m", "mypy", "--ignore-missing-imports", "--cache-dir", self.folder / "cache", "-p", "vdblic"]
        done = subprocess.run(command, cwd=self.folder, env=os.environ | {"MYPYPATH": str(MODULE)}, text=True, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
