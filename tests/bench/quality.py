#!/usr/bin/env python3
"""The tables "Defaults" of docs/evidence.md, with more rows, and slices of the textures.

    /usr/bin/python3 tests/bench/quality.py TOOLS [DATA] [--flows FLOW...] [--slices FOLDER]

TOOLS is the folder of the built tools (build/release/tools). DATA holds wake/wake.%04d.vdb,
era5_west_europe/era5.%04d.vdb and mantaflow_drift/fluid_data_%04d.vdb; without DATA the flows are samples/wake and a
tornado. Prints Markdown on standard output. `--slices` writes a PNG image of each flow, textures of AUFLIC on the left
and of UFLIC on the right.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy
import pyopenvdb as vdb

WAKE = pathlib.Path(__file__).resolve().parents[2] / "samples/wake/wake.%04d.vdb"
FINE = 3  # of --refine
# Frames to compute and to measure. The last computed one is not measured: the velocity after it stands still.
# Slices are planes of the last measured frame: axis, and place along it from 0 to 1.
FLOWS = {
    "wake": dict(title="Wake", velocity="wake/wake.%04d.vdb", computed="1-8", measured="6-7", plane=(2, 0.3)),
    "era5": dict(title="Winds", velocity="era5_west_europe/era5.%04d.vdb", computed="1-8", measured="6-7",
                 plane=(2, 0.5)),
    "tornado": dict(title="Tornado", computed="1-8", measured="6-7", plane=(2, 0.5)),
    "mantaflow": dict(title="Smoke", velocity="mantaflow_drift/fluid_data_%04d.vdb", computed="12-19", measured="17-18",
                      plane=(1, 0.5)),
}
LEVERS = ["--method uflic", "--method lic", "--life 8", "--life 16", "--release-window 0.125", "--release-window 0.5",
          "--release-window 1", "--sharpen 0.5", "--sharpen 2", "--noise-share 0.05", "--noise-share 0.2",
          "--method auflic-2004", "--finish 1", "--finish 2", "--finish 3", "--substeps 4"]
HEADER = ("| {} | isolated [%] | line | angle [°] | deviation | temporal | same place | along [voxels] | "
          "across [voxels] |\n|---|{}---|---|---|---|---|---|---|---|")
CLASS_COLUMNS = [("isolated", 100, 3), ("line", 1, 2), ("angle", 1, 1), ("deviation", 1, 3), ("temporal", 1, 3),
                 ("same_place", 1, 3)]
LENGTH_COLUMNS = [("along_length", 1, 1), ("across_length", 1, 2)]


class Textures:
    """Makes textures of one flow in a folder and measures them."""

    def __init__(self, tools, folder, flow, velocity):
        self.tools, self.folder, self.flow, self.velocity = tools, pathlib.Path(folder), flow, velocity

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


def write_side_by_side(path, planes):
    """Write two planes with a white gap, by whole factors so large that they fill about 1,200 pixels."""
    gap = numpy.full((planes[0].shape[0], 4), 255, numpy.uint8)
    pixels = numpy.concatenate([planes[0], gap, planes[1]], axis=1)
    factor = max(1, round(1200 / pixels.shape[1]))
    pixels = pixels.repeat(factor, 0).repeat(factor, 1)
    subprocess.run(["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "gray", "-s",
                    f"{pixels.shape[1]}x{pixels.shape[0]}", "-i", "-", "-frames:v", "1", path],
                   input=pixels.tobytes(), check=True)


def cells(columns, *means):
    """The figures of some means as cells of a table row, a pair of means divided by a slash."""
    def number(estimate, factor, digits):
        return "–" if not estimate or estimate["mean"] is None else f"{factor * estimate['mean']:.{digits}f}"
    texts = [[number(mean.get(key), factor, digits) for mean in means] for key, factor, digits in columns]
    return " | ".join("–" if set(pair) == {"–"} else " / ".join(pair) for pair in texts)


def print_methods(textures, slices):
    """AUFLIC against UFLIC by class of displacement; returns the figures of bare unrefined AUFLIC."""
    print(f"\n{textures.flow['title']}, AUFLIC / UFLIC, by displacement in texture voxels a step:\n")
    print(HEADER.format("textures | displacement", "---|"))
    default, planes = None, []
    for refine in 1, FINE:
        for finish in 0, 2:
            pair = []
            for method in "auflic", "uflic":
                pair.append(textures.measure("--method", method, "--refine", refine, "--finish", finish))
                default = default or pair[0]
                if slices and (refine, finish) == (FINE, 2):
                    planes.append(textures.plane())
            name = f"{refine} ×, " + ("finished" if finish else "bare")
            rows = [("{from:g} to {to:g}".format_map(classes[0]), classes)
                    for classes in zip(*(means["by_displacement"] for means in pair)) if classes[0]["line"]["frames"]]
            for displacement, means in [*rows, ("all", [means["raw"] for means in pair])]:
                print(f"| {name} | {displacement} | {cells(CLASS_COLUMNS + LENGTH_COLUMNS, *means)} |", flush=True)
    if slices:
        slices.mkdir(parents=True, exist_ok=True)
        write_side_by_side(slices / f"{textures.flow['title'].lower()}.png", planes)
    return default


def print_levers(textures, default):
    """The effect of single settings, in the class of displacement that has most voxels."""
    which = max(range(4), key=lambda i: default["by_displacement"][i]["points"])
    limits = "{from:g} to {to:g}".format_map(default["by_displacement"][which])
    print(f"\n{textures.flow['title']}, by one setting each, 1 ×, bare; displacement {limits}, lengths of all:\n")
    print(HEADER.format("setting", ""))
    for lever in ["", *LEVERS]:
        means = textures.measure(*lever.split()) if lever else default
        print(f"| {f'`{lever}`' if lever else 'defaults'} | {cells(CLASS_COLUMNS, means['by_displacement'][which])} | "
              f"{cells(LENGTH_COLUMNS, means['raw'])} |", flush=True)


def flows_of(data):
    """The flows that can be measured with the given folder of data, or with none."""
    return list(FLOWS) if data else ["wake", "tornado"]


def print_tables(tools, data, names, slices=None):
    for name in names:
        with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
            velocity = data / FLOWS[name].get("velocity", "") if data else WAKE
            if name == "tornado":
                velocity = f"{folder}/v.%04d.vdb"
                subprocess.run([tools / "vdblic_synth", name, "-o", velocity, "--size", "48", "48", "48", "--frames",
                                FLOWS[name]["computed"], "-q"], check=True, stdout=subprocess.DEVNULL)
            textures = Textures(tools, folder, FLOWS[name], velocity)
            print_levers(textures, print_methods(textures, slices))


def main():
    parser = argparse.ArgumentParser(description="Measure the defaults of docs/evidence.md anew.")
    parser.add_argument("tools", type=pathlib.Path)
    parser.add_argument("data", type=pathlib.Path, nargs="?")
    parser.add_argument("--flows", nargs="+", choices=FLOWS)
    parser.add_argument("--slices", type=pathlib.Path)
    given = parser.parse_args()
    print_tables(given.tools.resolve(), given.data, given.flows or flows_of(given.data), given.slices)


if __name__ == "__main__":
    main()
