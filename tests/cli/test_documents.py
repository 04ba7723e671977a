"""README.md and docs/ agree with the tools and with the code.

Every command of ours in a document is run, on small data under the names that the documents use. Every option that a
document names is in a tool's --help, every name of the code is in the code, every link leads somewhere.
"""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import numpy
import pyopenvdb as vdb

import earth_flows
import flows
import netcdf_flows
from support import BIN, SOURCE, ToolTest

DOCUMENTS = [SOURCE / "README.md", *sorted((SOURCE / "docs").rglob("*.md"))]
OURS = sorted([path.stem for path in (SOURCE / "tools").glob("vdblic_*.cpp")] +
              [f"vdblic_{path.stem.removesuffix('_tool')}" for path in (SOURCE / "tools/python").glob("*/*_tool.py")])

# The small data: frames of velocities and of textures, each under every name that documents use for such data.
VELOCITIES = ["v.%04d.vdb", "vel.%04d.vdb", "geo/vel.%04d.vdb", "samples/wake/wake.%04d.vdb",
              "cache/data/fluid_data_%04d.vdb"]
TEXTURES = ["lic.%04d.vdb", "reference.%04d.vdb", "wake.%04d.vdb", "tornado.%04d.vdb", "lic.vdb", "reference.vdb",
            "a.vdb", "b.vdb"]
FRAMES = range(1, 5)

PLACEHOLDERS = {"VELOCITY": "v.0001.vdb", "TEXTURE": "lic.0001.vdb", "IMAGE": "image.png", "A": "a.vdb", "B": "b.vdb",
                "OPTIONS": ""}
# The arguments of a command that a document mentions with options only.
REQUIRED = {"vdblic_advect": "v.0001.vdb -o out.vdb", "vdblic_render": "lic.0001.vdb -o out.png",
            "vdblic_view": "lic.0001.vdb"}


