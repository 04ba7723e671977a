#!/usr/bin/env python3
"""The tables of docs/quality.md: the effect of each setting of vdblic_advect on the coherence of its textures.

    tests/bench/quality.py TOOLS TITLE VELOCITY FRAMES      e.g. build/release/tools Wake 'wake.%04d.vdb' 1-16

TOOLS is the folder of the built tools. Prints Markdown on standard output; tables.py prints the tables of all flows.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

METHODS = [("LIC", 4, None), ("UFLIC", 4, None), ("UFLIC", 8, None)] + \
          [("AUFLIC", life, window) for life, window in ((4, 0.125), (4, 0.25), (4, 0.5), (4, 1), (8, 0.25), (16, 0.25))]
FILTERS = [("mix", share, sharpen) for sharpen in (0.5, 1, 2) for share in (0.05, 0.1, 0.2)] + \
          [("bits", None, sharpen) for sharpen in (0.5, 1, 2)]
REFINEMENTS = [1, 2, 3]
SUBSTEPS = [1, 4]
HEADER = "| {} | temporal | same place | along [voxels] | across [voxels] | deviation |\n|---|---|---|---|---|---|"


def measure(tools, velocity, frames, options):
    """Means over the frames of the figures of textures made with some options."""
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        textures, figures = f"{folder}/lic.%04d.vdb", pathlib.Path(folder) / "figures.json"
        run = lambda *command: subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        if "--finish" not in options:
            options = ["--finish", 0, *options]  # settings are compared by bare textures
        run(tools / "vdblic_advect", velocity, "-o", textures, "--frames", frames, "-q", *map(str, options))
        run(tools / "vdblic_coherence", velocity, textures, "--frames", frames, "--samples", "50000", "-q",
            "--json", str(figures))
        return json.loads(figures.read_text())["mean"]


def row(name, mean):
    pair = lambda key, digits: " / ".join(f"{mean[kind][key]['mean']:.{digits}f}" for kind in ("raw", "smoothed"))
    return (f"| {name} | {pair('temporal', 3)} | {pair('same_place', 3)} | {pair('along_length', 1)} | "
            f"{pair('across_length', 2)} | {mean['raw']['deviation']['mean']:.3f} |")


def print_tables(tools, title, velocity, frames):
    print(f"{title}, by method, life span L and release window δ:\n\n{HEADER.format('method')}")
    for method, life, window in METHODS:
        options = ["--method", method.lower(), "--life", life]
        name = f"{method}, L {life}"
        if window:
            options += ["--release-window", window]
            name += f", δ {window}"
        print(row(name, measure(tools, velocity, frames, options)), flush=True)
    print(f"\n{title}, by feedback filter:\n\n{HEADER.format('jitter')}")
    for jitter, share, sharpen in FILTERS:
        options = ["--jitter", jitter, "--sharpen", sharpen] + (["--noise-share", share] if share else [])
        name = jitter + (f", noise {share}" if share else "") + f", sharpen {sharpen}"
        print(row(name, measure(tools, velocity, frames, options)), flush=True)
    print(f"\n{title}, by texture voxels along each axis in a velocity voxel; lengths are in velocity voxels:\n\n{HEADER.format('refinement')}")
    for factor in REFINEMENTS:
        print(row(f"`--refine {factor}`", measure(tools, velocity, frames, ["--refine", factor])), flush=True)
    print(f"\n{title}, by the finish of the default settings:\n\n{HEADER.format('finish')}")
    for taps in 0, 1, 2, 3:
        print(row(f"`--finish {taps}`", measure(tools, velocity, frames, ["--finish", taps])), flush=True)
    print(f"\n{title}, by textures for each interval between frames, a frame apart:\n\n{HEADER.format('substeps')}")
    for substeps in SUBSTEPS:
        options = ["--refine", 2, "--substeps", substeps]
        print(row(f"`--refine 2 --substeps {substeps}`", measure(tools, velocity, frames, options)), flush=True)


if __name__ == "__main__":
    print_tables(pathlib.Path(sys.argv[1]), *sys.argv[2:])
