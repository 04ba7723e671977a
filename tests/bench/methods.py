#!/usr/bin/python3
"""The table "Dense methods" of docs/evidence.md and the slices of docs/methods.md: all dense methods on the same flows.

    /usr/bin/python3 tests/bench/methods.py TOOLS DATA [--flows FLOW...] [--methods METHOD...] [--slices FOLDER]

TOOLS and DATA are those of quality.py. Textures are as vdblic_advect writes them by default; times and memory are
those of one thread. Prints Markdown on standard output. `--slices` writes a picture of each flow: the same part of the
same slice of the refined textures, method beside method.
"""

import argparse
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
HEADER = ("| textures | method | isolated [%] | line | angle [°] | deviation | temporal | same place | along [voxels] | "
          "across [voxels] | time [ns] | memory [MB] |\n|---|---|---|---|---|---|---|---|---|---|---|---|")
OF_CLASSES = {key for key, _, _ in quality.CLASS_COLUMNS[:3]}  # that only classes of displacement have


class Measured(quality.Textures):
    """Keeps the processor time [s] and the peak memory [kB] of the last run of vdblic_advect."""

    def run(self, tool, *arguments):
        if tool != "vdblic_advect":
            super().run(tool, *arguments)
            return
        figures = self.folder / "figures.txt"  # of a process without the memory of this one
        subprocess.run(["/usr/bin/time", "-f", "%U %S %M", "-o", figures, self.tools / tool, *map(str, arguments),
                        "--threads", "1", "-q"], check=True, stdout=subprocess.DEVNULL)
        user, system, self.memory = map(float, figures.read_text(encoding="utf-8").split())
        self.seconds = user + system

    def voxel_steps(self):
        """The voxels of the last texture times the steps of the run."""
        paths = sorted(self.folder.glob("lic.*.vdb"))
        return (vdb.read(str(paths[-1]), "density").activeVoxelCount() *
                (len(paths) + vdb.readMetadata(str(paths[-1])).get("preroll", 0)))


def mean_of(means, key):
    """A figure of all voxels: of those that only classes have, the mean of the classes by their points."""
    if key not in OF_CLASSES:
        return means["raw"][key]["mean"]
    known = [(group["points"], group[key]["mean"]) for group in means["by_displacement"]
             if group.get(key) and group[key]["mean"] is not None]
    points = sum(count for count, _ in known)
    return sum(count * mean for count, mean in known) / points if points else None


def print_row(textures, refine, method):
    """Make and measure the textures of a method."""
    means = textures.measure("--method", method, "--refine", refine, "--finish", 2 if method in FINISHED else 0)
    figures = [(mean_of(means, key), factor, digits) for key, factor, digits in
               quality.CLASS_COLUMNS + quality.LENGTH_COLUMNS]
    cells = ["–" if mean is None else f"{factor * mean:.{digits}f}" for mean, factor, digits in figures]
    cells += [f"{1e9 * textures.seconds / textures.voxel_steps():.0f}", f"{textures.memory * 1024 / 1e6:.0f}"]
    print(f"| {refine} × | {METHODS[method]} | {' | '.join(cells)} |", flush=True)


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


def print_flow(tools, data, name, methods, slices):
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        flow = quality.FLOWS[name]
        velocity = data / flow.get("velocity", "")
        if name == "tornado":
            velocity = f"{folder}/v.%04d.vdb"
            subprocess.run([tools / "vdblic_synth", name, "-o", velocity, "--size", "48", "48", "48", "--frames",
                            flow["computed"], "-q"], check=True, stdout=subprocess.DEVNULL)
        textures, parts = Measured(tools, folder, flow, velocity), {}
        print(f"\n{flow['title']}:\n\n{HEADER}", flush=True)
        for refine in 1, quality.FINE:
            for method in methods:
                print_row(textures, refine, method)
                if slices and refine == quality.FINE:
                    parts[METHODS[method]] = part_of(textures.plane())
        if slices:
            slices.mkdir(parents=True, exist_ok=True)
            write_parts(slices / f"{flow['title'].lower()}.jpg", parts)


def main():
    parser = argparse.ArgumentParser(description="Measure the dense methods of docs/evidence.md anew.")
    parser.add_argument("tools", type=pathlib.Path)
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("--flows", nargs="+", choices=quality.FLOWS, default=list(quality.FLOWS))
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS))
    parser.add_argument("--slices", type=pathlib.Path)
    given = parser.parse_args()
    for name in given.flows:
        print_flow(given.tools.resolve(), given.data, name, given.methods, given.slices)


if __name__ == "__main__":
    main()
