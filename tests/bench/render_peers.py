#!/usr/bin/env python3
"""The table "Pictures" of docs/evidence.md: times of a picture beside VTK's ray caster and vdb_render, on two threads, of
sparse volumes, in 1080p.

    xvfb-run -a /usr/bin/python3 tests/bench/render_peers.py TOOLS [SECTION...]      e.g. build/release/tools vtk
    /usr/bin/python3 tests/bench/render_peers.py TOOLS files --before OTHER

Sections: vtk, vdb_render, threads, sparse, video; all by default. `files` compares with the tools of another build, in the
folder OTHER, from file to file. Needs pyopenvdb; vtk also needs python3-vtk9 and
xvfb-run, vdb_render also needs vdb_render. A section whose peer is missing is named and left out. Peers get the same
volume, camera and step, 512² pixels, one thread. The compared programs run in turn. Times are medians: processor time with
one thread, elapsed time with two. Our time for a picture is that of one more ray for each pixel (--samples), without
reading and building bricks; VTK's excludes its gradients, vdb_render's excludes reading.
"""

import argparse
import functools
import importlib.util
import math
import os
import pathlib
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

import numpy
import pyopenvdb

SIZE, ROUNDS, STEP = 512, 5, 0.5


def cpu_time():
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


def whole_cpu_time():
    """With the system's share: new memory is its work."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Bench:
    def __init__(self, tools, folder):
        self.tools, self.folder = tools, folder

    def run(self, tool, *arguments, clock=cpu_time):
        """Seconds of a command."""
        path = self.tools / tool
        before = clock()
        subprocess.run([path if path.exists() else tool, *map(str, arguments)], cwd=self.folder, check=True,
                       stdout=subprocess.DEVNULL)
        return clock() - before

    def render(self, volume, *options, threads=1, clock=cpu_time):
        return self.run("vdblic_render", volume, "-o", "image.exr", "--threads", threads, "-q", *options, clock=clock)

    def picture(self, volume, *options, clock=cpu_time, **others):
        """Seconds for one ray to each pixel, without reading and building bricks."""
        time = lambda samples: self.render(volume, "--samples", samples, "--step", STEP, "--interpolation", "linear", *options,
                                           clock=clock, **others)
        return time(2) - time(1)  # all pixels have a second ray

    def texture(self):
        """The flow texture of an analytic flow, 144 x 73 x 81 voxels."""
        if not (self.folder / "lic.0004.vdb").exists():
            self.run("vdblic_synth", "tornado", "-o", "v.%04d.vdb", "--size", 144, 73, 81, "--frames", "1-5", "-q")
            self.run("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--frames", "1-4", "-q")
        return "lic.0004.vdb"

    def header(self):
        """The header of the last image: a function from an attribute's name to its numbers."""
        text = subprocess.run(["exrheader", self.folder / "image.exr"], capture_output=True, text=True, check=True).stdout
        return lambda name: [float(x) for x in re.findall(r"-?[\d.]+(?:e[+-]?\d+)?",
                                                          re.search(name + r" \(type \w+\): (.*)", text)[1])]


def compare(title, names, times, rounds=ROUNDS):
    """Time two functions in turn; print their median times and their median ratio as a row of a table."""
    rounds = [[one() for one in times] for _ in range(rounds)]
    figures = " | ".join(f"{name} {statistics.median(column):.3f} s" for name, column in zip(names, zip(*rounds)))
    ratio = statistics.median(second / first for first, second in rounds)
    print(f"| {title} | {figures} | {ratio:.2f} |", flush=True)


def dense(path, name):
    grid = pyopenvdb.read(str(path), name)
    low, high = grid.evalActiveVoxelBoundingBox()
    values = numpy.zeros([h - l + 1 for l, h in zip(low, high)], numpy.float32)
    grid.copyToArray(values, low)
    return values


def share(texture, header):
    """Fraction of the extinction that remains after modulation by the texture."""
    (dark, bright), (foot,) = header("textureRange"), header("textureFoot")
    rise = numpy.clip(((texture - dark) / (bright - dark) - foot) / (1 - foot), 0, 1)
    return rise * rise * (3 - 2 * rise)


