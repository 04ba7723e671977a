#!/usr/bin/python3
"""The tables of docs/evidence.md, measured anew, as Markdown.

    xvfb-run -a /usr/bin/python3 tests/bench/tables.py BUILD DATA [--only SECTION...]

BUILD is the build folder (build/release). DATA holds the flows of docs/evidence.md; quality.py says which.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import quality
from measure import run

HERE = pathlib.Path(__file__).resolve().parent
SIDE = 256  # voxels, of the run whose memory is measured


def peak_memory(tools):
    """Bytes a voxel of a whole run of vdblic_advect."""
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        velocity = f"{folder}/velocity.%04d.vdb"
        run(tools / "vdblic_synth", "abc", "-o", velocity, "--size", SIDE, SIDE, SIDE, "--frames", "1-4")
        _, memory = run(tools / "vdblic_advect", velocity, "-o", f"{folder}/lic.%04d.vdb", "--threads", 2)
    return memory / SIDE**3


def print_engine(build):
    report = json.loads(subprocess.run([build / "tests/vdblic_bench_engine"], stdout=subprocess.PIPE, check=True).stdout)
    ours, openvdb = (report["steps"][name] for name in ("ours", "OpenVDB"))
    auflic, uflic, euler = (report["methods"][name] for name in ("AUFLIC", "UFLIC", "Euler UFLIC"))
    ratio = lambda name: report[name][1] / report[name][0]
    print("| the engine | aim | measured |\n|---|---|---|")
    for row in (
            ("RK4 steps against OpenVDB's `VelocityIntegrator` on one frame", "≥ 7 ×",
             f"{ours / openvdb:.1f} × ({ours:.1f} against {openvdb:.1f} million a second)"),
            ("AUFLIC against the paper's Euler UFLIC", "≥ 9 ×",
             f"{euler / auflic:.1f} × ({auflic:.0f} against {euler:.0f} ns a voxel and frame)"),
            ("AUFLIC against our UFLIC", "≥ 2.5 ×", f"{uflic / auflic:.1f} × ({uflic:.0f})"),
            ("time at life span 32 against 4", "≤ 1.15", f"{ratio('life'):.2f}"),
            ("time per voxel, 384³ against 64³", "≤ 1.2", f"{ratio('side'):.2f}"),
            ("two threads against one", "≥ 1.85 ×", f"{1 / ratio('threads'):.2f} ×"),
            (f"peak memory of the process, {SIDE}³, four frames, two threads", "≤ 80 bytes a voxel",
             f"{peak_memory(build / 'tools'):.0f}")):
        print("| " + " | ".join(row) + " |")


SECTIONS = ("engine", "refinement", "methods", "defaults", "streaks", "pictures", "machines")


def bench(script, *arguments):
    """Run a script of this folder, which prints tables."""
    subprocess.run([sys.executable, HERE / f"{script}.py", *map(str, arguments)], check=True)


def main():
    parser = argparse.ArgumentParser(description="Measure the tables of docs/evidence.md anew.")
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("--only", choices=SECTIONS, nargs="+", default=SECTIONS)
    given = parser.parse_args()
    build, data = given.build.resolve(), given.data.resolve()
    tools = build / "tools"
    for section in given.only:
        print(f"\n## {section.capitalize()}\n", flush=True)
        match section:
            case "engine":
                print_engine(build)
            case "refinement":
                bench("refine", tools)
            case "methods":
                bench("methods", tools, data)
            case "defaults":
                quality.print_defaults(tools, data)
            case "streaks":
                bench("streaks", build, data)
            case "pictures":
                bench("render_peers", tools)
            case "machines":
                bench("ranks", tools)


if __name__ == "__main__":
    main()
