#!/usr/bin/python3
"""What the memory in a scratch file costs where it is not needed, for docs/evidence.md.

    tests/bench/scratch.py build/release

Instructions of vdblic_advect on four frames of 48³ voxels with one thread, as valgrind counts them: of the tool, of the tool
with --scratch, and of the same tool with the system's operator new. The build must be one by ninja.
"""

import pathlib
import re
import subprocess
import sys
import tempfile


def without_paging(build, output):
    """Link the tool without its operator new."""
    commands = subprocess.run(["ninja", "-C", build, "-t", "commands", "tools/vdblic_advect"], check=True, text=True,
                              capture_output=True).stdout
    link = commands.strip().splitlines()[-1].replace("-o tools/vdblic_advect", f"-o {output}")
    subprocess.run(re.sub(r"\S*vdblic_paged_new\S*\.o ", "", link), shell=True, check=True, cwd=build)


def instructions(folder, *command):
    """Counted twice: the threads that read and write make a small difference."""
    counts = []
    for _ in range(2):
        text = subprocess.run(["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null", *command],
                              check=True, text=True, capture_output=True, cwd=folder).stderr
        counts.append(int(re.search(r"I\s+refs:\s+([\d,]+)", text)[1].replace(",", "")))
    return min(counts)


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        subprocess.run([build / "tools/vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", "48", "48", "48", "--frames", "1-4"],
                       check=True, cwd=folder, capture_output=True)
        plain = pathlib.Path(folder) / "plain"
        without_paging(build, plain)
        job = "v.%04d.vdb", "-o", "lic.%04d.vdb", "--threads", "1"
        least = instructions(folder, plain, *job)
        print("| | million instructions | ratio |\n|---|---|---|")
        for name, tool, more in (("the system's `operator new`", plain, ()), ("the tool", build / "tools/vdblic_advect", ()),
                                 ("the tool with `--scratch`", build / "tools/vdblic_advect", ("--scratch", "."))):
            count = instructions(folder, tool, *job, *more)
            print(f"| {name} | {count / 1e6:,.1f} | {count / least:.4f} |", flush=True)


if __name__ == "__main__":
    main()
