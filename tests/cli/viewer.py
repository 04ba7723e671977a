"""Shared by the tests of vdblic_view: a viewer that runs, and requests to it."""

import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import urllib.parse

from support import BIN, ToolTest, skip

if not (BIN / "vdblic_view").exists():
    skip("built without vdblic_view")


class ViewerTest(ToolTest):
    """A test case with small textures `lic.%04d.vdb`, frames 1 to 3, in its folder."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="vdblic-")
        cls.addClassCleanup(folder.cleanup)
        cls.data = pathlib.Path(folder.name)
        run = lambda *command: subprocess.run(command, cwd=cls.data, check=True, capture_output=True)
        run(BIN / "vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", "24", "16", "12", "--frames", "1-3")
        run(BIN / "vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--preroll", "2", "--with", "q")

    def setUp(self):
        super().setUp()
        for path in self.data.glob("lic.*.vdb"):
            shutil.copy(path, self.folder)

    def start(self, *arguments):
        """Start a viewer; sets `port`, `token` and `viewer`."""
        self.viewer = subprocess.Popen([str(BIN / "vdblic_view"), *map(str, arguments)], stderr=subprocess.PIPE,
                                       stdout=subprocess.PIPE, text=True, cwd=self.folder)
        self.addCleanup(self.stop)
        self.address = self.viewer.stdout.readline().rstrip("\n")
        found = re.fullmatch(r"http://\S+?:(\d+)/(\w+)/", self.address)
        if not found:
            self.fail(f"vdblic_view says '{self.address}' and {self.viewer.stderr.read()}")
        self.port, self.token = int(found[1]), found[2]

    def said(self):
        """The messages of a viewer, which is stopped."""
        self.viewer.send_signal(signal.SIGTERM)
        return self.viewer.stderr.read()

    def stop(self):
        """End the viewer as a shell does; returns its exit status."""
        if self.viewer.poll() is None:
            self.viewer.send_signal(signal.SIGTERM)
        status = self.viewer.wait(25)  # less than the 30 s that an idle connection is held
        self.viewer.stderr.close()
        self.viewer.stdout.close()
        return status

    def wait_until_busy(self):
        """Wait until the viewer has computed for a quarter of a second more."""
        spent = lambda: sum(map(int, pathlib.Path(f"/proc/{self.viewer.pid}/stat").read_text().rsplit(")")[-1].split()[11:13]))
        enough = spent() + os.sysconf("SC_CLK_TCK") // 4
        self.wait_until(lambda: spent() >= enough, "the viewer does nothing")

    def resident(self, line="VmRSS"):
        """The memory that the viewer holds [bytes]."""
        with open(f"/proc/{self.viewer.pid}/status", encoding="utf-8") as status:
            return 1024 * int(re.search(line + r":\s+(\d+)", status.read())[1])

    def most_resident(self):
        """The most that it held so far [bytes]."""
        return self.resident("VmHWM")

    def request(self, path, body=None, method=None, headers=None, token=None, timeout=120):
        """One request. @return status, headers and body of the answer"""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        given = {"Content-Type": "application/json"} if body is not None else {}
        given.update(headers or {})
        data = body if body is None or isinstance(body, (str, bytes)) else json.dumps(body)
        try:
            path = f"/{self.token if token is None else token}/{urllib.parse.quote(path, safe='/.%')}"
            connection.request(method or ("GET" if body is None else "POST"), path, data, given)
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()
        finally:
            connection.close()

    def ask(self, path, body=None):
        """The JSON of a request that must succeed."""
        status, _, text = self.request(path, body)
        self.assertEqual(status, 200, text)
        return json.loads(text)

    def job(self, number):
        """What the viewer tells of a job."""
        return next(job for job in self.ask("status")["jobs"] if job["job"] == number)

    def keep(self, kind, state, frame=1, **more):
        """Keep a picture or a film, and wait for it. @return its file"""
        job = self.ask("keep", {"kind": kind, "state": state, "frame": frame, **more})
        self.wait_until(lambda: self.job(job["job"])["finished"], f"no {kind}")
        job = self.job(job["job"])
        self.assertEqual(job["error"], "")
        self.assertEqual(job["done"], job["total"])
        return job["file"]

    def picture(self, state, frame=1, **more):
        """The bytes of a picture whose automatic choices are settled."""
        body = {"client": "test", "state": {"size": [64, 40], **state}, "frame": frame,
                "format": "png", "settle": True, **more}
        status, _, data = self.request("picture", body)
        self.assertEqual(status, 200, data[:300])
        return data
