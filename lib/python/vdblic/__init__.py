"""Flow textures of time-varying velocity volumes, over VDBLIC's library.

    import vdblic

    vdblic.film(velocities, "flow.mp4", voxel_size=0.1)                # a film in a line
    render = vdblic.Renderer(size=(640, 480), look="flow")
    for texture in vdblic.advect(velocities, voxel_size=0.1, refine=2):
        render(texture).save(f"flow.{texture.frame:04}.png")

velocities is 'v.%04d.vdb', an iterable of arrays (x, y, z, 3) or of pairs (time, array), or a Dataset of xarray.

    film(velocities, path)          a film or a still, as vdblic_film makes it
    advect(velocities, ...)         the texture of each frame, as soon as it is finished
    streaks(velocities, ...)        its streaks as lines, which are drawn, written and read as arrays; a
                                    notebook shows them as a page that moves, and save() writes it
    Flow(...)                       textures for a solver that pushes its velocity, also by ranks of mpi4py
    Renderer(...)(texture)          a Picture
    read(path), write(path, data)   volumes: grids by name, which are arrays, and metadata
    as_volume(data)                 a volume of arrays, or of data of xarray or VTK
    diff(a, b)                      the report of vdblic_diff
    coherence(velocities, textures) the report of vdblic_coherence
    synth(flow, size, frames)       velocities of a known flow

Options have the names of the tools' options, with underscores: --bbox-world is bbox_world, --with is with_. Arrays are
indexed [x, y, z], components last, unless `layout` tells another order. Errors that a caller can mend are ValueError, and
OSError where an output cannot be written; their messages name parameters by these keywords.
"""

from ._core import __version__
from .films import Film, film
from .flow import Flow, Streaks, Textures, advect, streaks, synth
from .grids import Grid, Lines, Volume
from .measures import coherence, diff
from .pictures import Picture, Renderer
from .volumes import as_volume, read, write

__all__ = [
    "Film",
    "Flow",
    "Grid",
    "Lines",
    "Picture",
    "Renderer",
    "Streaks",
    "Textures",
    "Volume",
    "__version__",
    "advect",
    "as_volume",
    "coherence",
    "diff",
    "film",
    "read",
    "streaks",
    "synth",
    "write",
]
