"""Every option in every tool's --help refuses impossible values: status 2 and a message, at once.

New options are tested automatically; their legal values among those tried go into LEGAL. For every push each option gets
every eighth value, the next option the values beside them; tests/nightly.sh tries all of them.
"""

import re
import unittest

import numpy

from support import ToolTest, often

NUMBERS = ["0", "-1", "nan", "inf", "-inf", "1e308", "-1e308", "99999999999999999999", "1.5.2", "0x", "9" * 100000, ""]
TEXTS = ["", "\n", "%s%n"]
FRAMES = ["", "0x", "1-", "nan", "1e308", "1-1000000", "1-10x0", "5-1", "99999999999999999999", "1-5x-1", "9" * 100000,
          "1-3," * 30000]

COMMANDS = {  # valid without the tried option
    "vdblic_synth": ["abc", "-o", "out.vdb", "--size", "4", "4", "4", "--frames", "1"],
    "vdblic_noise": ["-o", "out.vdb", "--size", "4", "4", "4"],
    "vdblic_advect": ["v.0001.vdb", "-o", "out.vdb", "--preroll", "0"],
    "vdblic_render": ["n.vdb", "-o", "out.png", "--texture", "noise", "--size", "8", "8"],
    "vdblic_view": ["n.vdb", "--texture", "noise"],
    "vdblic_diff": ["n.vdb", "n.vdb", "-o", "out.vdb"],
    "vdblic_coherence": ["v.0001.vdb", "n.vdb", "--texture", "noise"],
    "vdblic_info": ["v.0001.vdb"],
    "vdblic_film": ["v.0001.vdb", "-o", "out.png", "--size", "8", "8"],
    "vdblic_import": ["v.npz", "-o", "out.vdb"],
    "vdblic_export": ["n.vdb", "-o", "out.vti"],
}
# Legal values of an option, of those tried. Names may be anything but empty.
LEGAL = {
    "--threads": set(),
    "--max-memory": set(),
    "--scratch": set(),
    "--seed": {"0"},
    "--dt": set(),
    "--velocity-scale": {"-1"},
    "--preroll": {"0"},
    "--frame-velocity": {"0", "-1"},
    "--frame-rotation": {"0", "-1"},
    "--checkpoint-every": {"0"},
    "--lead-in": {"0"},
    "--times": {"0", "-1", "99999999999999999999"},
    "--sharpen": {"0"},
    "--finish": {"0"},
    "--noise-share": {"0"},
    "--bbox": {"0", "-1"},
    "--bbox-world": set(NUMBERS) - {"nan", "1.5.2", "0x", ""},  # any distance
    "--eye": {"0", "-1"},
    "--target": {"0", "-1"},
    "--up": {"-1", "0"},  # but not three zeros
    "vdblic_export --up": set(),  # an axis
    "--modulate": {"0"},
    "--background": {"0"},
    "--background-top": {"0"},
    "--fail": {"0", "99999999999999999999"},
    "--relative": {"0", "99999999999999999999"},
    "--fail-percent": {"0"},
    "--range": {"99999999999999999999"},
    "--opacity-range": {"99999999999999999999"},
    "--background-alpha": {"0"},
    "--solid-color": {"0"},
    "--angles": {"0", "-1"},
    "--orbit": {"0"},
    "--port": {"0"},
    "--limb-darkening": {"0"},
    "--depth-cue": {"0"},
    "--exposure": {"0", "-1"},
    "--shadows": {"0"},
    "--occlusion": {"0"},
    "--aperture": {"0"},
    "--head-light": {"0"},
    "--halo": {"0"},
    "--light": {"0", "-1", "1e308", "-1e308", "99999999999999999999"},  # a direction of any length, but not three zeros
    "--clip-plane": {"0", "-1", "1e308", "-1e308", "99999999999999999999"},
}
NAMES = {"--texture", "--texture-name", "--velocity", "--carry", "--mask", "--noise", "--like", "--json", "--output",
         "--ignore-metadata", "--camera", "--transfer", "--transfer-out", "--roi", "--film", "--solid", "--by", "--lines",
         "--color-by", "--opacity-by", "--array", "--grids"}


