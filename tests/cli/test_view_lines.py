"""vdblic_view of lines: what the server tells of them."""

import json
import shlex
import shutil
import struct
import unittest

import numpy

import python_module  # pylint: disable=unused-import
from vdblic._core import read_lines
from viewer import ViewerTest

STREAKS = "--method", "streaks", "--draw", "lines", "--spacing", 4, "--tail", 3, "--with", "q"


def unpacked(packet):
    """What a packet tells, and its columns."""
    (length,) = struct.unpack_from("<I", packet)
    told, at, columns = json.loads(packet[4 : 4 + length]), 4 + length, {}
    names = [("driver", "f4", "points"), *([("color", "f4", "points")] if told["hasColor"] else []), ("id", "u4", "lines"),
             ("counts", "u4", "lines"), *((axis, "u2", "points") for axis in "xyzt"), ("own", "u2", "lines")]
    for name, kind, count in names:
        columns[name] = numpy.frombuffer(packet, "<" + kind, told[count], at)
        at += columns[name].nbytes
    assert at == len(packet)
    return told, columns


class Server(ViewerTest):
    def setUp(self):
        super().setUp()
        for path in self.data.glob("v.*.vdb"):
            (self.folder / path.name).symlink_to(path)
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "s.%04d.vdb", *STREAKS)

    def lines(self, state, frame=2):
        status, headers, packet = self.request("lines", {"state": state, "frame": frame})
        self.assertEqual((status, headers["Content-Type"]), (200, "application/octet-stream"), packet[:200])
        return unpacked(packet)

    def test_lines_are_those_of_the_file(self):
        self.start("s.%04d.vdb")
        self.assertTrue(self.ask("sequence")["lines"])
        lines, _ = read_lines(str(self.folder / "s.0002.vdb"))
        for stretch in ([1, 1, 1], [1, 2, 0.5]):
            told, columns = self.lines({"opacity-by": "q", "stretch": stretch})
            low, high = numpy.array(told["low"]), numpy.array(told["high"])
            places = low + numpy.stack([columns[axis] for axis in "xyz"], axis=1) / 65535 * (high - low)
            self.assertEqual(told["part"], 1)
            self.assertEqual(columns["id"].tolist(), lines["id"].astype("u4").tolist())
            self.assertEqual(columns["counts"].tolist(), lines["counts"].tolist())
            self.assertLess((abs(places - lines["points"] * stretch) / (high - low)).max(), 1 / 4000)
            for name, scalar in ("driver", "q"), ("color", "magnitude"):
                numpy.testing.assert_array_equal(columns[name], lines["scalars"][scalar])
            heads = numpy.maximum.reduceat(lines["opacity"], numpy.cumsum(lines["counts"]) - lines["counts"])
            numpy.testing.assert_allclose(columns["own"] / 65535, heads, atol=1e-4)
            along = lines["opacity"] / numpy.repeat(heads, lines["counts"])
            self.assertLess(abs(columns["t"] / 65534 - along)[columns["t"] < 65534].max(), 0.001)
        told, columns = self.lines({"roi-box": [0, 0, 0, 0.5, 0.5, 0.5]})
        self.assertLess(0, len(columns["x"]))
        self.assertLess(len(columns["x"]), 0.6 * len(lines["points"]))

    def test_voxels_have_none(self):
        self.start("lic.%04d.vdb")
        self.assertFalse(self.ask("sequence")["lines"])
        self.assertEqual(self.request("lines", {"state": {}, "frame": 1})[0], 204)

    def test_lines_in_voxels(self):
        """Pictures show both, as vdblic_render makes them; they follow the files of the lines."""
        alone = self.pictures("lic.%04d.vdb")
        self.stop()
        both = self.pictures("lic.%04d.vdb", "--lines", "s.%04d.vdb")
        self.assertFalse(self.ask("sequence")["lines"])  # the page shows pictures
        for state, of_lines, of_voxels in zip(self.STATES, both, alone):
            self.assertNotEqual(of_lines, of_voxels)
            _, *words = shlex.split(self.ask("command", {"state": {"size": [64, 40], **state}})["command"])
            self.assertIn("--lines=s.%04d.vdb", words)
            words[words.index("-o") + 1] = "made.png"
            self.outputs("vdblic_render", *words, "--frames", 2)
            self.assertEqual(self.contents("made.png"), of_lines)
        self.assertEqual(self.request("picture", {"client": "test", "state": {"lines": "v.%04d.vdb"}, "frame": 2})[0], 400)
        version = self.ask("status")["version"]
        shutil.copy(self.folder / "s.0001.vdb", self.folder / "s.0002.vdb")
        version = self.told_since(version)
        self.assertNotEqual(self.picture(self.STATES[1], frame=2), both[1])
        (self.folder / "s.0002.vdb").unlink()
        self.told_since(version)
        status, _, told = self.request("picture", {"client": "test", "state": {"size": [64, 40]}, "frame": 2, "settle": True})
        self.assertEqual((status, b"s.0002.vdb: the lines of frame 2 are missing" in told), (422, True), told)

    def told_since(self, version):
        """The version that the page is told, which is a new one; the frames are those of the texture."""
        status = self.ask("status")
        self.assertGreater(status["version"], version)
        self.assertEqual(status["frames"], [1, 2, 3])
        return status["version"]

    def test_what_cannot_be_drawn_is_refused_at_once(self):
        """As by vdblic_render: the same message, and no address."""
        for arguments, words in ((("s.0002.vdb", "--lines", "s.%04d.vdb"), "s.0002.vdb: holds lines itself"),
                                 (("lic.0002.vdb", "--lines", "none.%04d.vdb"), "none.0002.vdb: the lines of frame 2 are missing"),
                                 (("lic.0002.vdb", "--lines", "v.%04d.vdb"), "v.0002.vdb: holds no lines")):
            with self.subTest(arguments):
                told = [self.fails(3, tool, *arguments, *more).split(": ", 1)[1]
                        for tool, *more in (("vdblic_render", "-o", "a.png"), ("vdblic_view",))]
                self.assertIn(words, told[0])
                self.assertEqual(told[0], told[1])

    STATES = {}, {"opacity-by": "q", "look": "vortex", "annotate": "colorbar"}, {"eye": [12, -30, 20], "range": [0, 1]}

    def pictures(self, *arguments):
        self.start(*arguments)
        return [self.picture(state, frame=2) for state in self.STATES]

    def test_refusals(self):
        self.start("s.%04d.vdb")
        whole = (self.folder / "s.0002.vdb").read_bytes()
        for damaged in b"", whole[: len(whole) // 2], b"x" * 5000:
            (self.folder / "s.0002.vdb").write_bytes(damaged)
            status, _, text = self.request("lines", {"state": {}, "frame": 2})
            self.assertEqual(status, 422, text[:200])
            self.assertIn(b"s.0002.vdb", text)
        for body in {"state": {"opacity-by": "none"}, "frame": 1}, {"state": {}, "frame": 9}, {"state": 1, "frame": 1}:
            self.assertIn(self.request("lines", body)[0], (400, 422))
        self.assertEqual(self.request("lines", {"state": {}, "frame": 1})[0], 200)

    def test_a_picture_ends_that_nobody_waits_for(self):
        self.start("s.%04d.vdb")
        self.assertEqual(self.ask("rest", {"client": "test", "turn": 7}), {})
        late = {"client": "test", "turn": 6, "state": {"size": [64, 40]}, "frame": 1}
        self.assertEqual(self.request("picture", late)[0], 204)
        self.assertEqual(self.request("picture", {**late, "turn": 8})[0], 200)
        self.assertEqual(self.ask("rest", {"client": "test", "turn": 3}), {})


if __name__ == "__main__":
    unittest.main()
