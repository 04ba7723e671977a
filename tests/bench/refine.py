"""Refined textures against textures of a velocity that was refined on disk: time, memory and coherence.

    tests/bench/refine.py BUILD [VELOCITY] [--frames N]

BUILD is a build folder, VELOCITY a pattern such as samples/wake/wake.%04d.vdb (the default). Each row is the median of
three runs, in turn. Time and memory are of the whole process, from reading to writing; the steps of the preroll count
as textures.
"""

import argparse
import multiprocessing
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy
import pyopenvdb as vdb

LIFE = 4  # the default of --life, and so of --preroll
SOURCE = pathlib.Path(__file__).resolve().parents[2]


def upsampled(source, target, factor):
    """Write a velocity interpolated linearly to factor^3 voxels in each of its own."""
    grid = vdb.read(source, "velocity")
    low, high = grid.evalActiveVoxelBoundingBox()
    shape = [high[i] - low[i] + 1 for i in range(3)]
    values = numpy.zeros([*shape, 3], numpy.float32)
    grid.copyToArray(values, ijk=low)
    mask = numpy.zeros(shape, numpy.float32)
    for item in grid.citerOnValues():
        first, last = (numpy.array(corner) - low for corner in (item.min, item.max))
        mask[tuple(slice(a, b + 1) for a, b in zip(first, last))] = 1
    fine = numpy.concatenate([values * mask[..., None], mask[..., None]], axis=3)
    for axis in range(3):
        at = numpy.clip((numpy.arange(shape[axis] * factor) + 0.5) / factor - 0.5, 0, shape[axis] - 1)
        base = numpy.minimum(at.astype(int), max(shape[axis] - 2, 0))
        fraction = (at - base).astype(numpy.float32).reshape([-1 if a == axis else 1 for a in range(4)])
        following = numpy.minimum(base + 1, shape[axis] - 1)
        fine = numpy.take(fine, base, axis) * (1 - fraction) + numpy.take(fine, following, axis) * fraction
    velocity = fine[..., :3] / numpy.maximum(fine[..., 3:], 1e-6)
    inside = mask.repeat(factor, 0).repeat(factor, 1).repeat(factor, 2) > 0
    result = vdb.Vec3SGrid()
    result.name = "velocity"
    first = [low[i] * factor for i in range(3)]
    result.copyFromArray(velocity * inside[..., None], ijk=first, tolerance=(-1, -1, -1))
    outside = numpy.argwhere(~inside)
    accessor = result.getAccessor()
    for voxel in outside:
        accessor.setValueOff(tuple(int(n) for n in voxel + first))
    size = grid.transform.voxelSize()
    transform = vdb.createLinearTransform(
        [[size[0] / factor, 0, 0, 0], [0, size[1] / factor, 0, 0], [0, 0, size[2] / factor, 0],
         [*(grid.transform.indexToWorld([(0.5 / factor - 0.5)] * 3)), 1]])
    result.transform = transform
    vdb.write(target, result, metadata=vdb.readMetadata(source))


# A child's peak includes the memory of the process that starts it, so a small one does.
RUN = """import os, sys, time
start = time.monotonic()
null = [(os.POSIX_SPAWN_OPEN, stream, os.devnull, os.O_WRONLY, 0) for stream in (1, 2)]
_, status, usage = os.wait4(os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ, file_actions=null), 0)
assert status == 0, sys.argv
print(time.monotonic() - start, usage.ru_maxrss * 1024)"""


def run(command):
    """Runs a command; returns its time [s] and its peak memory [bytes]."""
    small = subprocess.run([sys.executable, "-c", RUN, *map(str, command)], check=True, capture_output=True, text=True)
    seconds, memory = small.stdout.split()
    return float(seconds), int(memory)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("velocity", nargs="?", default=str(SOURCE / "samples" / "wake" / "wake.%04d.vdb"))
    parser.add_argument("--frames", type=int, default=6)
    arguments = parser.parse_args()
    tools = arguments.build / "tools"
    print("| N | texture voxels | s a texture, `--refine` | refined on disk | ratio | bytes a texture voxel | on disk |")
    print("|---|---|---|---|---|---|---|")
    for factor in 1, 2, 3, 4:
        with tempfile.TemporaryDirectory() as folder:
            fine = arguments.velocity
            if factor > 1:
                fine = f"{folder}/fine.%04d.vdb"
                for frame in range(1, arguments.frames + 1):
                    # In a process of its own: the memory of a child begins with that of its parent.
                    names = arguments.velocity % frame, fine % frame, factor
                    worker = multiprocessing.Process(target=upsampled, args=names)
                    worker.start()
                    worker.join()
            figures = {}
            for _ in range(3):
                for velocity, refine in ((arguments.velocity, factor), (fine, 1)):
                    seconds, memory = run([tools / "vdblic_advect", velocity, "-o", f"{folder}/t.%04d.vdb", "--refine",
                                           str(refine), "--frames", f"1-{arguments.frames}", "--finish", "0",
                                           "-q"])
                    figures.setdefault(velocity, []).append((seconds / (arguments.frames + LIFE), memory))
            voxels = vdb.read(f"{folder}/t.0001.vdb", "density").activeVoxelCount()
            mine, other = (tuple(statistics.median(column) for column in zip(*figures[velocity]))
                           for velocity in (arguments.velocity, fine))
            print(f"| {factor} | {voxels} | {mine[0]:.3f} | {other[0]:.3f} | {other[0] / mine[0]:.2f} | "
                  f"{mine[1] / voxels:.0f} | {other[1] / voxels:.0f} |", flush=True)


main()
