#!/usr/bin/env python3
"""The table "Pictures" of docs/evidence.md: times of a picture beside VTK's ray caster and vdb_render.

    xvfb-run -a /usr/bin/python3 tests/bench/render_peers.py TOOLS

Needs pyopenvdb, python3-vtk9, xvfb-run and vdb_render. Peers get the same volume, camera and step, 512² pixels, one
thread. The compared programs run in turn. Times are medians of processor time. Our time for a picture is that of one more
ray for each pixel (--samples), without reading and building bricks; VTK's excludes its gradients, vdb_render's excludes
reading.
"""

import math
import pathlib
import re
import resource
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


class Bench:
    def __init__(self, tools, folder):
        self.tools, self.folder = tools, folder

    def run(self, tool, *arguments):
        """Seconds of a command."""
        path = self.tools / tool
        before = cpu_time()
        subprocess.run([path if path.exists() else tool, *map(str, arguments)], cwd=self.folder, check=True,
                       stdout=subprocess.DEVNULL)
        return cpu_time() - before

    def render(self, volume, *options):
        return self.run("vdblic_render", volume, "-o", "image.exr", "--threads", 1, "-q", *options)

    def picture(self, volume, *options):
        """Seconds for one ray to each pixel, without reading and building bricks."""
        time = lambda samples: self.render(volume, "--samples", samples, "--step", STEP, "--interpolation", "linear", *options)
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


def compare(title, times, rounds=ROUNDS):
    """Time two functions in turn; print their median times and their median ratio as a row of a table."""
    rounds = [[one() for one in times] for _ in range(rounds)]
    ours, other = map(statistics.median, zip(*rounds))
    ratio = statistics.median(second / first for first, second in rounds)
    print(f"| {title} | {ours:.2f} s | {other:.2f} s | {ratio:.1f} |", flush=True)


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
    compare("VTK, `vtkFixedPointVolumeRayCastMapper`", [lambda: bench.picture(volume, *SQUARE), vtk])


def bench_vdb_render(bench):
    volume = bench.texture()
    bench.render(volume, *SQUARE)
    text = lambda name: ",".join(f"{x:.9g}" for x in bench.header()(name))
    camera = ["-translate", text("eye"), "-lookat", text("target"), "-up", "0,0,1", "-fov", 35, "-step", STEP]
    texture = dense(bench.folder / volume, "density")
    ratio = texture.mean() / share(texture, bench.header()).mean()  # so that the mean extinction is the same
    for title, scatter, absorb in ("thin medium", 0.1, 0.01), ("its default medium", 1.5, 0.1):
        opacity = f"0:{-math.expm1(-0.1 * (scatter + absorb) * ratio):.4f}"
        theirs = lambda size: bench.run("vdb_render", volume, "image.ppm", "-name", "density", "-cpus", 1, "-res",
                                        f"{size}x{size}", "-scatter", f"{scatter},{scatter},{scatter}", "-absorb",
                                        f"{absorb},{absorb},{absorb}", *camera)
        compare(f"`vdb_render`, {title}",
                [lambda: bench.picture(volume, *SQUARE, "--opacity", opacity), lambda: theirs(SIZE) - theirs(2)], rounds=2)


def main():
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        bench = Bench(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(folder))
        print("|  | `vdblic_render` | the other | ratio |\n|---|---|---|---|", flush=True)
        bench_vtk(bench)
        bench_vdb_render(bench)


if __name__ == "__main__":
    main()
