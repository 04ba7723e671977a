"""vdblic_view's server: what it answers, what it keeps, and what it refuses."""

import concurrent.futures
import contextlib
import http.client
import json
import os
import pathlib
import re
import shlex
import signal
import socket
import subprocess
import tempfile
import threading
import unittest

from support import BIN
from viewer import ViewerTest


class Pictures(ViewerTest):
    def test_the_kept_files_and_the_command_make_the_picture(self):
        self.start("lic.%04d.vdb", "--samples", 2)
        states = [
            {},
            {"look": "vortex", "eye": [3.1, -4.2, 3.3], "target": [0.5, 0.4, 0.3], "fov": 50.25},
            {"look": "vortex", "eye": [-2.1, -4.2, 2.3], "target": [0.5, 0.4, 0.3]},  # the same from elsewhere, then cut
            {"look": "vortex", "eye": [-2.1, -4.2, 2.3], "target": [0.5, 0.4, 0.3], "solid": "domain",
             "clip-plane": [[0.5, 0.5, 0.5, 1, 0.2, 0]]},
            {"look": "smoke", "projection": "orthographic", "annotate": "axes,colorbar,time,title=It's a title"},
            {"color-by": "q", "opacity-by": "magnitude", "opacity": "0:0,0.5:0.123,1:0.8", "range": [-1.5, 2],
             "clip-plane": [[0.5, 0.5, 0.5, 1, 0.2, 0]], "light": [[1, 0, 2]], "solid": "domain", "stretch": [1, 1, 2]},
            {"color-scale": "log", "range": [0.1, 3], "annotate": "colorbar"},
            {"by": "magnitude", "opacity-by": "q", "opacity-scale": "log"},
            {"roi-box": [0.1, 0.1, 0, 0.7, 0.5, 0.3], "clip-plane": [[0.3, 0.3, 0.2, 0.5, -0.5, 0.7]]},
            {"look": "smoke", "colors": "0:#102040,0.3:#e2581a,1:#fff6d5"},
        ]
        for number, state in enumerate(states):
            with self.subTest(state=state):
                state = {"size": [64, 40], "samples": 2, **state}
                kept = self.keep("picture", state, 2)
                shown = self.contents(kept)
                self.assertEqual(shown, self.picture(state, 2))
                files = self.ask("keep", {"kind": "files", "state": state, "frame": 2})
                inline = self.ask("command", {"state": state})["command"]
                for name, command in ("files", files["command"]), ("command", inline):
                    tool, *words = shlex.split(command)
                    image = f"{name}-{number}.png"
                    words[words.index("-o") + 1] = image
                    self.outputs(tool, *words, "--frames", 2)
                    self.assertEqual(self.contents(image), shown, command)

    def test_streaks_have_their_look(self):
        """As in vdblic_render, unless a state names another one."""
        self.outputs("vdblic_synth", "abc", "-o", "v.vdb", "--size", 24, 16, 12, "--frames", 1)
        for form in "voxels", "lines":
            self.outputs("vdblic_advect", "v.vdb", "-o", "s.vdb", "--method", "streaks", "--draw", form, "--dt", 0.04, "--spacing", 3,
                         "--refine", 4)
            self.start("s.vdb")
            for state, look in ({}, "streaks"), ({"look": "smoke"}, "smoke"), ({"solid": "domain"}, "streaks"):
                state = {"size": [64, 40], **state}
                self.assertEqual(self.ask("scene", {"state": state, "frame": 1})["look"], look)
                _, *words = shlex.split(self.ask("command", {"state": state})["command"])
                words[words.index("-o") + 1] = "image.png"
                self.outputs("vdblic_render", *words)
                self.assertEqual(self.contents("image.png"), self.picture(state, 1))
            self.stop()

    @unittest.skipIf(os.environ.get("VDBLIC_SANITIZED") == "1", "sanitizers hold more memory than there is")
    def test_a_texture_larger_than_the_memory(self):
        self.outputs("vdblic_noise", "--size", 192, 192, 192, "-o", "noise.0001.vdb")
        shown = []
        for limit in (), ("--max-memory", "128M"):
            self.start("noise.%04d.vdb", "--texture", "noise", *limit)
            shown.append(self.picture({}))
            peak = self.most_resident()
            self.stop()
        self.assertEqual(shown[1], shown[0])
        self.assertLess(peak, 1.1 * (128 << 20))

    @unittest.skipUnless((BIN / "vdblic_export").exists(), "the tool is not built, because pybind11 is missing")
    @unittest.skipIf(os.environ.get("VDBLIC_SANITIZED") == "1", "a sanitized module needs a sanitized Python")
    def test_coarser_copies_are_shown_first(self):
        self.outputs("vdblic_noise", "--size", 192, 192, 192, "-o", "noise.0001.vdb")
        self.start("noise.%04d.vdb", "--texture", "noise", "--max-memory", "128M")
        advised = re.search("made by: vdblic_export (.*)", self.said())[1].split()
        self.assertEqual(advised, "noise.%04d.vdb -o noise.%04d.vdb --levels 1".split())
        self.stop()
        self.outputs("vdblic_export", *advised[:-1], 2)
        body = {"client": "test", "state": {"size": [64, 40]}, "frame": 1, "format": "png"}
        self.start("noise.%04d.vdb", "--texture", "noise", "--max-memory", "128M")
        _, headers, first = self.request("picture", body)
        self.assertEqual(headers["Vdblic-Settled"], "0")
        version = self.ask("status")["version"]
        self.wait_until(lambda: self.ask("status")["version"] > version, "it stays coarse")
        _, headers, refined = self.request("picture", body)
        self.assertEqual(headers["Vdblic-Settled"], "1")
        self.assertNotEqual(first, refined)
        self.assertEqual(refined, self.picture({}))
        self.assertLess(self.most_resident(), 1.1 * (128 << 20))
        self.assertNotIn("vdblic_export", self.said())
        self.stop()
        self.start("noise.level1.%04d.vdb", "--texture", "noise")
        self.assertEqual(first, self.picture({}))
        self.stop()
        self.start("noise.%04d.vdb", "--texture", "noise")  # there is memory for the frame
        self.assertEqual(refined, self.picture({}, settle=False))
        os.utime(self.folder / "noise.0001.vdb")  # replaced since
        self.stop()
        self.start("noise.%04d.vdb", "--texture", "noise", "--max-memory", "128M")
        self.assertEqual(refined, self.picture({}, settle=False))

    def test_a_start_state_comes_from_the_command_line(self):
        (self.folder / "keys.json").write_text('{"keys": [{"frame": 1, "fov": 20}]}', encoding="utf-8")
        (self.folder / "transfer.json").write_text('{"range": [0, 3], "colors": [[0, 1, 0, 0], [1, 0, 0, 1]]}',
                                                   encoding="utf-8")
        self.start("lic.%04d.vdb", "--look", "ink", "--fov", 50, "--light", -1, 0, 2, "--camera", "keys.json",
                   "--transfer", "transfer.json", "--size", 64, 40)
        start = self.ask("sequence")["start"]
        self.assertEqual(start, {"look": "ink", "fov": 50, "light": [[-1, 0, 2]], "keys": [{"frame": 1, "fov": 20}],
                                 "size": [64, 40]})
        scene = self.ask("scene", {"state": start, "frame": 1})
        self.assertEqual((scene["range"], scene["camera"]["fov"], scene["colors"]),
                         ([0, 3], 20, [[0, "#ff0000"], [1, "#0000ff"]]))
        # The colours of the file are in the kept one.
        kept = self.ask("keep", {"kind": "files", "state": start, "frame": 1})["files"]
        self.assertEqual(json.loads(self.contents(kept[0]))["colors"], [[0, 1, 0, 0], [1, 0, 0, 1]])
        self.assertEqual(json.loads(self.contents(kept[1])), {"keys": start["keys"]})

    def test_a_view_of_all_in_a_direction(self):
        self.start("lic.%04d.vdb")
        of = lambda v, w: sum(a * b for a, b in zip(v, w))
        for state in ({}, {"projection": "orthographic"},
                      {"fov": 20, "eye": [9, 9, 9], "up": [0, 1, 0], "size": [90, 200]}):
            for forward, up in ([-2, 0, 0], [0, 0, 1]), ([0, 0, 1], [0, 1, 0]), ([1, 2, -1], [0, 0, 1]):
                with self.subTest(state=state, forward=forward):
                    state = {"size": [300, 200], **state}
                    camera = self.ask("fit", {"state": state, "forward": forward, "up": up})
                    view = [b - a for a, b in zip(camera["eye"], camera["target"])]
                    self.assertAlmostEqual(of(view, forward) / (of(view, view) * of(forward, forward)) ** 0.5, 1)
                    # Some of the picture is near an edge, nothing beyond it.
                    box = self.ask("scene", {"state": state, "frame": 1})["box"]
                    depth = lambda p: of([b - a for a, b in zip(camera["eye"], p)], view) / of(view, view) ** 0.5
                    right = [view[1] * up[2] - view[2] * up[1], view[2] * up[0] - view[0] * up[2],
                             view[0] * up[1] - view[1] * up[0]]
                    top = [right[1] * view[2] - right[2] * view[1], right[2] * view[0] - right[0] * view[2],
                           right[0] * view[1] - right[1] * view[0]]
                    most = 0
                    for corner in box:
                        arm = [b - a for a, b in zip(camera["eye"], corner)]
                        half = camera["height"] / 2
                        if camera["projection"] == "perspective":
                            half *= depth(corner)
                        width, height = state["size"]
                        across = abs(of(arm, right)) / of(right, right) ** 0.5 / half / width * height
                        along = abs(of(arm, top)) / of(top, top) ** 0.5 / half
                        most = max(most, across, along)
                    self.assertTrue(0.8 < most < 1, most)
        for forward, up in ([0, 0, 0], [0, 0, 1]), ([0, 0, 2], [0, 0, 1]), ([1, 0], [0, 0, 1]), ([1, 0, 0], "z"):
            self.assertEqual(self.request("fit", {"state": {}, "forward": forward, "up": up})[0], 400)

    def test_further_samples_continue_a_picture(self):
        self.start("lic.%04d.vdb")
        step_by_step = [self.picture({"samples": samples}) for samples in (1, 3, 5)]
        self.assertEqual(step_by_step[-1], self.picture({"samples": 5}, client="another"))
        self.assertNotEqual(step_by_step[0], step_by_step[1])

    def test_a_newer_request_takes_the_place_of_an_older_one(self):
        self.start("lic.%04d.vdb")
        self.picture({})
        slow = {"client": "a", "state": {"size": [1500, 1500], "samples": 500}, "frame": 1}
        statuses = []
        older = threading.Thread(target=lambda: statuses.append(self.request("picture", slow)[0]))
        older.start()
        self.wait_until_busy()
        self.picture({}, client="b")  # somebody else
        self.assertEqual(statuses, [])
        self.picture({}, client="a")
        older.join()
        self.assertEqual(statuses, [204])  # minutes before its time

    def test_thumbnails(self):
        self.start("lic.%04d.vdb")
        ask = lambda state, frame=1: self.request("thumbnail", {"state": state, "frame": frame})
        small = {"size": [96, 64], "look": "ink", "samples": 4}
        status, headers, first = ask(small)
        self.assertEqual((status, headers["Content-Type"], first[:2]), (200, "image/jpeg", b"\xff\xd8"))
        self.assertNotEqual(ask({**small, "look": "smoke"})[2], first)
        self.assertEqual(ask(small)[2], first)
        self.assertEqual(ask({**small, "size": [161, 64]})[0], 400)
        self.assertEqual(ask(small, 7)[0], 400)

    def test_an_older_request_that_arrives_late_ends(self):
        self.start("lic.%04d.vdb")
        body = {"client": "a", "state": {"size": [64, 40]}, "frame": 1}
        turns = [1, 3, 2, 3, 4]
        statuses = [self.request("picture", {**body, "turn": turn})[0] for turn in turns]
        self.assertEqual(statuses, [200, 200, 204, 200, 200])
        self.assertEqual(self.request("picture", {**body, "turn": 1, "client": "b"})[0], 200)

    def test_a_growing_sequence_is_followed(self):
        self.start("lic.%04d.vdb")
        self.assertEqual(self.ask("status")["frames"], [1, 2, 3])
        (self.folder / "lic.0004.vdb").write_bytes(self.contents("lic.0003.vdb"))
        self.assertEqual(self.ask("status")["frames"], [1, 2, 3, 4])
        self.assertEqual(self.picture({}, 4), self.picture({}, 3))

    def test_frames_that_go(self):
        self.start("lic.%04d.vdb")
        first, last = self.picture({}, 1), self.picture({}, 3)
        (self.folder / "lic.0002.vdb").unlink()
        self.assertEqual(self.ask("status")["frames"], [1, 3])
        self.assertEqual(self.picture({}, 3), last)
        self.assertEqual(self.request("picture", {"client": "a", "state": {}, "frame": 2})[0], 400)
        (self.folder / "lic.0004.vdb").write_bytes(self.contents("lic.0003.vdb"))
        self.assertEqual(self.ask("status")["frames"], [1, 3, 4])
        self.assertEqual(self.picture({}, 4), last)
        for path in self.folder.glob("lic.*.vdb"):
            path.unlink()
        self.assertEqual(self.ask("status")["frames"], [1, 3, 4])  # until there are others
        self.assertEqual(self.request("picture", {"client": "a", "state": {}, "frame": 4})[0], 422)
        (self.folder / "lic.0001.vdb").write_bytes((self.data / "lic.0001.vdb").read_bytes())
        self.assertEqual(self.ask("status")["frames"], [1])
        self.assertEqual(self.picture({}, 1), first)

    def test_a_frame_that_is_replaced(self):
        self.start("lic.%04d.vdb", "--range", 0, 3, "--opacity", "0:0,1:1")  # no choice follows it later
        first, third = self.picture({}, 1), self.picture({}, 3)
        self.assertNotEqual(first, third)
        version = self.ask("status")["version"]
        self.assertEqual(self.ask("status")["version"], version)
        (self.folder / "new").write_bytes(self.contents("lic.0001.vdb"))
        os.replace(self.folder / "new", self.folder / "lic.0003.vdb")
        status = self.ask("status")
        self.assertGreater(status["version"], version)
        self.assertEqual(status["frames"], [1, 2, 3])
        self.assertEqual(self.picture({}, 3), first)

    def test_a_film_and_its_end(self):
        self.start("lic.%04d.vdb")
        state = {"size": [64, 40]}
        film = self.keep("film", state, fps=12)
        self.assertEqual(self.contents(film)[4:8], b"ftyp")
        self.ask("keep", {"kind": "film", "state": {**state, "samples": 4000}})
        self.assertEqual(self.request("keep", {"kind": "film", "state": state})[0], 400)  # one at a time
        self.assertEqual(self.stop(), -signal.SIGTERM)
        self.assertEqual([name for name in self.files() if name.startswith("view-")], [film])

    def test_pictures_are_kept_in_the_background(self):
        self.start("lic.%04d.vdb")
        slow = {"kind": "picture", "state": {"size": [1500, 1500], "samples": 4000}, "frame": 1}
        jobs = [self.ask("keep", slow) for _ in range(3)]  # each would take minutes
        self.assertEqual([job["file"] for job in jobs], ["view-001.png", "view-002.png", "view-003.png"])
        self.assertEqual(self.request("keep", slow)[0], 400)  # three at a time
        self.wait_until(lambda: self.job(jobs[0]["job"])["done"] > 0, "no progress")
        self.picture({})  # others are not kept waiting
        self.ask("stop", {"job": jobs[0]["job"]})
        self.wait_until(lambda: self.job(jobs[0]["job"])["finished"], "no end")
        self.assertEqual(self.job(jobs[0]["job"])["error"], "stopped")
        self.assertFalse(self.job(jobs[1]["job"])["finished"])
        self.assertEqual(self.request("stop", {"job": 99})[0], 400)
        self.assertEqual(self.keep("picture", {"size": [8, 8]}), "view-001.png")
        for _ in range(12):  # no list that grows and grows
            self.keep("picture", {"size": [8, 8]})
        self.assertLessEqual(len(self.ask("status")["jobs"]), 8)
        self.assertEqual(self.stop(), -signal.SIGTERM)

    def test_forty_saves_at_a_time(self):
        """Each is answered: its files are there, or the answer says what to wait for."""
        self.start("lic.%04d.vdb")
        begin, state = threading.Barrier(40), {"size": [8, 8]}

        def save(number):
            begin.wait(60)
            return self.request("keep", {"kind": ("files", "picture")[number % 2], "state": state, "frame": 1})

        with concurrent.futures.ThreadPoolExecutor(40) as pool:
            answers = list(pool.map(save, range(40)))
        told = [(status, json.loads(text)) for status, _, text in answers]
        self.assertEqual([status for status, _ in told[::2]], [200] * 20)
        kept = [file for _, answer in told[::2] for file in answer["files"]]
        for status, answer in told[1::2]:
            if status == 200:
                self.wait_until(lambda job=answer["job"]: job not in
                                [one["job"] for one in self.ask("status")["jobs"] if not one["finished"]], "no end")
                kept.append(answer["file"])
            else:
                self.assertEqual((status, answer["error"]),
                                 (400, "3 pictures are being made; wait for an end or stop one"))
        self.assertGreaterEqual(len(kept), 43)
        self.assertEqual(sorted(kept), [name for name in self.files() if name.startswith("view-")])

    @unittest.skipUnless(os.geteuid() == 0, "only root may mount a small file system")
    def test_a_full_disk(self):
        """A picture, a film and the files that do not fit are told with the disk's reason, and leave nothing."""
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16k", "none", self.folder], check=False).returncode:
            self.skipTest("mounting is not allowed here")
        self.addCleanup(lambda: subprocess.run(["umount", "-l", self.folder], check=True))
        self.start(self.data / "lic.%04d.vdb")
        (self.folder / "full").write_bytes(bytes(12 << 10))
        for kind in "picture", "film":
            job = self.ask("keep", {"kind": kind, "state": {"size": [160, 120]}, "frame": 1})
            self.wait_until(lambda number=job["job"]: self.job(number)["finished"], "no end")
            self.assertRegex(self.job(job["job"])["error"], f"{job['file']}: .*No space left on device")
        with open(self.folder / "full", "ab") as full, contextlib.suppress(OSError):
            full.write(bytes(4 << 10))
        status, _, text = self.request("keep", {"kind": "files", "state": {"size": [8, 8]}, "frame": 1})
        self.assertEqual(status, 507, text)
        self.assertIn(b"No space left on device", text)
        self.assertEqual(self.files(), ["full"])

    def test_no_link_is_followed_out_of_the_folder(self):
        self.start("lic.%04d.vdb")
        with tempfile.TemporaryDirectory() as outside:
            for ending in "png", "transfer.json":
                os.symlink(pathlib.Path(outside) / "planted", self.folder / f"view-001.{ending}")
                self.addCleanup((self.folder / f"view-001.{ending}").unlink)
            self.assertNotIn("view-001", self.keep("picture", {"size": [8, 8]}))
            for file in self.ask("keep", {"kind": "files", "state": {"size": [8, 8]}, "frame": 1})["files"]:
                self.assertNotIn("view-001", file)
            self.assertEqual(os.listdir(outside), [])

    def test_a_job_that_fails_says_why(self):
        self.start("lic.%04d.vdb")
        (self.folder / "lic.0002.vdb").write_bytes(b"broken")
        job = self.ask("keep", {"kind": "picture", "state": {"size": [8, 8]}, "frame": 2})
        self.wait_until(lambda: self.job(job["job"])["finished"], "no end")
        self.assertIn("lic.0002.vdb", self.job(job["job"])["error"])
        for impossible in {"size": [9000, 8]}, {"look": "none"}:
            self.assertEqual(self.request("keep", {"kind": "picture", "state": impossible, "frame": 1})[0], 400)

    def test_the_address_stands_alone(self):
        self.start("lic.%04d.vdb")
        self.ask("sequence")
        said = self.said()
        self.assertEqual(self.viewer.stdout.read(), "")
        self.assertNotIn(self.token, said)
        self.assertIn("Ctrl-C", said)

    def test_frames_beyond_the_memory_are_read_again(self):
        self.start("lic.%04d.vdb", "--max-memory", "128M")
        shown = [self.picture({}, frame) for frame in (1, 2, 3)]
        self.assertEqual(shown, [self.picture({}, frame) for frame in (1, 2, 3)])
        status, _, text = self.request("picture", {"client": "a", "state": {"size": [8000, 8000]}, "frame": 1})
        self.assertEqual(status, 422, text)
        self.assertIn(b"memory", text)

    def test_the_memory_of_frames(self):
        def most(*arguments):
            self.start("lic.%04d.vdb", "-v", *arguments)
            said = self.said()
            self.stop()
            number, unit = re.search(r"kept in memory up to (\S+) (\S)iB", said).groups()
            return float(number) * 1024 ** " KMG".index(unit)
        with open("/proc/meminfo", encoding="utf-8") as text:
            free = 1024 * int(re.search(r"MemAvailable:\s+(\d+)", text.read())[1])
        self.assertLess(most(), 1.05 * min(2e9, free / 3))
        self.assertGreater(most(), 0.95 * min(2e9, free / 6))
        self.assertLessEqual(most("--max-memory", "256M"), 128 << 20)
        self.assertGreater(most("--max-memory", "256M"), 64 << 20)

    def test_messages_before_any_serving(self):
        self.assertIn("-", self.fails(2, "vdblic_view", "-"))
        self.assertIn("none.vdb", self.fails(3, "vdblic_view", "none.vdb"))
        self.assertIn("--fov", self.fails(2, "vdblic_view", "lic.%04d.vdb", "--fov", "wide"))
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = taken.getsockname()[1]
            self.assertIn(f"--port {port}", self.fails(2, "vdblic_view", "lic.%04d.vdb", "--port", port))

    def test_other_hosts_are_warned_of(self):
        self.start("lic.%04d.vdb", "--host", "0.0.0.0")
        self.assertIn("warning", self.said())


