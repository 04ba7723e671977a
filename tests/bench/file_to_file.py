#!/usr/bin/env python3
"""What vdblic_advect costs from file to file: a table of docs/evidence.md.

    tests/bench/file_to_file.py BUILD [DATA] [--rate STEPS]

BUILD is the build folder (build/release). DATA holds wake/wake.%04d.vdb; without DATA the wake is samples/wake. Each row
is the median of three pairs of runs that take turns. STEPS are the million steps a second that vdblic_bench_engine
measures of OpenVDB's VelocityIntegrator on one frame; with them the first row has its ratio.
"""

import argparse
import math
import os
import pathlib
import statistics
import subprocess
import tempfile
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PAIRS = 3
PREROLL = 4  # steps before the first frame, by default the life span
PAPER = (144, 73, 81)
COARSE = (48, 24, 27)  # refined three times, about as many voxels
FRAMES = 13
DT = 1 / 24  # in which a flow of vdblic_synth moves by about 3 voxels


def advect(tools, velocity, folder, *options):
    """Make textures; returns processor time and elapsed time [s]."""
    command = [tools / "vdblic_advect", velocity, "-o", f"{folder}/t.%04d.vdb", "-q", *map(str, options)]
    begin = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    assert status == 0, command
    return usage.ru_utime + usage.ru_stime, time.monotonic() - begin


def pairs_of(first, second):
    """Costs of two runs in turn."""
    return [(first(), second()) for _ in range(PAIRS)]


def median_ratio(pairs, which):
    """The median over the pairs of the first's cost in the second's. @param which 0 processor time, 1 elapsed time"""
    return statistics.median(first[which] / second[which] for first, second in pairs)


def synth(tools, folder, name, size, dt):
    pattern = f"{folder}/{name}.%04d.vdb"
    subprocess.run([tools / "vdblic_synth", "abc", "-o", pattern, "--size", *map(str, size), "--frames", f"1-{FRAMES}",
                    "--dt", str(dt), "-q"], check=True, stdout=subprocess.DEVNULL)
    return pattern


def rows(build, data, rate):
    """Rows of (what, aim, measured)."""
    tools = build / "tools"
    wake = f"{data}/wake/wake.%04d.vdb" if data else SOURCE / "samples/wake/wake.%04d.vdb"
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        paper = synth(tools, folder, "paper", PAPER, DT)
        coarse = synth(tools, folder, "coarse", COARSE, DT / 3)  # as fast, refined
        one, two = ("--threads", 1), ("--threads", 2)
        steps = FRAMES + PREROLL
        voxel_steps = math.prod(PAPER) * steps

        threads = pairs_of(lambda: advect(tools, paper, folder, *one), lambda: advect(tools, paper, folder, *two))
        seconds = statistics.median(first[0] for first, _ in threads)
        nanoseconds = 1e9 * seconds / voxel_steps
        in_steps = f"; {nanoseconds * rate / 1e3:.2f} steps of OpenVDB's `VelocityIntegrator`" if rate else ""
        yield ("processor time a voxel and step, the paper's grid", "≤ 0.7 steps of `VelocityIntegrator`",
               f"{nanoseconds:.0f} ns{in_steps}")
        yield "two threads against one, elapsed", "≥ 1.85 ×", f"{median_ratio(threads, 1):.2f} ×"

        refined = pairs_of(lambda: advect(tools, coarse, folder, *one, "--refine", 3),
                           lambda: advect(tools, paper, folder, *one))
        ratio = median_ratio(refined, 0) * math.prod(PAPER) / (27 * math.prod(COARSE))
        yield ("processor time a texture voxel, `--refine 3` against 1 × at the same displacement", "≤ 0.8",
               f"{ratio:.2f}")
        for name, velocity, options, aim in (("the paper's grid", paper, (), "≥ 2.5 ×"),
                                             ("the wake at `--refine 3`", wake, ("--refine", 3, "--frames", "1-3"), "≥ 5 ×")):
            methods = pairs_of(lambda: advect(tools, velocity, folder, *one, *options, "--method", "uflic"),
                               lambda: advect(tools, velocity, folder, *one, *options))
            yield f"processor time of UFLIC against AUFLIC, {name}", aim, f"{median_ratio(methods, 0):.2f} ×"


def print_table(build, data=None, rate=None):
    print("| from file to file | aim | measured |\n|---|---|---|")
    for row in rows(build, data, rate):
        print("| " + " | ".join(row) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description="Measure vdblic_advect from file to file.")
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("data", type=pathlib.Path, nargs="?")
    parser.add_argument("--rate", type=float, help="million steps a second of VelocityIntegrator")
    given = parser.parse_args()
    print_table(given.build.resolve(), given.data, given.rate)


if __name__ == "__main__":
    main()
