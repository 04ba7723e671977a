"""Textures of velocities, and velocities of known flows."""

from __future__ import annotations

import collections
import dataclasses
import datetime
import functools
import os
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy

from . import _core
from .frames import Frame, FrameReader, Frames, is_path, seconds_of
from .grids import Grid, Volume
from .pages import Page, gathered, page
from .parameters import checked, described
from .progress import Progress, Teller
from .ranks import Ranks
from .volumes import Lengths, as_dictionaries, path_of, volume_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import AdvectOptions, FlowOptions, StreakOptions

_OF_FILES = "frames", "clamp_frames", "lead_in"


class Textures(Iterator[Volume]):
    """An iterator over the textures of a run. Closing it, as `with` does, ends the run and frees its memory."""

    def __init__(self, run: Any, teller: Teller) -> None:
        self._run, self._teller = run, teller

    def __next__(self) -> Volume:
        if self._run is None:
            raise StopIteration
        try:
            made = self._run.next()
        except BaseException:
            self.close()
            raise
        if made is None:
            self.close()
            raise StopIteration
        return volume_of(*made)

    def close(self) -> None:
        """End the run."""
        self._run = None
        self._teller.close()

    def __enter__(self) -> Textures:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class Streaks(Textures):
    """The streaks of a run, frame by frame. A notebook shows them as a page that moves, and save() writes it. The page has
    the frames that were not read yet, and ends the run.
    """

    def __init__(self, run: Any, teller: Teller, has_lines: bool) -> None:
        super().__init__(run, teller)
        self._has_lines = has_lines
        self._page: Page | None = None
        self._last = Volume(())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page, an .html of at most 25 MB that any browser opens. Raises OSError if it cannot be written, and
        ValueError if the run has ended or has no line.
        """
        _core.check_extension(path_of(path), [".html"])
        _core.check_output(path_of(path))
        self._made().save(path)

    def _repr_html_(self) -> str | None:
        is_left = self._page is not None or self._run is not None and self._has_lines
        return self._made()._repr_html_() if is_left else None

    def _made(self):
        if self._page is None:
            if not self._has_lines:
                raise ValueError("a page shows lines; leave `draw` out")
            if self._run is None:
                raise ValueError("the run has ended; call streaks() again for a page of all its frames")
            paths, frames, first = gathered(self._arrays())
            if not paths.radius:
                raise ValueError("no line in any frame; there is nothing to show")
            tell = functools.partial(self._teller, "warned")
            self._page = Page(page(paths.finish(), "Streaks", frames, first, self._last, tell))
        return self._page

    def _arrays(self):
        for self._last in self:
            yield self._last.frame, self._last.lines.stored.arrays(), self._last.metadata


def advect(
    velocities: str | os.PathLike[str] | Iterable[Frame],
    /,
    *,
    voxel_size: Lengths = 1.0,
    layout: str | None = None,
    progress: Progress = None,
    **parameters: Unpack[AdvectOptions],
) -> Textures:
    """Yield the flow texture of every frame as it is finished: a Volume with `density`, `magnitude` and metadata.

    The textures are those of `vdblic_advect`, bit for bit.

    velocities     the name of a file or a pattern such as 'v.%04d.vdb'; or any iterable of velocities in world units
                   per second: arrays (x, y, z, 3), Grids, Volumes, data of xarray and VTK (as_volume() tells which), or
                   pairs of a time in seconds or a date, and one of these. An iterable is read one frame ahead; frames
                   count from 1. One of these by itself is one frame; data of xarray have a frame for each time, and
                   so has an array with an axis for it
    voxel_size     of arrays without coordinates: one length or three
    layout         order of the axes of arrays by the letters t, x, y, z and c (components, last unless they are named):
                   'zyx', 'tzyx', 'cxyz'. By default (x, y, z, 3); an array over time must tell
    progress       a function that is called with the steps done and their number, which is None where it is unknown;
                   True or False for a bar of tqdm, by default in notebooks and terminals if tqdm is installed
    parameters     of `vdblic_advect`, by the names of its options; a list may stand for a text with commas:
                   frames=[1, 2, 5]; a duration for seconds. Those of output files and checkpoints are left out:

{parameters}
    Errors in parameters are raised at once, errors in a frame when it is read, with its number. Closing the iterator
    ends the run; Ctrl-C ends it before the next step. Warnings are Python's, messages go to the logger `vdblic`.
    Any number of runs may go on at a time.

    >>> still = numpy.ones((8, 8, 8, 3))
    >>> [texture.time for texture in advect([still] * 3, dt=0.5)]
    [0.0, 0.5, 1.0]
    """
    frames = None if is_path(velocities) else Frames(velocities, voxel_size, layout)
    return Textures(*_begun("advect", velocities, frames, checked("advect", parameters, PARAMETERS), progress))


PARAMETERS = described(advect, _core.parameters("advect"), without=("input",))


def streaks(
    velocities: str | os.PathLike[str] | Iterable[Frame],
    /,
    *,
    voxel_size: Lengths = 1.0,
    layout: str | None = None,
    progress: Progress = None,
    **parameters: Unpack[StreakOptions],
) -> Streaks:
    """Yield the streaks of every frame: a Volume whose `lines` are the streaks, each with a bright head and a tail that
    fades. A Renderer draws it and write() stores it. `draw="voxels"` yields textures in their place. A notebook shows the
    result as a page that moves, and save() writes the page:

        vdblic.streaks(velocities, voxel_size=0.1).save("flow.html")

    The streaks are those of `vdblic_advect --method streaks --draw lines`, bit for bit.

    velocities, voxel_size, layout, progress   those of advect()
    parameters     of `vdblic_advect`, by the names of its options:

