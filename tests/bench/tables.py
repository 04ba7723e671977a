#!/usr/bin/python3
"""The tables of docs/evidence.md, measured anew, as Markdown.

    xvfb-run -a /usr/bin/python3 tests/bench/tables.py BUILD DATA [--only SECTION...] [--frames N]

BUILD is the build folder (build/release). DATA holds the flows of docs/evidence.md; quality.py says which. `--frames`
shortens a trial of the engine.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import file_to_file
import quality

HERE = pathlib.Path(__file__).resolve().parent
WAKE = HERE.parents[1] / "samples/wake/wake.0012.vdb"


def engine_report(build, frames):
    """The JSON report of vdblic_bench_engine, whose own tables go to standard error."""
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        report = pathlib.Path(folder) / "report.json"
        subprocess.run([build / "tests/vdblic_bench_engine", "--frames", str(frames), "--json", report], check=True,
                       stdout=sys.stderr)
        return json.loads(report.read_text(encoding="utf-8"))


def by_name(rows):
    return {row["name"]: row for row in rows}


def integrator_rates(report):
    """Million steps a second by integrator."""
    return {row["name"].split(",")[0]: row["million_steps_per_second"] for row in report["integrators"]}


def aims(report, frames):
    """The table "Aims and figures": rows of (what, aim, measured)."""
    rates = integrator_rates(report)
    ours = rates["advancePaths"]
    for name, against, aim in (
            ("VelocityIntegrator", "OpenVDB's `VelocityIntegrator` on one frame", "≥ 7 ×"),
            ("GridSampler and BoxSampler", "GridSampler and BoxSampler on two frames", ""),
            ("NanoVDB", "NanoVDB on two frames", ""),
            ("VTK's vtkStreamTracer", "VTK's `vtkStreamTracer` on one frame", "")):
        known = [rate for found, rate in rates.items() if name in found]
        if known:
            yield f"RK4 steps against {against}", aim, f"{ours / known[0]:.1f} × ({ours:.1f} against {known[0]:.1f} million a second)"
    methods, sweeps = by_name(report["methods"]), by_name(report["sweeps"])
    auflic = methods["AUFLIC, window 0.25, history"]
    for name, against, aim in (("UFLIC as in the paper, Euler", "the paper's Euler UFLIC", "≥ 9 ×"),
                               ("UFLIC", "our UFLIC", "≥ 2.5 ×"),
                               ("AUFLIC as in the paper, window 0.25", "AUFLIC in the paper's order of work", "")):
        ratio = methods[name]["ns_per_voxel"] / auflic["ns_per_voxel"]
        yield (f"AUFLIC against {against}", aim,
               f"{ratio:.1f} × ({auflic['ns_per_voxel']:.0f} against {methods[name]['ns_per_voxel']:.0f} ns a voxel and frame)")
    stages = ", ".join(f"{stage} {1e3 * seconds / frames:.0f}" for stage, seconds in auflic["seconds"].items())
    yield "a texture", "", f"{1e-6 * auflic['ns_per_voxel'] * 144 * 73 * 81:.0f} ms: {stages}"
    cost = lambda name, key="ns_per_voxel": sweeps[name][key]
    yield "time at life span 32 against 4", "≤ 1.15", f"{cost('life span 32') / cost('life span 4'):.2f}"
    yield "time per voxel, 384³ against 64³", "≤ 1.2", f"{cost('384 cubed') / cost('64 cubed'):.2f}"
    wall = "wall_ns_per_voxel"
    yield "two threads against one", "≥ 1.85 ×", f"{cost('1 threads', wall) / cost('2 threads', wall):.2f} ×"
    yield "peak memory of the process, 256³", "≤ 80 bytes a voxel", f"{report['memory'][-1]['bytes_per_voxel']:.0f}"
    yield ("a ball of 5 % of its box against a full one, time per voxel", "≤ 1.15",
           f"{cost('5 %') / cost('100 %'):.2f}")


def print_engine(report, frames):
    print("| | aim | measured |\n|---|---|---|")
    for row in aims(report, frames):
        print("| " + " | ".join(row) + " |")
    print("\n| | ns per voxel and frame | live | steps | deposits | hits | voxels without hits | temporal raw / smoothed "
          "| deviation |\n|---|---|---|---|---|---|---|---|---|")
    for row in report["methods"]:
        name = row["name"].replace("as in the paper, window 0.25", "in the paper's order, δ 0.25").replace("window", "δ")
        print(f"| {name} | {row['ns_per_voxel']:.0f} | {row['live_per_voxel']:.2f} | {row['steps_per_voxel']:.2f} | "
              f"{row['deposits_per_voxel']:.1f} | {row['hits_per_voxel']:.1f} | {100 * row['zero_hit_share']:.1f} % | "
              f"{row['temporal']:.3f} / {row['temporal_smoothed']:.3f} | {row['deviation']:.3f} |")


SECTIONS = ("engine", "files", "refinement", "methods", "defaults", "streaks", "pictures", "viewer", "machines")


def bench(script, *arguments):
    """Run a script of this folder, which prints tables."""
    subprocess.run([sys.executable, HERE / f"{script}.py", *map(str, arguments)], check=True)


def print_viewer(build):
    """The viewer on a refined wake."""
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        texture = f"{folder}/wake.0012.vdb"
        subprocess.run([build / "tools/vdblic_advect", WAKE, "-o", texture, "--refine", "4", "--with", "vorticity,q", "-q"], check=True, stdout=subprocess.DEVNULL)
        bench("viewer", build, texture)


def main():
    parser = argparse.ArgumentParser(description="Measure the tables of docs/evidence.md anew.")
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("--only", choices=SECTIONS, nargs="+", default=SECTIONS)
    parser.add_argument("--frames", type=int, default=6, help="frames of engine, at least 5")
    given = parser.parse_args()
    build, data, tools, report = given.build.resolve(), given.data.resolve(), given.build.resolve() / "tools", None
    for section in given.only:
        print(f"\n## {section.capitalize()}\n", flush=True)
        match section:
            case "engine":
                report = engine_report(build, given.frames)
                print_engine(report, given.frames)
            case "files":
                rates = integrator_rates(report) if report else {}
                rate = next((rates[name] for name in rates if "VelocityIntegrator" in name), None)
                file_to_file.print_table(build, data, rate)
            case "refinement":
                bench("refine", build, "--frames", 4)
            case "methods":
                bench("methods", tools, data)
            case "defaults":
                quality.print_tables(tools, data, quality.FLOWS)
            case "streaks":
                bench("streaks", build, data)
            case "pictures":
                bench("render_peers", tools)
            case "viewer":
                print_viewer(build)
            case "machines":
                bench("ranks", tools)


if __name__ == "__main__":
    main()
