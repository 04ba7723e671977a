"""A solver streams its velocity into pictures: the Taylor-Green vortex decays, and no velocity is ever stored.

The solver is pseudo-spectral, on a periodic box of sides 2 pi: Fourier series, cut by a third, and Heun's steps.
"""

import argparse
from typing import Any

import numpy
import vdblic

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("pictures", help="the pictures to write, such as flow.%%04d.png")
parser.add_argument("--size", type=int, default=48, help="voxels along a side (default: %(default)s)")
parser.add_argument("--steps", type=int, default=60, help="steps of the solver (default: %(default)s)")
arguments = parser.parse_args()
count, dt, viscosity = arguments.size, 0.1, 0.005

waves = numpy.fft.fftfreq(count, 1 / count)
k = numpy.stack(numpy.meshgrid(waves, waves, numpy.fft.rfftfreq(count, 1 / count), indexing="ij"))
square = numpy.maximum((k**2).sum(axis=0), 1)
is_kept = (abs(k) < count / 3).all(axis=0)


def in_space(series: Any) -> Any:
    """The vectors (component, x, y, z) of Fourier series."""
    return numpy.fft.irfftn(series, s=(count,) * 3, axes=(1, 2, 3))


def change(series: Any) -> Any:
    """The change of the velocity with time, without divergence."""
    curl = in_space(1j * numpy.cross(k, series, axis=0))
    force = is_kept * numpy.fft.rfftn(numpy.cross(in_space(series), curl, axis=0), axes=(1, 2, 3))
    return force - k * (k * force).sum(axis=0) / square - viscosity * square * series


x, y, z = numpy.meshgrid(*[numpy.arange(count) * 2 * numpy.pi / count] * 3, indexing="ij")
start = [numpy.sin(x) * numpy.cos(y) * numpy.cos(z), -numpy.cos(x) * numpy.sin(y) * numpy.cos(z), 0 * x]
velocity = numpy.fft.rfftn(numpy.stack(start), axes=(1, 2, 3))
render = vdblic.Renderer(size=480, look="flow")
with vdblic.Flow(voxel_size=2 * numpy.pi / count, layout="cxyz", refine=2) as flow:
    for step in range(arguments.steps):
        for texture in flow.push(in_space(velocity), time=step * dt):
            render(texture).save(arguments.pictures % texture.frame)
        first = change(velocity)
        velocity = velocity + dt / 2 * (first + change(velocity + dt * first))
    for texture in flow.close():
        render(texture).save(arguments.pictures % texture.frame)