{parameters}
    >>> for volume in streaks(synth("tornado", 16, [1, 2]), spacing=4):
    ...     print(volume.lines, sorted(volume.lines.scalars))
    <vdblic.Lines: 112 lines, 1574 points> ['magnitude']
    <vdblic.Lines: 122 lines, 1634 points> ['magnitude']
    """
    frames = None if is_path(velocities) else Frames(velocities, voxel_size, layout)
    options: dict[str, Any] = {"draw": "lines"} | checked("streaks", parameters, STREAK_PARAMETERS)
    run, teller = _begun("streaks", velocities, frames, options | {"method": "streaks"}, progress)
    return Streaks(run, teller, options["draw"] == "lines")


_OF_OTHERS = (
    "input", "method", "life", "release_window", "sharpen", "noise_share", "alpha", "noise", "finish", "interpolation",
)  # fmt: skip
STREAK_PARAMETERS = described(streaks, _core.parameters("advect"), without=_OF_OTHERS)


def _begun(title, velocities, frames, options, progress):
    """A run and its teller. @param frames  of velocities in memory, else None"""
    volumes = None
    if frames is None:
        options["input"] = os.fspath(velocities)  # type: ignore[arg-type]
    else:
        if given := [key for key in _OF_FILES if key in options]:
            raise ValueError(f"`{given[0]}` selects files; leave it out, and give the frames that are to be used")
        volumes = _members(frames)
    teller = Teller(progress, title)
    try:
        return _core.Textures(options, volumes, frames.count if frames else 0, teller), teller
    except BaseException:
        teller.close()
        raise


class Flow:
    """The textures of a flow that is still being computed: frames go in as a solver makes them, and none is stored.

    It takes `voxel_size`, `layout`, `progress` and parameters of advect(), and makes the same textures. Two frames are
    in memory. A texture shows the flow from its frame to the next one, so it is finished when that comes, and the last
    one when the flow is closed:

    >>> flow = Flow(voxel_size=0.1, method="auflic")
    >>> for step in range(3):
    ...     velocity = numpy.full((8, 8, 8, 3), 1.0 + step)
    ...     for texture in flow.push(velocity, time=step / 24):
    ...         print(texture.frame)
    1
    2
    >>> [texture.frame for texture in flow.close()]
    [3]

    `with` frees the memory however the loop ends.

    comm           a communicator of mpi4py: each of its ranks pushes its part of the velocity, without a halo. Rank 0 gets
                   the textures, bit for bit those of one process; the others get none. All ranks call push(),
                   save() and close() together
    origin         index of the first voxel of this rank's part in the whole; of a Grid it is added to its own
    resume         a file of save(): the textures go on as if there had been no interruption. The parameters must be the
                   same, and the first velocity is the one that was pushed last before save()

