"""A velocity field of NumPy becomes a picture: the wake of two counter-rotating vortices that drift."""

import argparse

import numpy
import vdblic

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("picture", nargs="?", default="vortices.png", help="the picture to write (default: %(default)s)")
output = parser.parse_args().picture

x, y, z = numpy.meshgrid(*(numpy.linspace(-1, 1, n) for n in (96, 64, 48)), indexing="ij")
velocity = numpy.zeros((*x.shape, 3), numpy.float32)
for side in -1, 1:
    near = numpy.exp(-12 * ((x - 0.4 * side) ** 2 + y**2))
    velocity += 3 * side * near[..., None] * numpy.stack([-y, x - 0.4 * side, 0.15 + 0 * z], axis=-1)

for texture in vdblic.advect([velocity] * 5, voxel_size=2 / 64, dt=1 / 24, refine=2):
    pass  # the flow stands still: the last texture has the longest streaks
vdblic.write("vortices.vdb", texture)
vdblic.Renderer(size=(640, 400))(texture).save(output)
