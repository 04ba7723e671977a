"""The steps of an input: which files and which times in them become which frames."""

import dataclasses
import pathlib
import re

from vdblic._core import FramePattern, InputPaths, files_of, frame_of_name, parse_frames

from .errors import InputError, ParameterError
from .readers import Source, open_sources


@dataclasses.dataclass
class Step:
    """One frame: step `index` of a source; `time` and `dt` are in seconds, None where they are unknown."""

    frame: int
    source: Source
    index: int
    time: float | None
    dt: float | None

    def where(self):
        """The file, and the time in it if it holds several, for messages."""
        several = len(self.source.times) > 1 and self.time is not None
        return f"{self.source.path}: at {self.time:g} s" if several else str(self.source.path)


class Series:
    """The frames that a command line selects, in order.

    A file of one step has the frame number of its name. Files of several steps are one series, whose steps are numbered
    from 1 or from --renumber on. Sources are opened one at a time.
    """

    def __init__(self, options, stop):
        self._options, self._stop = options, stop
        self._chosen = parse_frames(options.frames) if options.frames else None
        self._first = self._last = None  # sources; the newest one is kept, so that a file is not read twice
        self.start = None  # the time of the first step of all, if the input has dates: the others count from it
        self.calendar = None  # of that date
        self.count, self.frames, self._files = 0, [], []
        self._first_number = 1 if options.renumber is None else options.renumber
        self.streamed = "-" in options.input
        if self.streamed and len(options.input) > 1:
            raise ParameterError("paths on standard input are one flow; leave out the other inputs")
        if not self.streamed:
            self._find()
        elif self._chosen:
            raise ParameterError("--frames cannot select from paths on standard input")

    def _find(self):
        """The files and the frames of the inputs."""
        text, *others = self._options.input
        found = [_files_of(text)]
        for other in others:
            files = _files_of(other)
            if len(files) == 1 < len(found[0]):  # as that of a grid
                files = dict.fromkeys(found[0], *files.values())
            if len(files) != len(found[0]) or len(files) > 1 and files.keys() != found[0].keys():
                raise InputError(f"{other}: its files are not numbered as those of {text}; inputs of one flow are")
            found.append(files)
        self._files = [(frame, paths) for frame, *paths in zip(found[0], *(files.values() for files in found))]
        self._open_first(self._files[0][1])
        self._numbered = len(self._first.times) > 1
        if self._numbered:
            steps = sum(len(self._open(paths).times) for _, paths in self._files)
            self.frames = self._select(range(self._first_number, self._first_number + steps))
        elif self._options.renumber is not None:
            raise ParameterError(
                "--renumber is for paths on standard input and for files of several steps; a pattern has the numbers"
            )
        elif pathlib.Path(self._files[0][1][0]).is_dir():
            self.frames = self._select([frame for frame, _ in self._files])
        else:
            self.frames = [frame for frame, _ in files_of(text, self._options.frames, self._options.clamp_frames)]
        self.count = 0 if self._options.times else len(self.frames)

    def inputs(self):
        """The files, for checks that no output replaces them."""
        return [path for _, paths in self._files for path in paths]

    def steps(self):
        """The selected steps one by one."""
        if self.streamed:
            yield from self._streamed()
            return
        selected, number, before = set(self.frames), self._first_number, None
        for frame, paths in self._files:
            if not self._numbered and frame not in selected:
                continue
            source = self._open(paths)
            if len(source.times) > 1 and not self._numbered:
                raise InputError(
                    f"{source.path}: it holds {len(source.times)} steps, the files before it one; use files alike"
                )
            for index in range(len(source.times)):
                step = self._step(number if self._numbered else frame, source, index, before)
                number += 1
                before = step.time
                if step.frame in selected and self._within(step):
                    yield step

    def take_first(self):
        """The source of the first step, selected or not. Call it once: the source is not kept in memory."""
        first, self._first = self._first, None
        return first

    def _streamed(self):
        number, before, taken = self._options.renumber, None, {}
        for path in InputPaths(self._stop.check):
            if not taken:
                self._open_first([path])
            source = self._open([path])
            if len(source.times) > 1 and number is None:
                raise InputError(
                    f"{path}: it holds {len(source.times)} steps; --renumber START numbers the steps as they come"
                )
            for index in range(len(source.times)):
                frame = _numbered(path, number, taken)
                number = None if number is None else number + 1
                step = self._step(frame, source, index, before)
                before = step.time
                if self._within(step):
                    yield step
        if not taken:
            raise InputError("standard input names no files")

    def _step(self, frame, source, index, before):
        if self._options.dt:
            return Step(frame, source, index, (frame - 1) * self._options.dt, self._options.dt)
        times = source.times
        time = times[index]
        if time is None:
            return Step(frame, source, index, None, None)
        if source.calendar and self.start is not None:
            time -= self.start
        if before is not None and not time > before:
            raise InputError(
                f"{source.path}: step {index + 1} is at {time:g} s, not after {before:g} s, the step before it; order"
                " the files by time, or give the spacing with --dt"
            )
        dt = None if before is None else time - before
        if len(times) > 1:
            later = min(index + 1, len(times) - 1)
            dt = times[later] - times[later - 1]
        return Step(frame, source, index, time, dt)

    def _open_first(self, paths):
        self._first = self._open(paths)
        self.start = self._first.times[0] if self._first.calendar else None
        self.calendar = self._first.calendar

    def _open(self, paths):
        if self._last is None or self._last.paths != paths:
            if self._last is not None:
                self._last.free()  # its memory, before the next file is read
            self._last = open_sources(paths, self._options)
        return self._last

    def _select(self, numbers):
        if self._chosen is None:
            return list(numbers)
        if self._options.clamp_frames:
            self._chosen = [frame for frame in self._chosen if numbers[0] <= frame <= numbers[-1]]
            if not self._chosen:
                raise InputError(f"{self._options.input[0]}: no frame of {self._options.frames} is in it")
        present = set(numbers)
        for frame in self._chosen:
            if frame not in present:
                raise InputError(
                    f"frame {frame} is missing: {self._options.input[0]} has {min(present)} to {max(present)}; "
                    "--frames can select the others"
                )
        return self._chosen

    def _within(self, step):
        limits = self._options.times
        return not limits or step.time is not None and limits[0] <= step.time <= limits[1]


