#!/usr/bin/env python3
"""How long a picture takes, next to VTK's ray caster: the same volume, camera, step and opacities, shaded, one thread.

    xvfb-run -a /usr/bin/python3 tests/bench/render_peers.py TOOLS      e.g. build/release/tools

Needs python3-vtk9 and pyopenvdb. Both are asked in turn, in CPU time, and the best of each counts. VTK gets its opacities per voxel,
for its functions of two components know no product; its gradients and our bricks are made before the clock starts.
"""

import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time

import numpy
import pyopenvdb
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import (vtkColorTransferFunction, vtkRenderer, vtkRenderWindow, vtkVolume,
                                         vtkVolumeProperty)
from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper
from vtkmodules.util.numpy_support import numpy_to_vtk
import vtkmodules.vtkRenderingOpenGL2
import vtkmodules.vtkRenderingVolumeOpenGL2

SIZE, ROUNDS, SAMPLES = 512, 5, 5


def dense(path, name):
    grid = pyopenvdb.read(str(path), name)
    low, high = grid.evalActiveVoxelBoundingBox()
    values = numpy.zeros([h - l + 1 for l, h in zip(low, high)], numpy.float32)
    grid.copyToArray(values, low)
    return values


def attributes(path):
    header = subprocess.run(["exrheader", path], capture_output=True, text=True, check=True).stdout
    return lambda name: re.search(name + r" \(type \w+\): (.*)", header)[1].strip('"()')


def vtk_scene(path, header):
    texture, magnitude = dense(path, "density"), dense(path, "magnitude")
    numbers = lambda name: [float(x) for x in header(name).split()]
    (low, high), (dark, bright) = numbers("magnitudeRange"), numbers("textureRange")
    points = [tuple(map(float, point.split(":"))) for point in header("opacity").split(",")]
    extinction = -numpy.log1p(-numpy.interp((magnitude - low) / (high - low), *zip(*points)))
    rise = numpy.clip(((texture - dark) / (bright - dark) - 0.42) / 0.58, 0, 1)
    opacity = -numpy.expm1(-extinction * rise * rise * (3 - 2 * rise))
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
    camera.SetFocalPoint(numbers("target"))
    camera.SetPosition(numbers("eye"))
    camera.SetViewUp(0, 0, 1)
    camera.SetViewAngle(35)
    renderer.ResetCameraClippingRange()
    return window, mapper


def main():
    tools = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(prefix="vdblic-") as name:
        folder = pathlib.Path(name)

        def run(tool, *arguments):
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            subprocess.run([tools / tool, *map(str, arguments), "-q"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
            return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before

        def render(*arguments):
            return run("vdblic_render", "lic.0004.vdb", "-o", "image.exr", "--size", SIZE, SIZE, "--threads", 1, "--halo", 0,
                       *arguments)

        run("vdblic_synth", "tornado", "-o", "v.%04d.vdb", "--size", 144, 73, 81, "--frames", "1-5")
        run("vdblic_advect", "v.%04d.vdb", "-o", "lic.%04d.vdb", "--frames", "1-4")
        render()
        window, mapper = vtk_scene(folder / "lic.0004.vdb", attributes(folder / "image.exr"))
        ours, theirs = [], []
        for i in range(ROUNDS):
            mapper.SetSampleDistance(0.05 + 1e-7 * i)  # a change, so that it renders again
            before = time.process_time()
            window.Render()
            if i > 0:
                theirs.append(time.process_time() - before)
            ours.append((render("--samples", 1 + SAMPLES) - render()) / SAMPLES)
        print(f"vdblic_render {min(ours):.3f} s, VTK {min(theirs):.3f} s: {min(theirs) / min(ours):.1f} times")


if __name__ == "__main__":
    main()
