#!/usr/bin/python3
"""The table "Dense methods" of docs/evidence.md and the slices of docs/methods.md: all dense methods on the same flows.

    /usr/bin/python3 tests/bench/methods.py TOOLS DATA [--slices FOLDER]

TOOLS is the folder of the built tools, DATA that of quality.py. Textures are as vdblic_advect writes them by default;
times are those of one thread. `--slices` writes a picture of each flow: the same part of the same slice of the refined
textures, method beside method.
"""

import argparse
import os
import pathlib
import subprocess
import tempfile

import numpy
import pyopenvdb as vdb

import quality

METHODS = {"uflic": "UFLIC", "auflic": "AUFLIC", "auflic-2004": "AUFLIC as published", "lic": "steady LIC",
           "ibfv": "IBFV", "lea": "LEA", "ufac": "UFAC"}
FINISHED = ("uflic", "auflic")
# Of a picture of slices: the side of a part, at most [voxels] and at least [pixels], the pixels for its title, the
# columns between parts [voxels], and the parts in a row.
SIDE, LEAST, TITLE, GAP, COLUMNS = 240, 256, 28, 4, 4
FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"


class Measured(quality.Textures):
    """Keeps the processor time of the last run of vdblic_advect [s], on one thread."""

    def run(self, tool, *arguments):
        if tool != "vdblic_advect":
            super().run(tool, *arguments)
            return
        before = os.times()
        super().run(tool, *arguments, "--threads", "1")
        after = os.times()
        self.seconds = after.children_user - before.children_user + after.children_system - before.children_system

    def voxel_steps(self):
        """The voxels of the last texture times the steps of the run."""
        paths = sorted(self.folder.glob("lic.*.vdb"))
        return (vdb.read(str(paths[-1]), "density").activeVoxelCount() *
                (len(paths) + vdb.readMetadata(str(paths[-1])).get("preroll", 0)))


def mean_of(means, key):
    """The mean of the classes of displacement by their points."""
    known = [(group["points"], group[key]["mean"]) for group in means["by_displacement"]
             if group.get(key) and group[key]["mean"] is not None]
    return sum(count * mean for count, mean in known) / sum(count for count, _ in known)


def part_of(plane):
    """The middle of a plane."""
    begins = [max(0, (size - SIDE) // 2) for size in plane.shape]
    return plane[begins[0]:begins[0] + SIDE, begins[1]:begins[1] + SIDE]


def write_parts(path, parts):
    """Write parts of slices, by their titles, side by side under these."""
    height, width = next(iter(parts.values())).shape
    scale = -(-LEAST // width)
    above = -(-TITLE // scale)
    down, across = height + above, width + GAP
    pixels = numpy.full((-(-len(parts) // COLUMNS) * down, min(len(parts), COLUMNS) * across - GAP), 255, numpy.uint8)
    titles = []
    for i, (title, part) in enumerate(parts.items()):
        y, x = i // COLUMNS * down, i % COLUMNS * across
        pixels[y + above:y + down, x:x + width] = part
        titles.append(f"drawtext=fontfile={FONT}:text='{title}':x={scale * x}:y={scale * y + 6}:fontsize=18")
    scaled = f"scale=iw*{scale}:ih*{scale}:flags=neighbor"
    subprocess.run(["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "gray", "-s",
                    f"{pixels.shape[1]}x{pixels.shape[0]}", "-i", "-", "-vf", ",".join([scaled, *titles]),
                    "-frames:v", "1", "-q:v", "3", path], input=pixels.tobytes(), check=True)


def main():
    parser = argparse.ArgumentParser(description="Measure the dense methods of docs/evidence.md anew.")
    parser.add_argument("tools", type=pathlib.Path)
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("--slices", type=pathlib.Path)
    given = parser.parse_args()
    print("| flow | method | isolated [%] | line | angle [°] | temporal | time [ns] |\n|---|---|---|---|---|---|---|")
    for flow in "winds", "smoke":
        with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
            textures, parts = Measured(given.tools.resolve(), given.data, flow, folder), {}
            for method, title in METHODS.items():
                means = textures.measure("--method", method, "--refine", 3, "--finish", 2 if method in FINISHED else 0)
                isolated, line, angle = (mean_of(means, key) for key in ("isolated", "line", "angle"))
                print(f"| {flow} | {title} | {100 * isolated:.3f} | {line:.2f} | {angle:.1f} | "
                      f"{means['raw']['temporal']['mean']:.3f} | {1e9 * textures.seconds / textures.voxel_steps():.0f} |",
                      flush=True)
                if given.slices:
                    parts[title] = part_of(textures.plane())
            if given.slices:
                given.slices.mkdir(parents=True, exist_ok=True)
                write_parts(given.slices / f"{flow}.jpg", parts)


if __name__ == "__main__":
    main()
