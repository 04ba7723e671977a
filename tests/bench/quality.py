"""Measured textures of the flows of docs/evidence.md, and its table "Defaults".

DATA holds wake/wake.%04d.vdb, era5_west_europe/era5.%04d.vdb and mantaflow_drift/fluid_data_%04d.vdb.
"""

import json
import pathlib
import subprocess
import tempfile

import numpy
import pyopenvdb as vdb

# Frames to compute and to measure. The last computed one is not measured: the velocity after it stands still.
# Slices are planes of the last measured frame: axis, and place along it from 0 to 1.
FLOWS = {
    "wake": dict(velocity="wake/wake.%04d.vdb", computed="1-8", measured="6-7", plane=(2, 0.3)),
    "winds": dict(velocity="era5_west_europe/era5.%04d.vdb", computed="1-8", measured="6-7", plane=(2, 0.5)),
    "smoke": dict(velocity="mantaflow_drift/fluid_data_%04d.vdb", computed="12-19", measured="17-18", plane=(1, 0.5)),
}
SETTINGS = "", "--life 8", "--sharpen 0.5", "--sharpen 2", "--noise-share 0.05", "--finish 3", "--substeps 4"


class Textures:
    """Makes textures of one flow in a folder and measures them."""

    def __init__(self, tools, data, flow, folder):
        self.tools, self.folder, self.flow = tools, pathlib.Path(folder), FLOWS[flow]
        self.velocity = data / self.flow["velocity"]

    def run(self, tool, *arguments):
        subprocess.run([self.tools / tool, *map(str, arguments), "-q"], check=True, stdout=subprocess.DEVNULL)

    def measure(self, *options):
        """Means over the frames of the figures of textures made with some options, bare unless --finish is given."""
        for old in self.folder.glob("lic.*"):
            old.unlink()
        figures = self.folder / "figures.json"
        self.run("vdblic_advect", self.velocity, "-o", self.folder / "lic.%04d.vdb", "--frames", self.flow["computed"],
                 *(options if "--finish" in options else ["--finish", 0, *options]))
        self.run("vdblic_coherence", self.velocity, self.folder / "lic.%04d.vdb", "--frames", self.flow["measured"],
                 "--json", figures)
        return json.loads(figures.read_text())["mean"]

    def plane(self):
        """A plane of the texture of the last measured frame, as bytes."""
        frame = int(self.flow["measured"].split("-")[1])
        grid = vdb.read(str(self.folder / "lic.%04d.vdb") % frame, "density")
        low, high = grid.evalActiveVoxelBoundingBox()
        texture = numpy.zeros([b - a + 1 for a, b in zip(low, high)], numpy.float32)
        grid.copyToArray(texture, ijk=low)
        axis, place = self.flow["plane"]
        plane = numpy.take(texture, int(place * texture.shape[axis]), axis).T[::-1]
        return (numpy.clip(plane, 0, 1) * 255).astype(numpy.uint8)


def print_defaults(tools, data):
    """The effect of single settings on the wake, at a displacement of 4 to 8 voxels."""
    print("| setting | isolated [%] | line | deviation | temporal | along |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        textures = Textures(tools, data, "wake", folder)
        for setting in SETTINGS:
            means = textures.measure(*setting.split())
            group = next(one for one in means["by_displacement"] if one["from"] == 4)
            isolated, line, deviation, temporal = (group[key]["mean"] for key in ("isolated", "line", "deviation", "temporal"))
            print(f"| {f'`{setting}`' if setting else 'defaults'} | {100 * isolated:.3f} | {line:.2f} | {deviation:.3f} | "
                  f"{temporal:.3f} | {means['raw']['along_length']['mean']:.1f} |", flush=True)