def vtk_window(path, header):
    """VTK's picture. VTK gets opacities per voxel, because its functions of two components have no product."""
    from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
    from vtkmodules.vtkRenderingCore import (vtkColorTransferFunction, vtkRenderer, vtkRenderWindow, vtkVolume,
                                             vtkVolumeProperty)
    from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper
    from vtkmodules.util.numpy_support import numpy_to_vtk
    import vtkmodules.vtkRenderingOpenGL2
    import vtkmodules.vtkRenderingVolumeOpenGL2

    texture, magnitude = dense(path, "density"), dense(path, "magnitude")
    low, high = header("colorRange")
    points = numpy.array(header("opacity")).reshape(-1, 2).T
    extinction = -numpy.log1p(-numpy.interp((magnitude - low) / (high - low), *points))
    opacity = -numpy.expm1(-extinction * share(texture, header))
    image = vtkImageData()
    image.SetDimensions(*texture.shape)
    image.SetSpacing(0.1, 0.1, 0.1)
    flat = lambda values: values.transpose(2, 1, 0).ravel().astype(numpy.float32)
    image.GetPointData().SetScalars(numpy_to_vtk(numpy.stack([flat(magnitude), flat(opacity)], 1), deep=1))

    mapper = vtkFixedPointVolumeRayCastMapper()
    mapper.SetInputData(image)
    mapper.SetNumberOfThreads(1)
    mapper.AutoAdjustSampleDistancesOff()
    mapper.LockSampleDistanceToInputSpacingOff()
    color, alpha = vtkColorTransferFunction(), vtkPiecewiseFunction()
    color.AddRGBPoint(low, 0, 0.5, 1)
    color.AddRGBPoint(high, 1, 0.5, 0)
    alpha.AddPoint(0, 0)
    alpha.AddPoint(1, 1)
    properties = vtkVolumeProperty()
    properties.IndependentComponentsOff()
    properties.SetInterpolationTypeToLinear()
    properties.ShadeOn()
    properties.SetColor(color)
    properties.SetScalarOpacity(alpha)
    properties.SetScalarOpacityUnitDistance(0.1)
    volume, renderer, window = vtkVolume(), vtkRenderer(), vtkRenderWindow()
    volume.SetMapper(mapper)
    volume.SetProperty(properties)
    renderer.AddVolume(volume)
    window.SetOffScreenRendering(1)
    window.SetSize(SIZE, SIZE)
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(header("target"))
    camera.SetPosition(header("eye"))
    camera.SetViewUp(0, 0, 1)
    camera.SetViewAngle(35)
    renderer.ResetCameraClippingRange()
    return window, mapper


SQUARE = ["--size", SIZE, SIZE, "--halo", 0]


def bench_vtk(bench):
    volume = bench.texture()
    bench.render(volume, *SQUARE)
    window, mapper = vtk_window(bench.folder / volume, bench.header())
    distances = iter(0.05 + 1e-7 * i for i in range(100))  # a changed distance makes VTK render again

    def vtk():
        mapper.SetSampleDistance(next(distances))
        before = time.process_time()
        window.Render()
        return time.process_time() - before

    vtk()
    compare("Shaded", ["vdblic_render", "VTK"], [lambda: bench.picture(volume, *SQUARE), vtk])


def bench_vdb_render(bench):
    volume = bench.texture()
    bench.render(volume, *SQUARE)
    text = lambda name: ",".join(f"{x:.9g}" for x in bench.header()(name))
    camera = ["-translate", text("eye"), "-lookat", text("target"), "-up", "0,0,1", "-fov", 35, "-step", STEP]
    texture = dense(bench.folder / volume, "density")
    ratio = texture.mean() / share(texture, bench.header()).mean()  # so that the mean extinction is the same
    for title, scatter, absorb in ("Thin", 0.1, 0.01), ("vdb_render's default", 1.5, 0.1), ("Nearly opaque", 60, 0.01):
        opacity = f"0:{-math.expm1(-0.1 * (scatter + absorb) * ratio):.4f}"
        theirs = lambda size: bench.run("vdb_render", volume, "image.ppm", "-name", "density", "-cpus", 1, "-res",
                                        f"{size}x{size}", "-scatter", f"{scatter},{scatter},{scatter}", "-absorb",
                                        f"{absorb},{absorb},{absorb}", *camera)
        compare(title, ["vdblic_render", "vdb_render"],
                [lambda: bench.picture(volume, *SQUARE, "--opacity", opacity), lambda: theirs(SIZE) - theirs(2)], rounds=2)


def bench_threads(bench):
    volume = bench.texture()
    once = lambda threads: lambda: bench.picture(volume, *SQUARE, threads=threads, clock=time.perf_counter)
    compare("Threads", ["two", "one"], [once(2), once(1)])