def _files_of(text):
    """The files that a case, a file or a pattern names: frame → path."""
    path = pathlib.Path(text)
    if path.is_dir():
        return {frame_of_name(path) or 1: path}
    if found := _folders_of(path):
        return found
    pattern = FramePattern(text)
    found = {frame: pattern.path(frame) for frame in pattern.frames_on_disk()} if pattern.has_field else {}
    return found or dict(files_of(text, "", False))  # raises an error that names the missing part


def _folders_of(pattern):
    """The numbered folders that a path such as AMReX's `plt*` names: number → path, in order."""
    before, star, after = pattern.name.partition("*")
    name, found = re.compile(f"{re.escape(before)}([0-9]+){re.escape(after)}"), {}
    for folder in pattern.parent.iterdir() if star and pattern.parent.is_dir() else ():
        match = name.fullmatch(folder.name)
        if not match or not folder.is_dir():
            continue
        number = int(match[1])
        if number in found:
            raise InputError(f"{folder}: its number is that of {found[number]}; move one of the two away")
        found[number] = folder
    return dict(sorted(found.items()))


def _numbered(path, number, taken):
    """The frame of a step whose file is named on standard input: `number`, or if it is None that of the name.

    `taken` maps the numbers so far to their paths.
    """
    frame = frame_of_name(path) if number is None else number
    if frame is None:
        raise InputError(
            f"{path}: the name does not end in a frame number; --renumber START numbers the paths as they come"
        )
    if frame in taken:
        raise InputError(
            f"{path}: frame {frame} comes twice on standard input; the first was {taken[frame]}; "
            "--renumber START numbers the paths as they come"
        )
    taken[frame] = path
    return frame
