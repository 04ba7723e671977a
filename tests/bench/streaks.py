#!/usr/bin/python3
"""Prints the tables "Streaks" of docs/evidence.md: what streaks cost, how steady they are, and how they show direction.

    tests/bench/streaks.py build/release DATA

DATA holds wake/wake.%04d.vdb and era5_west_europe/era5.%04d.vdb.
"""

import json
import os
import pathlib
import sys
import tempfile

import numpy
import pyopenvdb as vdb

from measure import run


def values_at(values, positions):
    """Trilinear interpolation of an array at positions in its index space."""
    last = numpy.array(values.shape[:3]) - 2
    base = numpy.clip(numpy.floor(positions).astype(int), 0, last)
    share = numpy.clip(positions - base, 0, 1)
    sums = 0
    for corner in range(8):
        step = numpy.array([corner >> 2, corner >> 1 & 1, corner & 1])
        weight = numpy.prod(numpy.where(step == 1, share, 1 - share), axis=1)
        value = values[tuple((base + step).T)]
        sums = sums + (weight[:, None] * value if value.ndim == 2 else weight * value)
    return sums


def array_of(grid, vector=False):
    """A grid's values in its box and a rim of two voxels, and the box's first index."""
    low, high = grid.evalActiveVoxelBoundingBox()
    first = tuple(x - 2 for x in low)
    shape = [b - a + 5 for a, b in zip(low, high)]
    values = numpy.zeros(shape + [3] if vector else shape, numpy.float32)
    grid.copyToArray(values, ijk=first)
    return values, numpy.array(first, float)


def rising(velocity_file, texture_file):
    """The share of visible voxels of moving streaks whose value rises downstream."""
    velocity = next(grid for grid in vdb.readAllGridMetadata(velocity_file) if grid.valueTypeName.startswith("vec3"))
    velocity = vdb.read(velocity_file, velocity.name)
    texture = vdb.read(texture_file, "density")
    vectors, from_ = array_of(velocity, vector=True)
    values, first = array_of(texture)
    voxels = numpy.argwhere(values[1:-1, 1:-1, 1:-1] > 0.15) + 1.0
    voxels = voxels[numpy.random.default_rng(1).permutation(len(voxels))[:100000]]
    step, coarse = numpy.array(texture.transform.voxelSize()), numpy.array(velocity.transform.voxelSize())
    origin = numpy.array(texture.transform.indexToWorld((0.0, 0.0, 0.0))) - velocity.transform.indexToWorld((0.0, 0.0, 0.0))
    direction = values_at(vectors, ((voxels + first) * step + origin) / coarse - from_) / step
    length = numpy.linalg.norm(direction, axis=1)
    moving = length > numpy.median(length) / 4
    unit = direction[moving] / length[moving, None]
    return (values_at(values, voxels[moving] + unit) > values_at(values, voxels[moving] - unit)).mean()


def main():
    tools = pathlib.Path(sys.argv[1]).resolve() / "tools"
    data = pathlib.Path(sys.argv[2]).resolve()
    wake, era = data / "wake/wake.%04d.vdb", data / "era5_west_europe/era5.%04d.vdb"
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        os.chdir(folder)

        def textures(velocity, frames, *options):
            """Figures of a run: its frames, memory and bytes of the last file, and its name."""
            _, memory = run(tools / "vdblic_advect", velocity, "-o", "s.%04d.vdb", "--method", "streaks", "--frames", frames,
                            "--json", "s.json", "--lead-in", 0, *options)
            report = json.loads(pathlib.Path("s.json").read_text(encoding="utf-8"))["frames"]
            last = f"s.{report[-1]['frame']:04}.vdb"
            return report, memory, os.path.getsize(last), last

        print("| streaks | drawn as | seconds a frame | memory [MB] | MB a frame on disk |\n|---|---|---|---|---|")
        run(tools / "vdblic_synth", "tornado", "-o", "t.%04d.vdb", "--size", 256, 256, 256, "--frames", "1-4")
        for name, velocity, *options in (("wake, `--spacing 2 --refine 8`", wake, "--spacing", 2, "--refine", 8),
                                         ("tornado of 256³, `--spacing 3`", "t.%04d.vdb", "--spacing", 3)):
            for form in "voxels", "lines":
                report, memory, size, _ = textures(velocity, "1-4", "--draw", form, *options)
                seconds = numpy.median([sum(f["seconds"][s] for s in ("load", "scatter", "convolve")) for f in report])
                print(f"| {name} | {form} | {seconds:.2f} | {memory / 1e6:.0f} | {size / 1e6:.1f} |")

        print("\n| from the sixth frame on | streaks, least to most | retired a frame, at most | rising |\n|---|---|---|---|")
        for name, velocity, frames, *options in (("wake", wake, "1-24", "--refine", 6),
                                                 ("winds", era, "1-20", "--spacing", 1.6, 1.6, 5, "--refine", 8, 8, 3)):
            report, _, _, last = textures(velocity, frames, *options)
            live = numpy.array([f["went_on"] for f in report[5:]])
            retired = numpy.array([f["blocked"] for f in report[5:]])
            share = rising(str(velocity) % report[-1]["frame"], last)
            print(f"| {name} | {live.min()} to {live.max()} | {(retired / live).max():.1%} | {share:.2f} |")

        print("\n| pictures of the wake, 1600 × 900, four rays a pixel | drawn as | seconds | memory [MB] |\n|---|---|---|---|")
        for form in "voxels", "lines":
            textures(wake, "12", "--spacing", 1.5, "--tail", 3, "--refine", 8, "--with", "q", "--draw", form)
            for name, *options in ("all of it",), ("`--opacity-by q`", "--opacity-by", "q"):
                costs = [run(tools / "vdblic_render", "s.0012.vdb", "-o", "p.png", "--size", 1600, 900, *options)
                         for _ in range(3)]
                seconds, memory = numpy.median(costs, axis=0)
                print(f"| {name} | {form} | {seconds:.1f} | {memory / 1e6:.0f} |")


if __name__ == "__main__":
    main()