def shell_lines(document):
    """The lines of a document's fenced blocks of shell commands."""
    blocks = re.findall(r"^```sh\n(.*?)^```", document.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    return [line.strip() for block in blocks for line in block.splitlines() if line.strip()]


def inline_code(document):
    """The code between single backticks."""
    text = re.sub(r"^```.*?^```", "", document.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    return [code.replace(r"\|", "|").replace("\n", " ") for code in re.findall(r"`([^`]+)`", text)]


def commands(document):
    """The document's commands that begin with one of our tools."""
    lines = shell_lines(document) + inline_code(document)
    return [line for line in lines if line.split()[0] in OURS and len(line.split()) > 1]


def runnable(command):
    """The command on small data: sizes are 8, long ranges 1-4, placeholders files; a mention of options is completed."""
    command = re.sub(r"--size( \d+)+", lambda size: "--size" + " 8" * (len(size[0].split()) - 1), command)
    command = re.sub(r"--frames 1-\d+", "--frames 1-4", command)
    command = re.sub(r"^vdblic_film \S+", r"\g<0> --size 16 16", command)
    command = re.sub(r"(?<= )[A-Z]+(?= |$)", lambda word: PLACEHOLDERS[word[0]], command)
    tool, *words = command.split()
    command = f"{command} {REQUIRED[tool]}" if words[0].startswith("-") else command
    if tool == "vdblic_view":  # runs until it is ended
        command = re.sub(r"--port \d+", "--port 0", command)
        # Until it says its address.
        return f"coproc {{ exec {command}; }}; read -ru $COPROC; kill $COPROC_PID; wait $COPROC_PID; test $? = 143"
    return command


def options_in(text):
    return set(re.findall(r"(?<![\w-])--[a-z][\w-]*", text))


class Documents(ToolTest):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="vdblic-")
        cls.addClassCleanup(folder.cleanup)
        cls.data = pathlib.Path(folder.name)
        run = lambda *command: subprocess.run(command, cwd=cls.data, check=True, capture_output=True)
        run(BIN / "vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", "8", "8", "8", "--frames", "1-4")
        run(BIN / "vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb")
        run(BIN / "vdblic_advect", "v.%04d.vdb", "-o", "streaks.%04d.vdb", "--method", "streaks", "--draw", "lines")
        # Flows of other programs, under the names that the documents import.
        flows.write_pvd(cls.data, [0, 1])
        flows.write_foam(cls.data / "cavity", [0, 1])
        netcdf_flows.write_heights(cls.data / "winds.nc")
        netcdf_flows.write_c_grid(cls.data, [0, 1])
        earth_flows.write(cls.data / "sea.nc", earth_flows.sea())
        earth_flows.write(cls.data / "air.nc", earth_flows.wind(numpy.arange(0.0, 360, 15), numpy.arange(-90.0, 91, 15)))
        mesh = earth_flows.fvcom()[0]
        earth_flows.write(cls.data / "history.nc", {name: mesh.pop(name) for name in ("u", "v", "zeta", "time")})
        earth_flows.write(cls.data / "mesh.nc", mesh)

    def copy_of_the_data(self, folder):
        for patterns, made in (VELOCITIES, "v.%04d.vdb"), (TEXTURES, "lic.%04d.vdb"), (["streaks.%04d.vdb"], "streaks.%04d.vdb"):
            for pattern in patterns:
                (folder / pattern).parent.mkdir(parents=True, exist_ok=True)
                for frame in FRAMES if "%" in pattern else [None]:
                    os.link(str(self.data / made) % (frame or 1), str(folder / pattern) % frame if frame else folder / pattern)

        for name in "flow.pvd", "part0.vtu", "part1.vtu", "winds.nc", "U.nc", "V.nc", "W.nc", "cavity", "sea.nc", "air.nc", "history.nc", "mesh.nc":
            (folder / name).symlink_to(self.data / name)
        for frame in FRAMES:
            (folder / f"run.{frame:04}.vtu").symlink_to(self.data / "part0.vtu")

    def test_commands_run(self):
        environment = os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"}
        for document in DOCUMENTS:
            with tempfile.TemporaryDirectory(dir=self.folder) as folder:
                self.copy_of_the_data(pathlib.Path(folder))
                for command in commands(document):
                    with self.subTest(document=document.name, command=command):
                        done = subprocess.run(["bash", "-o", "pipefail", "-c", runnable(command)], cwd=folder,
                                              env=environment, text=True, capture_output=True, timeout=600)
                        self.assertEqual(done.returncode, 0, done.stderr)

    def test_the_tutorial_shows_what_its_commands_make(self):
        """The film and the viewer's page take longer; other tests look at those."""
        (self.folder / "samples").symlink_to(SOURCE / "samples")
        made = [command for command in shell_lines(SOURCE / "docs/tutorial.md")
                if re.match("vdblic_(advect|render) ", command) and "smooth" not in command]
        subprocess.run(["bash", "-ec", "\n".join(made)], cwd=self.folder, check=True, capture_output=True,
                       env=os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"})
        pictures = sorted(self.folder.glob("*.png"))
        self.assertEqual([picture.stem for picture in pictures], ["cut", "fine", "still", "vortex"])
        for picture in pictures:
            shown, now = (numpy.frombuffer(subprocess.run(
                ["ffmpeg", "-v", "error", "-i", path, "-vf", "scale=80:50:flags=area", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
                capture_output=True, check=True).stdout, numpy.uint8) / 255
                for path in (SOURCE / f"docs/images/tutorial/{picture.stem}.jpg", picture))
            self.assertLess(abs(shown - now).mean(), 0.02, picture.stem)

    def test_every_document_is_read(self):
        """Commands stand in fenced blocks that say `sh`, where test_commands_run finds them."""
        self.assertGreater(sum(len(commands(document)) for document in DOCUMENTS), 12)
        for document in DOCUMENTS:
            found = set(shell_lines(document))
            for line in document.read_text(encoding="utf-8").splitlines():
                if line.strip().split(" ")[0] in OURS:
                    self.assertIn(line.strip(), found, document.name)

    def test_options_exist(self):
        """An option belongs to the program that the code begins with, else to any of our tools."""
        ours = {"--help"}.union(*(options_in(self.run_tool(tool, "--help").stdout) for tool in OURS))
        seen = 0
        for document in DOCUMENTS:
            for code in inline_code(document) + shell_lines(document):
                code = re.sub(r"(^|\s)#( |SBATCH).*", "", code)
                code = re.sub(r"^([A-Z_a-z]+=\w+ )*(mpirun|srun) .*?(?=vdblic_|$)", "", code)  # their own options
                if not code or code.split()[0] in ("blender", "cmake", "ctest", "c++", "pip"):
                    continue
                program = SOURCE / code.split()[0]
                known = options_in(program.read_text(encoding="utf-8")) if program.is_file() else ours
                with self.subTest(document=document.name, code=code):
                    self.assertEqual(options_in(code) - known, set())
                seen += len(options_in(code))
        self.assertGreater(seen, 100)

    def test_names_of_the_code_exist(self):
        sources = [path for folder in ("lib", "tools") for path in (SOURCE / folder).rglob("*") if path.suffix in (".h", ".cpp")]
        words = set(re.findall(r"\w+", " ".join(path.read_text(encoding="utf-8") for path in sources)))
        paths = {str(path.relative_to(SOURCE)) for path in sources}
        for document in SOURCE / "docs/algorithm.md", SOURCE / "docs/architecture.md":
            for code in inline_code(document):
                with self.subTest(document=document.name, code=code):
                    names = {name for name in re.findall(r"[A-Za-z]\w*", code) if re.search(r"[a-z][A-Z]", name)}
                    self.assertEqual(names - words, set())
                    if code.endswith(".h"):
                        self.assertTrue(any(path.endswith(f"/{code}") for path in paths))

    def test_links_lead_somewhere(self):
        for document in DOCUMENTS:
            text = document.read_text(encoding="utf-8")
            for target in re.findall(r"\]\(([^)]+)\)", text):
                with self.subTest(document=document.name, target=target):
                    name, _, anchor = target.partition("#")
                    path = document.parent / name if name else document
                    self.assertTrue(path.exists())
                    if anchor:
                        headings = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE)
                        self.assertIn(anchor, [re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")
                                               for heading in headings])

    def test_formats_names_all_metadata_of_a_texture(self):
        documented = set(inline_code(SOURCE / "docs/formats.md"))
        for method in "auflic", "uflic", "lic":
            path, = self.outputs("vdblic_advect", self.data / "v.0001.vdb", "-o", "out.vdb", "--method", method)
            names = {name for name in vdb.readMetadata(str(path)) if not name.startswith("file_")}
            self.assertGreater(len(names), 8)
            self.assertEqual(names - documented, set())


if __name__ == "__main__":
    unittest.main()
