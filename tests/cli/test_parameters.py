"""Each parameter is described once, and everything that names parameters follows the description."""

import json
import os
import re
import sys
import unittest

from support import BIN, SOURCE, ToolTest

TOOLS = "synth", "noise", "advect", "render", "info", "coherence", "film", "diff", "view"
# Arguments that are no member of a parameter struct.
OWN = {"--help", "--version", "--threads", "--max-memory", "--scratch", "--quiet", "--verbose", "--verify",
       "--parameters", "--list", "--json", "--port", "--host", "--open"}


class Parameters(ToolTest):
    def listed(self, tool):
        done = self.run_tool(f"vdblic_{tool}", "--parameters")
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_help_and_list_agree(self):
        for tool in TOOLS:
            with self.subTest(tool=tool):
                listed = self.listed(tool)
                help_text = self.run_tool(f"vdblic_{tool}", "--help").stdout
                shown = set(re.findall(r"^  (?:-\w,)?(--[\w-]+)", help_text, re.MULTILINE))
                options = {p["option"].split(",")[-1] for p in listed if p["option"].startswith("-")}
                self.assertEqual(shown - OWN, options - OWN)
                words = " ".join(help_text.split())
                for parameter in listed:
                    self.assertIn(parameter["text"].rstrip("."), words, parameter["key"])
                self.assertEqual(len({p["key"] for p in listed}), len(listed))
                for parameter in listed:
                    if parameter.get("expert"):
                        self.assertGreater(help_text.index(f"  {parameter['option']} "), help_text.index("\nExpert:"))

    def test_a_description_stands_once(self):
        """No sentence of the help stands anywhere else in the sources; the converters parse options of their own."""
        code = [path.read_text() for folder in ("lib", "tools") for path in (SOURCE / folder).rglob("*")
                if path.suffix in (".cpp", ".h", ".py") and not {"page", "vdblic_convert"} & set(path.parts)]
        joined = "".join(re.sub(r'"\s*\n\s*"', "", text) for text in code)
        for tool in "advect", "render":
            for parameter in self.listed(tool):
                parts = [parameter["text"]]
                if parameter["key"] == "method":  # each is described in its folder
                    parts = [part.split(": ", 1)[1] for part in parts[0].rstrip(".").split("; ")]
                for part in parts:
                    text = json.dumps(part, ensure_ascii=False)[1:-1]
                    self.assertEqual(joined.count(f'"{text}"'), 1, text)

    def test_python_has_them(self):
        module = BIN.parent / "python"
        if os.environ.get("VDBLIC_SANITIZED") == "1" or not list(module.glob("vdblic/_core*.so")):
            self.skipTest("the module is not there")
        sys.path.insert(0, str(module))
        import vdblic  # pylint: disable=import-outside-toplevel

        def keywords(tool):
            """The names of the tool's options, as Python spells them."""
            listed = self.listed(tool)
            options = [p["option"].rpartition("--")[2].replace("-", "_") for p in listed if p["option"].startswith("-")]
            return {{"with": "with_"}.get(option, option) for option in options}

        files = {"output", "json", "resume", "restart", "keep_checkpoint", "checkpoint_every", "compression", "renumber"}
        self.assertEqual(set(vdblic.flow.PARAMETERS), keywords("advect") - files)
        self.assertEqual(set(vdblic.films.OPTIONS), keywords("film") - {"output"})
        self.assertEqual(set(vdblic.measures.DIFF_OPTIONS), keywords("diff") - {"output", "skip_existing", "json"})
        self.assertEqual(set(vdblic.measures.COHERENCE_OPTIONS), keywords("coherence") - {"output", "json"})
        outputs = {"substeps", "frames", "clamp_frames", "renumber", "output", "skip_existing", "keep_going", "aov", "precision",
                   "histogram", "transfer_out", "film", "fps"}
        self.assertEqual(set(vdblic.pictures.OPTIONS), keywords("render") - outputs)
        left_out, = re.findall(r"are left out:\s+([\w,\s]+)\.", vdblic.Renderer.__doc__)
        self.assertEqual(set(left_out.replace(",", " ").split()), outputs | {"input"})
        for function, names in (vdblic.advect, vdblic.flow.PARAMETERS), (vdblic.Renderer, vdblic.pictures.OPTIONS):
            for name in names:
                self.assertRegex(function.__doc__, rf"\n    {name} ")

    def test_defaults_are_taken(self):
        """The default that the list tells is a value that the option takes."""
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", 8, 8, 8, "--frames", "1-2")
        options = []
        for parameter in self.listed("advect"):
            if "default" in parameter and parameter["option"].startswith("--"):
                options += [parameter["option"], *parameter["default"].split()]
        self.assertGreater(len(options), 20)
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "all.%04d.vdb", *options)
        self.outputs("vdblic_advect", "v.%04d.vdb", "-o", "none.%04d.vdb")
        for frame in 1, 2:
            self.assertEqual((self.folder / f"all.{frame:04}.vdb").read_bytes(),
                             (self.folder / f"none.{frame:04}.vdb").read_bytes())


if __name__ == "__main__":
    unittest.main()
