"""Flow textures of time-varying velocity volumes, over VDBLIC's library.

    import numpy, vdblic
    for texture in vdblic.advect(fields, frame_spacing=1 / 24):   # arrays (x, y, z, 3), or 'v.%04d.vdb'
        picture = vdblic.Renderer(size=(640, 480))(texture)       # (480, 640, 4)

Arrays are indexed [x, y, z], components last. Errors that a caller can mend are ValueError, and OSError where an output
cannot be written; their messages name parameters by these keywords.
"""

from ._core import __version__
from .flow import advect, synth
from .grids import Grid, Volume
from .measures import coherence, diff
from .pictures import Picture, Renderer, displayed
from .volumes import as_volume, read, write

__all__ = [
    "Grid",
    "Picture",
    "Renderer",
    "Volume",
    "__version__",
    "advect",
    "as_volume",
    "coherence",
    "diff",
    "displayed",
    "read",
    "synth",
    "write",
]
