# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---
# %% [markdown]
# # Weather of xarray
# A Dataset with winds `u` and `v` and the vertical motion `w` is a velocity: dimensions and units tell the rest. This one is
# made up: a jet that meanders over the Atlantic.

# %%
import matplotlib.pyplot as plt
import numpy
import vdblic
import xarray

hours, levels = numpy.arange(0, 8), numpy.linspace(200, 1000, 9)
latitudes, longitudes = numpy.arange(60, 29, -1.0), numpy.arange(-60, 1.0, 1.0)
hour, level, latitude, longitude = numpy.meshgrid(hours, levels, latitudes, longitudes, indexing="ij")
wave = numpy.radians(6 * longitude - 4 * hour)
north = (latitude - 45 - 6 * numpy.sin(wave)) / 6
speed = 45 * numpy.exp(-(north**2) - ((level - 300) / 350) ** 2)
axes = ("time", "level", "latitude", "longitude")
winds = xarray.Dataset(
    {
        "u": (axes, speed, {"units": "m s-1"}),
        "v": (axes, 0.9 * speed * numpy.cos(wave), {"units": "m s-1"}),
        "w": (axes, -0.02 * speed * numpy.sin(wave), {"units": "Pa s-1"}),
    },
    {
        "time": numpy.datetime64("2026-01-30T00", "ns") + hours * numpy.timedelta64(1, "h"),
        "level": ("level", levels, {"units": "hPa"}),
        "latitude": ("latitude", latitudes, {"units": "degrees_north"}),
        "longitude": ("longitude", longitudes, {"units": "degrees_east"}),
    },
)

# %% [markdown]
# Textures have coordinates, units and dates again.

# %%
*_, texture = vdblic.advect(winds, refine=2, scalars="texture", progress=False)
data = texture.to_xarray()
print(data)
data.magnitude.max("z").plot(x="x")
plt.show()

# %%
picture = vdblic.Renderer(size=(360, 260), look="flow", stretch=(1, 1, 60))(texture)
picture.save("weather.png")
picture