class Attacks(ViewerTest):
    """No request reads or writes what it should not, ends the server, or makes it take more and more memory."""

    def setUp(self):
        super().setUp()
        self.start("lic.%04d.vdb")

    def tearDown(self):
        if self.viewer.poll() is None:
            self.picture({})  # the server goes on
        super().tearDown()

    def status(self, path, body=None, **options):
        return self.request(path, body, **options)[0]

    def test_the_token_is_needed(self):
        self.assertEqual(self.status(""), 200)
        for token in "0" * 32, self.token[:-1], self.token + "0", "", self.token.upper() + "x", "%00", "%C3%A9":
            with self.subTest(token=token):
                for path in "", "sequence", "main.js":
                    self.assertEqual(self.request(path, token=token)[0], 403)
        self.assertNotEqual(self.token, "0" * 32)
        self.assertGreaterEqual(len(self.token), 32)

    def test_foreign_hosts_and_origins_get_nothing(self):
        own = f"127.0.0.1:{self.port}"
        for headers, status in [({"Host": "evil.example"}, 421), ({"Host": f"evil.example:{self.port}"}, 421),
                                ({"Host": "127.0.0.1.evil.example"}, 421), ({"Host": ""}, 421),
                                ({"Origin": "http://evil.example"}, 403), ({"Origin": "null"}, 403),
                                ({"Origin": f"http://localhost:{self.port}"}, 403), ({"Origin": f"https://{own}"}, 403),
                                ({"Sec-Fetch-Site": "cross-site"}, 403), ({"Sec-Fetch-Site": "same-site"}, 403),
                                ({"Origin": f"http://{own}"}, 200), ({"Host": "localhost:9000"}, 200)]:
            with self.subTest(headers=headers):
                self.assertEqual(self.status("sequence", headers=headers), status)
                if status != 200:
                    self.assertEqual(self.status("picture", {"state": {}, "frame": 1}, headers=headers), status)
        for headers in {"Content-Type": "text/plain"}, {"Content-Type": "multipart/form-data; boundary=x"}, \
                {"Content-Encoding": "gzip"}:
            self.assertEqual(self.status("picture", {"state": {}, "frame": 1}, headers=headers), 415)

    def test_answers_bind_the_browser(self):
        _, headers, _ = self.request("")
        self.assertIn("default-src 'none'", headers["Content-Security-Policy"])
        self.assertEqual((headers["X-Content-Type-Options"], headers["Referrer-Policy"]), ("nosniff", "no-referrer"))

    def test_paths_lead_nowhere(self):
        for path in ("../../../etc/passwd", "%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "page/../state.cpp",
                     "..\\..\\x", "lic.0001.vdb", "main.js/", "main.js%00", "MAIN.JS", "." * 100):
            with self.subTest(path=path):
                status, _, text = self.request(path)
                self.assertIn(status, (400, 403, 404))
                self.assertNotIn(b"root:", text)
        self.assertEqual(self.status("x" * 5000), 403)
        for method in "PUT", "DELETE", "OPTIONS", "HEAD", "TRACE":
            self.assertIn(self.status("", method=method), (400, 405))

    def test_no_state_names_a_file(self):
        (self.folder / "secret.json").write_text('{"range": [0, 1]}', encoding="utf-8")
        for state in ({"transfer": "secret.json"}, {"camera": "secret.json"}, {"roi": "lic.0001.vdb"}, {"texture": "q"},
                      {"solid": "lic.0001.vdb"}, {"solid": "/etc/passwd"}, {"look": "flow\n--transfer=secret.json"},
                      {"output": "x.png"}, {"film": "x.mp4"}, {"-o": "x.png"}, {"config": "secret.json"}, {"help": 1},
                      {"look --transfer": "secret.json"}, {"opacity": "--transfer=secret.json"}):
            with self.subTest(state=state):
                for path in "picture", "scene", "command", "histograms":
                    isText = path == "command" and state.keys() & {"look", "opacity"}  # quoted for the shell, not read
                    self.assertEqual(self.status(path, {"state": state, "frame": 1}), 200 if isText else 400)
        for body in {"kind": "picture", "format": "../x.png"}, {"kind": "picture", "format": "sh"}, {"kind": "/etc"}:
            self.assertEqual(self.status("keep", {**body, "state": {"size": [8, 8]}, "frame": 1}), 400)
        self.assertEqual([name for name in self.files() if not name.endswith(".vdb")], ["secret.json"])

    def test_broken_and_hostile_json(self):
        of_state = lambda state: b'{"frame": 1, "state": ' + state + b"}"
        for body in (b"", b"{", b"[]", b"null", b"\xff\xfe", b'"x"', b"[" * 100000, b'{"a":' * 100000, of_state(b"3"),
                     of_state(b'{"eye": [1, 2]}'), of_state(b'{"eye": [1, 2, "x"]}'), of_state(b'{"fov": 1e999}'),
                     of_state(b'{"fov": null}'), of_state(b'{"size": [0, 0]}'), of_state(b'{"size": [100000, 100000]}'),
                     of_state(b'{"samples": 1000000}'), of_state(b'{"light": []}'), of_state(b'{"keys": 7}'),
                     of_state(b'{"keys": [{"frame": 1, "eye": [0]}]}'),
                     of_state(b'{"opacity": "' + b"0:0," * 50000 + b'"}'),
                     of_state(b'{"clip-plane": [' + b"[1,2,3,4,5,6]," * 9999 + b"[1,2,3,4,5,6]]}"),
                     b'{"state": {}, "frame": "one"}', b'{"state": {}, "frame": 9}',
                     b'{"next": [' + b"1," * 99999 + b'1], "state": {}, "frame": 1}',
                     b'{"client": "' + b"x" * 100000 + b'", "state": {}, "frame": 1}'):
            with self.subTest(body=body[:60]):
                status, _, text = self.request("picture", body)
                self.assertEqual(status, 400, text[:200])
                self.assertLess(len(text), 20000)
                self.assertTrue(json.loads(text)["error"])
        self.assertIn(self.large(b"x" * (3 << 20)), (400, 413))

    def test_requests_of_two_lengths(self):
        """No request hides another one behind it."""
        hidden = f"GET /{self.token}/sequence HTTP/1.1\r\nHost: localhost\r\n\r\n"
        post = f"POST /{self.token}/scene HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        get = f"GET /{self.token}/status HTTP/1.1\r\nHost: localhost\r\n"
        length = f"Content-Length: {len(hidden)}\r\n"
        for head in (get + length, get + "Transfer-Encoding: chunked\r\n", post + length + "Content-Length: 2\r\n",
                     post + length + length, post + length + "Transfer-Encoding: chunked\r\n", post,
                     post + "Content-Length: -2\r\n", post + f"Content-Length: {len(hidden)}, 2\r\n",
                     post.replace("json", "xml") + length, post.replace(self.token, "0" * 32) + length):
            with self.subTest(head=head), socket.create_connection(("127.0.0.1", self.port), 20) as connection:
                connection.sendall((head + "\r\n" + hidden).encode())
                answer = b""
                while part := connection.recv(4096):
                    answer += part
                self.assertIn(answer[:13], (b"HTTP/1.1 400 ", b"HTTP/1.1 403 ", b"HTTP/1.1 415 "))
                self.assertEqual(answer.count(b"HTTP/1.1"), 1)

    def large(self, body):
        """The status of a request that the server may end before it has been sent."""
        with socket.create_connection(("127.0.0.1", self.port), 20) as connection:
            head = f"POST /{self.token}/picture HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
            try:
                connection.sendall(head.encode() + f"Content-Length: {len(body)}\r\n\r\n".encode() + body)
            except OSError:
                pass
            try:
                return int(connection.recv(100).split()[1])
            except (OSError, IndexError):
                return 400

    def test_memory_stays_bounded(self):
        self.picture({})
        before = self.resident()
        for head in ((b"X-Header: " + b"y" * 1000 + b"\r\n") * 20000,
                     b"Transfer-Encoding: chunked\r\n\r\n" + (b"ffff\r\n" + b"x" * 0xffff + b"\r\n") * 400,
                     b"Range: bytes=" + b"0-1," * 7000 + b"0-1\r\n\r\n",
                     b"Content-Length: 99999999999999999999\r\n\r\n", b"Cookie: " + b"c" * 30000):
            with socket.create_connection(("127.0.0.1", self.port), 20) as connection:
                line = f"POST /{self.token}/picture HTTP/1.1\r\nHost: localhost\r\n".encode()
                line += b"Content-Type: application/json\r\n"
                try:
                    connection.sendall(line + head)
                except OSError:
                    continue  # the server has enough
        for number in range(60):  # clients with pictures of their own
            self.picture({"fov": 20 + number}, client=f"c{number}")
        if os.environ.get("VDBLIC_SANITIZED") != "1":  # which keeps freed memory
            self.assertLess(self.resident() - before, 100 << 20)

    def test_connections_that_stay_open(self):
        line = f"GET /{self.token}/sequence HTTP/1.1\r\n".encode()
        held = [socket.create_connection(("127.0.0.1", self.port), 120) for _ in range(200)]
        for number, connection in enumerate(held):
            try:
                connection.sendall([b"", line, line + b"Host: localhost\r\nX: "][number % 3])
            except OSError:
                pass  # closed already
        for _ in range(5):
            self.assertEqual(self.status("sequence"), 200)
        # Of 48 that may be open the oldest were closed to let the others in, whatever they had sent.
        self.assertEqual([connection.recv(1, socket.MSG_DONTWAIT) for connection in held[:100:3]], [b""] * 34)
        for connection in held:
            connection.close()

    def test_clients_that_go_away(self):
        body = json.dumps({"state": {"size": [1200, 1200], "samples": 4000}, "frame": 1, "client": "gone"})
        for number in range(6):
            connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
            connection.request("POST", f"/{self.token}/picture", body.replace("gone", f"gone{number}"),
                               {"Content-Type": "application/json"})
            self.wait_until_busy()
            connection.sock.close()
        self.picture({}, client="here")  # more went away than are cast at a time

    def test_it_ends_while_connections_are_open(self):
        held = [socket.create_connection(("127.0.0.1", self.port), 20) for _ in range(5)]
        self.assertEqual(self.stop(), -signal.SIGTERM)
        for connection in held:
            connection.close()


if __name__ == "__main__":
    unittest.main()