def options(help_text):
    """The options with values, by their long names: name → (kind of value, number of values)."""
    found = {}
    for names, rest in re.findall(r"^  (-[\w,-]+)[ \n](.*)", help_text, re.MULTILINE):
        name = max(names.split(","), key=len)
        kind = re.match(r" *(\[(?:\w+,?)+\]|(?:[A-Z]+ )*[A-Z]{1,6}(?:\b|:)|POSITION:(?:OPACITY|#RRGGBB))", rest)
        if not kind or kind.group(1) in ("E", "P", "A", "D"):
            continue
        words = re.findall(r"[A-Z]+", kind.group(1).split(":")[0] if "[" not in kind.group(1) else kind.group(1))
        if words[0] in ("Excludes", "REQUIRED") or rest.strip()[:1].islower():
            continue
        if re.match(r" *[A-Z][a-z]", rest):  # this is the help text: a flag
            continue
        found[name] = (words[0], len(words))
    return found


def legal_values(tool, option):
    return LEGAL.get(f"{tool} {option}", LEGAL.get(option, ()))


class HostileParameters(ToolTest):
    def setUp(self):
        super().setUp()
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 8, 8, 8, "--frames", "1")
        self.outputs("vdblic_noise", "--like", "v.0001.vdb", "-o", "n.vdb")
        numpy.savez(self.folder / "v.npz", velocity=numpy.ones((2, 2, 2, 3)), voxel_size=1)

    def command(self, tool, option, values):
        """The tool's command with an option of these values."""
        words = list(COMMANDS[tool])
        short = {"--output": "-o"}.get(option, option)
        if short in words:
            begin = words.index(short)
            end = begin + 1
            while end < len(words) and not words[end].startswith("-"):
                end += 1
            del words[begin:end]
        if option == "--like" and "--size" in words:
            del words[words.index("--size"):][:4]
        return [tool, *words, *([f"{option}={values[0]}"] if len(values) == 1 else [option, *values])]

    def assert_refused(self, command):
        done = self.run_tool(*command, timeout=20)
        shown = [word[:60] for word in command]
        self.assertEqual(done.returncode, 2, f"{shown}: status {done.returncode} {done.stderr[:500]}")
        self.assertNotEqual(done.stderr.strip(), "", shown)
        self.assertLess(len(done.stderr), 2000 + 2 * sum(map(len, command)), shown)
        self.assertEqual(done.stdout, "", shown)

    def values(self, name, kind):
        if name == "--frames":
            return FRAMES
        return TEXTS[:1] if name in NAMES else TEXTS if kind in ("TEXT", "POSITION") else NUMBERS

    def test_every_option_of_every_tool(self):
        seen, step = 0, often(8, 1)
        of_pictures = options(self.run_tool("vdblic_render", "--help").stdout)
        for tool in COMMANDS:
            help_text = self.run_tool(tool, "--help").stdout
            for number, (name, (kind, count)) in enumerate(options(help_text).items()):
                if tool == "vdblic_view" and name in of_pictures:
                    continue  # the same code reads them
                values = self.values(name, kind)
                for value in values[number % min(step, len(values))::step]:
                    if value in legal_values(tool, name):
                        continue
                    with self.subTest(tool=tool, option=name, value=value[:30]):
                        self.assert_refused(self.command(tool, name, [value] * count))
                        if count > 1:
                            self.assert_refused(self.command(tool, name, ["1"] * (count - 1) + [value]))
                    seen += 1
            for positional in re.findall(r"^  ([A-Z]+) TEXT REQUIRED", help_text, re.MULTILINE):
                words = list(COMMANDS[tool])
                words[0] = ""
                with self.subTest(tool=tool, positional=positional):
                    self.assert_refused([tool, *words])
        self.assertGreater(seen, 300 // step)
        self.assertEqual([name for name in self.files() if name.startswith("out")], [])

    def test_what_is_legal_is_taken(self):
        for tool in COMMANDS.keys() - {"vdblic_view"}:  # it would go on; its options are those of vdblic_render
            for name, (_, count) in options(self.run_tool(tool, "--help").stdout).items():
                for value in legal_values(tool, name):
                    with self.subTest(tool=tool, option=name, value=value):
                        # The other values are 0, because both ends of a range must differ.
                        done = self.run_tool(*self.command(tool, name, ["0"] * (count - 1) + [value]), timeout=20)
                        if (name, value) not in (("--up", "0"), ("--light", "0"), ("--clip-plane", "0"),
                                                 ("--bbox", "-1"), ("--bbox-world", "-1"), ("--times", "-1"),
                                                 ("--bbox-world", "-1e308"), ("--bbox-world", "-inf")):
                            self.assertIn(done.returncode, (0, 1, 3), done.stderr)


if __name__ == "__main__":
    unittest.main()
