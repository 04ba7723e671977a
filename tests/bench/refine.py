#!/usr/bin/env python3
"""The table "Refinement" of docs/evidence.md: time and memory of refined textures.

    tests/bench/refine.py TOOLS

Each row is the median of three runs. Time and memory are of the whole process, from reading to writing; the steps of the
preroll count as textures.
"""

import pathlib
import statistics
import sys
import tempfile

import pyopenvdb as vdb

from measure import run

LIFE, FRAMES = 4, 4  # the default of --life, and so of --preroll
WAKE = pathlib.Path(__file__).resolve().parents[2] / "samples/wake/wake.%04d.vdb"


def main():
    tools = pathlib.Path(sys.argv[1]).resolve()
    print("| N | texture voxels | s a texture, `--refine` | bytes a texture voxel |\n|---|---|---|---|")
    for factor in 1, 2, 3, 4:
        with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
            command = [tools / "vdblic_advect", WAKE, "-o", f"{folder}/t.%04d.vdb", "--refine", factor, "--frames",
                       f"1-{FRAMES}", "--finish", 0]
            seconds, memory = map(statistics.median, zip(*(run(*command) for _ in range(3))))
            voxels = vdb.read(f"{folder}/t.0001.vdb", "density").activeVoxelCount()
        print(f"| {factor} | {voxels:,} | {seconds / (FRAMES + LIFE):.3f} | {memory / voxels:.0f} |", flush=True)


main()
