# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---
# %% [markdown]
# # From arrays to pictures
# A velocity is an array (x, y, z, 3) in world units per second. Here it is that of a vortex ring, which travels upwards.

# %%
import numpy
import vdblic

x, y, z = numpy.meshgrid(*(numpy.linspace(-1, 1, n) for n in (48, 48, 64)), indexing="ij")
angle = numpy.arctan2(y, x)


def ring(height: float) -> vdblic.Grid:
    """The velocity around a ring at a height."""
    outwards, above = numpy.hypot(x, y) - 0.5, z - height
    swirl = 3 * numpy.exp(-12 * (outwards**2 + above**2))
    vectors = numpy.stack([swirl * above * numpy.cos(angle), swirl * above * numpy.sin(angle), -swirl * outwards], axis=-1)
    return vdblic.Grid(vectors, transform=numpy.diag([1 / 24, 1 / 24, 1 / 32, 1]), name="velocity")


velocities = [ring(height) for height in numpy.linspace(-0.3, 0.3, 8)]
velocities[0]

# %% [markdown]
# A texture for each frame, four times as fine. Grids are arrays for NumPy's functions.

# %%
*_, texture = vdblic.advect(velocities, refine=2, dt=0.1, progress=False)
print(texture, numpy.percentile(texture["density"][texture["density"].active], [5, 95]))
vdblic.Renderer(size=(360, 260), look="flow")(texture)

# %% [markdown]
# The same flow as streaks: lines, which are drawn, written and read as arrays.

# %%
*_, streaks = vdblic.streaks(velocities, dt=0.1, spacing=3, progress=False)
longest = max(streaks.lines, key=len)
print(streaks.lines, longest[0], longest[-1])
picture = vdblic.Renderer(size=(360, 260))(streaks)
picture.save("arrays.png")
picture
