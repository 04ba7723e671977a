#!/usr/bin/python3
"""Time, memory and traffic of vdblic_advect_mpi.

    tests/bench/ranks.py TOOLS [SIZE]

TOOLS is the folder of the built tools, SIZE the voxels of a cube of the ABC flow (256). One process with two threads and
two ranks with one thread each take turns; the table has medians of three. Then the memory of a rank, and the bytes that
the ranks exchange beside those that their halos have.
"""

import argparse
import math
import os
import pathlib
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time

ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
LEAF = 8
OPTIONS = ["--frames", "1-2", "--preroll", "2", "--checkpoint-every", "0"]  # 4 steps


def boxes(low, high, ranks):
    """The boxes of lib/vdblic/distributed/partition.cpp for a full box of leaves."""
    if ranks == 1:
        return [(low, high)]
    extent = [b - a for a, b in zip(low, high)]
    axis = extent.index(max(extent))
    first = ranks // 2
    cut = low[axis] + min(range(1, max(extent[axis], 2)), key=lambda plane: abs(plane * ranks - extent[axis] * first))
    middle = [high[i] if i != axis else cut for i in range(3)], [low[i] if i != axis else cut for i in range(3)]
    return boxes(low, middle[0], first) + boxes(middle[1], high, ranks - first)


def volume(low, high):
    return math.prod(max(b - a, 0) for a, b in zip(low, high)) * LEAF**3


def shell(size, ranks, depth):
    """Voxels in all halos of some leaves, for a cube."""
    leaves = size // LEAF
    total = 0
    for low, high in boxes((0, 0, 0), (leaves,) * 3, ranks):
        around = [max(a - depth, 0) for a in low], [min(b + depth, leaves) for b in high]
        total += volume(*around) - volume(low, high)
    return total


def traffic(size, ranks, depth, steps, particles):
    """Bytes of all swaps of a run: hits and textures in every step, velocities of three frames, particles.

    Paths reach one leaf of the halo; leaves without hits are not sent.
    """
    a_step = shell(size, ranks, 1) * (8 + 4) + shell(size, ranks, depth) * 4
    faces = shell(size, ranks, 1) / LEAF / 2  # voxels of the cuts
    return steps * (a_step + faces * particles * 40) + 3 * shell(size, ranks, depth + 1) * 12


def run(command, folder, environment=None):
    begin = time.monotonic()
    done = subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True, text=True)
    return time.monotonic() - begin, done.stderr


def ranks_command(tools, ranks, *words):
    return ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), str(tools / "vdblic_advect_mpi"),
            "--threads", "1", *words]


def memory_of(tools, folder, ranks, words):
    """The peak of each rank [bytes]."""
    measure = f"/usr/bin/time -f %M -o memory.$OMPI_COMM_WORLD_RANK {tools}/vdblic_advect_mpi --threads 1 {' '.join(words)}"
    run(["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), "sh", "-c", measure], folder, ENVIRONMENT)
    return [1024 * int((folder / f"memory.{rank}").read_text()) for rank in range(ranks)]


def measure(tools, size):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run([tools / "vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *[str(size)] * 3, "--frames", "1-3"], folder)
        words = ["v.%04d.vdb", "-o", "t.%04d.vdb", *OPTIONS, "-v"]
        alone = [str(tools / "vdblic_advect"), "--threads", "2", *words]
        one, two = [], []
        for _ in range(3):
            one.append(run(alone, folder)[0])
            seconds, said = run(ranks_command(tools, 2, *words), folder, ENVIRONMENT)
            two.append(seconds)
        print(f"{size}³, 4 steps: one process, two threads {statistics.median(one):.1f} s; two ranks of one thread "
              f"{statistics.median(two):.1f} s; ratio {statistics.median(b / a for a, b in zip(one, two)):.2f}")
        run([str(tools / "vdblic_advect"), "--threads", "1", *words], folder)
        base = 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
        base = min(base, memory_of(tools, folder, 1, words)[0])
        print(f"one process: {base / 1e6:.0f} MB, {base / size**3:.0f} bytes a voxel")
        print("| ranks | memory of a rank, largest [MB] | of one process's | exchanged [MB] | halos have [MB] | ratio |")
        print("|---|---|---|---|---|---|")
        for ranks in 2, 3, 4, 7:
            memory = max(memory_of(tools, folder, ranks, words))
            _, said = run(ranks_command(tools, ranks, *words), folder, ENVIRONMENT)
            sent = float(re.search(r"exchanged ([\d.]+) MB", said)[1])
            expected = traffic(size, ranks, 2, 4, 0.8 * 1.5 / 2) / 1e6
            print(f"| {ranks} | {memory / 1e6:.0f} | {memory / base:.2f} | {sent:.0f} | {expected:.0f} "
                  f"| {sent / expected:.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tools", type=pathlib.Path)
    parser.add_argument("size", type=int, nargs="?", default=256)
    arguments = parser.parse_args()
    measure(arguments.tools.resolve(), arguments.size)
    return 0


if __name__ == "__main__":
    sys.exit(main())
