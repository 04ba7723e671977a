"""Command lines of our tools from the user's settings, and their estimates."""

import dataclasses
import json
import pathlib
import tempfile

from .tools import run_tool

DENSE, STREAKS = "DENSE", "STREAKS"


@dataclasses.dataclass
class Recipe:
    """A flow texture to make. `spacing` 0 and `refine` 0 leave the choice to the tools."""

    velocity: str  # pattern
    folder: str  # of the textures
    method: str = STREAKS
    spacing: float = 0
    refine: int = 0
    frames: str = ""
    mask: str = ""  # FILE or FILE:GRID
    box: tuple = ()  # low and high corner in the velocity's world, in place of a mask
    derived: tuple = ()
    about_velocity: tuple = ()  # options that the files do not tell: rate, time scale
    further: tuple = ()
    lines: bool = False  # streaks as curves

    @property
    def output(self):
        name = "lic" if self.method != STREAKS else "lines" if self.lines else "streaks"
        return str(pathlib.Path(self.folder) / f"{name}.%04d.vdb")

    @property
    def layer(self):
        """The layer of USD of the lines; nothing where there are none."""
        return str(pathlib.Path(self.folder) / "lines.usda") if self.lines and self.method == STREAKS else ""

    def export(self):
        """The words after vdblic_export, which make the layer."""
        return [self.output, "-o", self.layer, *(["--frames", self.frames, "--clamp-frames"] if self.frames else [])]

    def command(self):
        """The words after vdblic_advect. They go on where an earlier run ended."""
        words = [self.velocity, "-o", self.output, "--resume"]
        if self.method == STREAKS:
            words += ["--method", "streaks", *(["--draw", "lines"] if self.layer else [])]
            words += ["--spacing", f"{self.spacing:g}"] if self.spacing else []
        words += ["--refine", str(self.refine)] if self.refine else []
        if self.method == DENSE and self.refine > 1:
            words += ["--scalars", "texture"]  # Blender draws scalars of other voxels beside the texture
        words += ["--frames", self.frames, "--clamp-frames"] if self.frames else []
        words += ["--mask", self.mask] if self.mask else []
        words += ["--bbox-world", *(f"{x:.9g}" for x in self.box)] if self.box and not self.mask else []
        derived = dict.fromkeys((*self.derived, *(("q",) if self.layer else ())))
        words += ["--with", ",".join(derived)] if derived else []
        return [*words, *self.about_velocity, *self.further]


@dataclasses.dataclass
class Estimate:
    """The estimate of vdblic_info: memory [bytes] and processor time [s] of all frames, and its choice for streaks."""

    frames: int
    voxels: int  # of the texture; for streaks of the velocity
    memory: float
    seconds: float
    spacing: float = 0
    refine: int = 1

    def __str__(self):
        size = f"{self.memory / 2**30:.1f} GiB" if self.memory >= 2**30 else f"{self.memory / 2**20:.0f} MiB"
        time = f"{self.seconds / 60:.0f} min" if self.seconds >= 120 else f"{self.seconds:.1f} s"
        streaks = float(f"{self.voxels / self.spacing**3:.1g}") if self.spacing else 0
        content = f"about {streaks:,.0f} streaks" if streaks else f"{self.voxels / 1e6:.2g} million voxels"
        return f"{self.frames} frames, {content}: {size} of memory, {time} of processor time"


def estimate(recipe, tools=""):
    """Ask vdblic_info about a recipe. Raises ToolError."""
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        report = pathlib.Path(folder) / "info.json"
        words = ["--frames", recipe.frames] if recipe.frames else []
        words += ["--refine", str(recipe.refine)] if recipe.refine else []
        words += ["--spacing", f"{recipe.spacing:g}"] if recipe.spacing and recipe.method == STREAKS else []
        run_tool("vdblic_info", [recipe.velocity, "--json", str(report), *words, *recipe.about_velocity], tools)
        (sequence,) = json.loads(report.read_text())["sequences"]
    return estimate_of(recipe, sequence)


def estimate_of(recipe, sequence):
    """The estimate of a recipe from the report on its velocity."""
    velocity = sequence["velocity"]
    voxels = max((grid["most_voxels"] for grid in sequence["grids"] if grid["name"] == velocity["grid"]), default=0)
    frames = len(sequence["frames"])
    streaks = velocity.get("streaks")
    if recipe.method == STREAKS and streaks:
        return Estimate(
            frames,
            voxels,
            streaks["memory"],
            streaks["processor_seconds"],
            max(streaks["spacing"]),
            max(streaks["refine"]),
        )
    refine = max(recipe.refine, 1)
    return Estimate(frames, voxels * refine**3, velocity["memory"], velocity["processor_seconds"], 0, refine)
