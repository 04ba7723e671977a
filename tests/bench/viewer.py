#!/usr/bin/python3
"""The table "Viewer" of docs/evidence.md.

    tests/bench/viewer.py build/release TEXTURE

TEXTURE is one file with the grids vorticity and q. Times are elapsed ones, medians of five; starts are of five servers.
"""

import http.client
import json
import pathlib
import re
import statistics
import subprocess
import sys
import time

SIZE, QUARTER, MOVING = [1280, 800], 0.25, 0.2


class Viewer:
    def __init__(self, tools, texture):
        self.began = time.perf_counter()
        self.process = subprocess.Popen([tools / "vdblic_view", texture], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                        text=True)
        port, token = re.fullmatch(r"http://\S+?:(\d+)/(\w+)/\n", self.process.stdout.readline()).groups()
        self.port, self.token = int(port), token
        self.frame = int(re.search(r"(\d+)\.vdb$", str(texture))[1])

    def ask(self, path, **body):
        """The bytes of an answer."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port)
        connection.request("POST", f"/{self.token}/{path}", json.dumps({"frame": self.frame} | body),
                           {"Content-Type": "application/json"})
        answer = connection.getresponse()
        data = answer.read()
        connection.close()
        if answer.status != 200:
            raise RuntimeError(data)
        return data

    def picture(self, **state):
        """Seconds for a picture."""
        begin = time.perf_counter()
        self.ask("picture", client="bench", state={"size": SIZE} | state, format="jpeg", settle=False)
        return time.perf_counter() - begin

    def end(self):
        self.process.terminate()
        self.process.wait()


def main():
    tools, texture = pathlib.Path(sys.argv[1]).resolve() / "tools", pathlib.Path(sys.argv[2]).resolve()
    rows = {"from the start to the first picture, a quarter of the size": [], "a picture of one ray a pixel": [],
            "the final picture, four rays a pixel": [], "pictures a second while something moves": []}
    for look in "flow", "vortex":
        starts = []
        for _ in range(5):
            viewer = Viewer(tools, texture)
            viewer.picture(look=look, scale=QUARTER)
            starts.append(time.perf_counter() - viewer.began)
            if len(starts) < 5:
                viewer.end()
        camera = json.loads(viewer.ask("scene", state={"look": look, "size": SIZE}))["camera"]
        turn = iter(range(1, 1000))  # another eye for each picture, as while something moves

        def new(**state):
            aside = next(turn) / 1000 * (camera["eye"][0] - camera["target"][0])
            eye = [camera["eye"][0] + aside, *camera["eye"][1:]]
            return viewer.picture(look=look, eye=eye, target=camera["target"], **state)

        one = statistics.median(new() for _ in range(5))
        four = statistics.median(new(samples=4) for _ in range(5))
        moving = statistics.median(new(scale=MOVING, step=1.5) for _ in range(40))
        viewer.end()
        for row, text in zip(rows.values(), (f"{statistics.median(starts):.1f} s", f"{one:.1f} s", f"{four:.1f} s",
                                             f"{1 / moving:.0f}")):
            row.append(text)
    print("| | `flow` | `vortex` |\n|---|---|---|")
    for name, row in rows.items():
        print(f"| {name} | {row[0]} | {row[1]} |")


if __name__ == "__main__":
    main()