def bench_sparse(bench):
    """512³ voxels with scattered active cubes of 16³, 5 % in all, beside as many active voxels in one cube."""
    random = numpy.random.default_rng(1)
    cubes = numpy.stack(numpy.unravel_index(random.choice(32 ** 3, 32 ** 3 // 20, replace=False), (32, 32, 32)), 1) * 16
    side = round((len(cubes) * 16 ** 3) ** (1 / 3))
    sparse, whole = pyopenvdb.BoolGrid(), pyopenvdb.BoolGrid()
    for cube in cubes.tolist():
        sparse.fill(cube, [c + 15 for c in cube], True)
    whole.fill((0, 0, 0), (side - 1, side - 1, side - 1), True)
    for name, grid in ("sparse", sparse), ("dense", whole):
        pyopenvdb.write(str(bench.folder / f"{name}_mask.vdb"), grids=[grid])
        bench.run("vdblic_noise", "--like", f"{name}_mask.vdb", "-o", f"{name}.vdb", "-q")
    options = ["--size", 256, 256, "--halo", 0, "--texture", "noise"]
    for title, opacity in ("Sparse, thin medium", "0:0.01"), ("Sparse, nearly opaque medium", "0:0.3"):
        one = lambda name: lambda: bench.picture(f"{name}.vdb", *options, "--opacity", opacity)
        compare(title, ["dense", "512³ with 5 % active"], [one("dense"), one("sparse")])
    one = lambda name: lambda: bench.render(f"{name}.vdb", *options)
    compare("Sparse, with reading and bricks", ["dense", "512³ with 5 % active"], [one("dense"), one("sparse")])


def bench_video(bench):
    """A picture of 1920 x 1080 pixels of 256³ voxels on two threads: casting alone, and from file to file."""
    bench.run("vdblic_synth", "abc", "-o", "big.%04d.vdb", "--size", 256, 256, 256, "--frames", "1-2", "-q")
    bench.run("vdblic_advect", "big.%04d.vdb", "-o", "texture.%04d.vdb", "--frames", "1", "--preroll", 2, "-q")
    for look in "flow", "ink", "smoke", "xray":
        options = ["--size", 1920, 1080, "--look", look]
        times = [[one("texture.0001.vdb", *options, threads=2, clock=time.perf_counter)
                  for one in (bench.picture, bench.render)] for _ in range(3)]
        picture, whole = map(statistics.median, zip(*times))
        print(f"| 1080p of 256³, {look} | casting {picture:.2f} s | file to file {whole:.2f} s | |", flush=True)


def bench_files(bench, before):
    """File to file beside another build, processor time of one thread; the wake by all threads."""
    bench.run("vdblic_synth", "abc", "-o", "big.%04d.vdb", "--size", 256, 256, 256, "--frames", "1-2", "-q")
    bench.run("vdblic_advect", "big.%04d.vdb", "-o", "texture.%04d.vdb", "--frames", "1", "--preroll", 2, "-q")
    bench.run("vdblic_synth", "abc", "-o", "small.%04d.vdb", "--size", 128, 128, 128, "--frames", "1-8", "-q")
    bench.run("vdblic_advect", "small.%04d.vdb", "-o", "film.%04d.vdb", "-q")
    both = lambda *arguments: [functools.partial(tools.render, *arguments, clock=whole_cpu_time) for tools in (bench, before)]
    for look in "flow", "ink", "smoke", "xray":
        compare(f"1080p of 256³, {look}", ["now", "before"],
                both("texture.0001.vdb", "--size", 1920, 1080, "--look", look), rounds=3)
    compare("256³ small, flow", ["now", "before"], both("texture.0001.vdb", "--size", 192, 108))
    compare("256³ small, xray", ["now", "before"], both("texture.0001.vdb", "--size", 192, 108, "--look", "xray"))
    command = ["film.%04d.vdb", "-o", "film.%04d.exr", "--size", 480, 270, "--opacity", "0:0,0.9:0,1:0.5"]
    film = lambda tools: lambda: tools.run("vdblic_render", *command, "--threads", 1, "-q", clock=whole_cpu_time)
    compare("8 frames of 128³, the fastest flow alone", ["now", "before"], [film(bench), film(before)])
    wake = pathlib.Path(__file__).resolve().parents[2] / "samples/wake/wake.%04d.vdb"
    bench.run("vdblic_advect", wake, "-o", "wake.%04d.vdb", "--refine", 3, "--with", "vorticity,q", "--frames", 12, "-q")
    for look in "vortex", "flow":
        picture = ["wake.0012.vdb", "--size", 1600, 900, "--samples", 4, "--look", look]
        compare(f"refined wake, four rays, {look}, elapsed", ["now", "before"],
                [functools.partial(tools.render, *picture, threads=os.cpu_count(), clock=time.perf_counter)
                 for tools in (bench, before)])


def main():
    parser = argparse.ArgumentParser(description="Measure the pictures of docs/evidence.md anew.")
    parser.add_argument("tools", type=pathlib.Path)
    parser.add_argument("sections", nargs="*", metavar="section")
    parser.add_argument("--before", type=pathlib.Path, help="the tools of another build, for the section files")
    given = parser.parse_args()
    sections = {"vtk": bench_vtk, "vdb_render": bench_vdb_render, "threads": bench_threads, "sparse": bench_sparse,
                "video": bench_video}
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        bench = Bench(given.tools.resolve(), pathlib.Path(folder))
        if given.before:
            sections["files"] = lambda bench: bench_files(bench, Bench(given.before.resolve(), bench.folder))
        print("| | | | ratio |\n|---|---|---|---|", flush=True)
        for section in given.sections or sections:
            if section == "vtk" and not importlib.util.find_spec("vtkmodules") or \
                    section == "vdb_render" and not shutil.which("vdb_render"):
                print(f"{section} is missing: left out", file=sys.stderr, flush=True)
                continue
            sections[section](bench)


if __name__ == "__main__":
    main()
