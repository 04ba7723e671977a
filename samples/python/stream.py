# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---
# %% [markdown]
# # A solver's stream
# A lattice Boltzmann solver (D3Q19, single relaxation time) of a channel with a cylinder. Each velocity is pushed and
# overwritten; none is stored.

# %%
import itertools
from typing import Any

import numpy
import vdblic

size = (64, 32, 8)
steps = [c for c in itertools.product((-1, 0, 1), repeat=3) if sum(map(abs, c)) < 3]
c = numpy.array(steps)
weights = numpy.array([(1 / 3, 1 / 18, 1 / 36)[numpy.abs(step).sum()] for step in steps])
opposite = [steps.index((-i, -j, -k)) for i, j, k in steps]
x, y, z = numpy.indices(size)
solid = (x - 14) ** 2 + (y - 15.3) ** 2 < 4**2
inflow, omega = numpy.array([0.1, 0, 0]), 1.85


def balanced(density: Any, velocity: Any) -> Any:
    """The densities that move to each side, in equilibrium."""
    along = 3 * velocity @ c.T
    return weights * density[..., None] * (1 + along + along**2 / 2 - 1.5 * (velocity**2).sum(-1)[..., None])


def step(f: Any) -> tuple[Any, Any]:
    """Collide, bounce from the cylinder, and move on."""
    density = f.sum(-1)
    velocity = f @ c / density[..., None]
    f = numpy.where(solid[..., None], f[..., opposite], f + omega * (balanced(density, velocity) - f))
    for i, shift in enumerate(steps):
        f[..., i] = numpy.roll(f[..., i], shift, (0, 1, 2))
    f[0] = f[-1] = balanced(numpy.ones(size[1:]), numpy.broadcast_to(inflow, (*size[1:], 3)))
    return f, numpy.where(solid[..., None], 0, velocity)


# %% [markdown]
# `push` returns the textures that a frame finishes; `save` leaves a checkpoint that a later `Flow(resume=...)` goes on from.

# %%
f = balanced(numpy.ones(size), numpy.broadcast_to(inflow, (*size, 3)))
with vdblic.Flow(refine=2, progress=False) as flow:
    for number in range(60):
        for _ in range(10):
            f, velocity = step(f)
        textures = flow.push(velocity, time=10.0 * number)
    flow.save("flow.vdb")
print(textures)
picture = vdblic.Renderer(size=(360, 260), look="flow", eye=(32, -30, 60), target=(32, 14, 4))(textures[-1])
picture.save("stream.png")
picture
