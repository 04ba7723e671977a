"""The cache of a Mantaflow smoke domain: the files of its velocity, and our tools' options for them."""

import dataclasses
import pathlib

from .sequences import frames_of
from .vdb_header import read_header


class NotBaked(ValueError):
    """A domain without velocities; the message tells the mend."""


@dataclasses.dataclass
class Cache:
    pattern: str
    frames: list
    time_scale: float  # of the domain
    rate: float  # frames a second

    @property
    def options(self):
        """Options of vdblic_advect and vdblic_info; the files hold neither rate nor time scale."""
        scale = ["--velocity-scale", f"{self.time_scale:g}"] if abs(self.time_scale - 1) > 1e-6 else []
        return ["--fps", f"{self.rate:g}", *scale]


def cache_of(name, folder, data_format, is_adaptive, time_scale, rate):
    """The cache of a domain object. Raises NotBaked.

    @param folder  its cache_directory, absolute  @param data_format  its cache_data_format
    """
    if data_format != "OPENVDB":
        raise NotBaked(f"{name}: the cache is not of OpenVDB's format; choose it under Domain > Cache and bake again")
    pattern = str(pathlib.Path(folder) / "data" / "fluid_data_%04d.vdb")
    frames = frames_of(pattern)
    if not frames:
        raise NotBaked(f"{name}: not baked: there is no {pattern}; bake the domain (Cache, type All or Modular)")
    if is_adaptive:
        raise NotBaked(
            f"{name}: an adaptive domain writes wrong voxel sizes; switch Adaptive Domain off and bake again"
        )
    header = read_header(pattern % frames[0])
    if header.grid("velocity") is None:
        raise NotBaked(f"{header.path}: it has no velocity; bake the domain's data again")
    return Cache(pattern, frames, time_scale, rate)