{parameters}"""

    def __init__(
        self,
        *,
        voxel_size: Lengths = 1.0,
        layout: str | None = None,
        progress: Progress = None,
        comm: Any = None,
        origin: Sequence[int] = (0, 0, 0),
        resume: str | os.PathLike[str] | None = None,
        **parameters: Unpack[FlowOptions],
    ) -> None:
        options = checked("Flow", parameters, FLOW_PARAMETERS)
        self._ranks = None if comm is None else Ranks(comm)
        if self._ranks and "carry" in options:
            raise ValueError("`carry` is of one process; leave it out with `comm`")
        self._read = FrameReader(voxel_size, layout, origin)
        self._stamps: list[str] = []  # of the first frame and the last
        if resume is not None:
            self._stamps = _stamps_in(path_of(resume))
            self._read.go_on(*self._stamps)
        self._resumes = resume is not None
        self._waiting: collections.deque[Volume] = collections.deque()
        teller = Teller(progress, "flow", stacklevel=5)
        frames, checkpoint = _members(_taken(self._waiting)), None if resume is None else path_of(resume)
        self._run: Any = _core.Textures(options, frames, 0, teller, self._ranks, checkpoint)
        self._textures = Textures(self._run, teller)

    def push(self, velocity: Any, time: Any = None) -> list[Volume]:
        """Take the velocity of the next frame, and return the textures that it finishes: none for the first frame, then
        one, or as many as there are `substeps`.

        velocity   a frame, as for advect(). It may be overwritten afterwards
        time       in seconds or a date; by default `dt` after the frame before
        """
        if self._run is None:
            raise ValueError("the flow is closed")
        self._waiting.append(self._taken(velocity, time))
        made = []
        while self._run is not None and len(self._waiting) >= self._run.needed:
            made.append(self._next())
        if self._waiting:  # the first frame, which is read when the second comes
            self._waiting.append(_copied(self._waiting.pop()))
        return self._of_first_rank(made)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a checkpoint, a .vdb file, which a Flow can `resume`. It does not hold the velocity: a solver saves its own
        state beside it, after the same push(), and pushes that velocity again when both go on.

        Raises ValueError before the second push(), and OSError if the file cannot be written.
        """
        if self._run is None:
            raise ValueError("the flow is closed")
        self._run.save(path_of(path), self._stamps)

    def close(self) -> list[Volume]:
        """End the flow, free its memory, and return the textures that were waiting for another frame."""
        made = []
        while self._run is not None and (texture := self._next()) is not None:
            made.append(texture)
        self._end()
        return self._of_first_rank(made)

    def _taken(self, velocity, time):
        """The volume of a frame. Raises at all ranks if one of them has an error."""
        volume, error = None, None
        try:
            volume = self._read(velocity, time)
            stamp = self._read.stamp
            if self._resumes and stamp != self._stamps[1]:
                raise ValueError(f"the checkpoint goes on from {self._stamps[1]}; push its velocity first, not {stamp}")
        except ValueError as found:
            error = found
        if self._ranks:
            grids = [] if volume is None else volume.grids
            self._ranks.agree(error, "".join(f"{grid.name} {grid.transform}" for grid in grids) + self._read.stamp)
        if error is not None:
            raise error
        self._resumes = False
        self._stamps = [(self._stamps or [stamp])[0], stamp]
        return volume

    def _of_first_rank(self, made):
        return made if self._ranks is None or self._ranks.rank == 0 else []

    def _next(self):
        try:
            return next(self._textures)
        except StopIteration:
            return None
        except BaseException:
            self._end()
            raise

    def _end(self):
        self._run = None
        self._waiting.clear()
        self._textures.close()

    def __enter__(self) -> Flow:
        return self

    def __exit__(self, *error: object) -> None:
        self._end()


FLOW_PARAMETERS = described(Flow, _core.parameters("advect"), without=("input", "steady_frames", *_OF_FILES))


def _members(volumes):
    """Volumes as arguments of _core."""
    for volume in volumes:
        yield as_dictionaries(volume), volume.metadata


def _taken(waiting):
    """Yield the items of a queue until it is empty."""
    while waiting:
        yield waiting.popleft()


def _stamps_in(checkpoint):
    """The stamps of the first frame and the last in the checkpoint of a Flow."""
    if not os.path.exists(checkpoint):
        raise ValueError(f"{os.fsdecode(checkpoint)}: no such file")
    metadata = _core.read_headers(checkpoint)[1]
    stamps = [metadata.get(f"input {number:06}", "") for number in (0, 1)]
    if not all(stamp.startswith("velocity ") for stamp in stamps):
        raise ValueError(f"{os.fsdecode(checkpoint)}: is no checkpoint that Flow.save() wrote")
    return stamps


def _copied(volume):
    """A copy of a volume that shares no arrays."""
    grids = (
        dataclasses.replace(grid, values=grid.values.copy(), active=None if grid.active is None else grid.active.copy())
        for grid in volume.grids
    )
    return Volume(grids, volume.metadata)


def synth(
    flow: str,
    size: int | Sequence[int] | None,
    frames: Iterable[int],
    *,
    dt: float | datetime.timedelta | numpy.timedelta64 | None = None,
    voxel_size: float = 0.1,
) -> Iterator[Volume]:
    """Yield the velocity of an analytic, unsteady flow for each frame number, as `vdblic_synth` writes it.

    Frame 1 is at time 0. One number is the `size` of a cube; a flow on the Earth takes none. By default `dt` lets the
    flow move by about 3 voxels. A name that does not exist gives a ValueError with all names.

    >>> next(synth("tornado", 8, [1]))
    <vdblic.Volume: velocity (8, 8, 8, 3); frame 1; time 0 s>
    """
    box = None
    if size is not None:
        voxels = numpy.broadcast_to(numpy.asarray(size), 3)
        if not (voxels == voxels.astype(int)).all():
            raise ValueError(f"`size` cannot be {size!r:.100}; it is whole numbers of voxels")
        box = tuple(voxels.astype(int).tolist())
    seconds = _core.synth_dt(flow, float(voxel_size)) if dt is None else seconds_of(dt)
    for frame in frames:
        time = (int(frame) - 1) * seconds
        grids = [Grid(**grid) for grid in _core.synth(flow, box, time, float(voxel_size))]
        grids[0].metadata |= {"frame": int(frame), "time": time, "dt": seconds}
        yield Volume(grids)
