"""vdblic_import: flows of other programs into velocity sequences."""

import os
import re
import warnings

from .errors import InputError, ParameterError
from .outputs import Outputs
from .tool import Tool, number, positive, whole
from .velocity import check_carried, chosen, contents, names_of


def main(version, words):
    tool = Tool(
        "vdblic_import",
        version,
        (
            "Convert the flows of other programs into velocity volumes: files of VTK (.vti .vtr .vts "
            ".vtu .vtm .vtk .pvd), cases of OpenFOAM, EnSight and CGNS, NetCDF (CF, WRF, ROMS, FVCOM, MPAS, UGRID), "
            "Zarr, GRIB, arrays (.npz .npy .h5 .mat)."
        ),
    )
    tool.add(
        "input",
        nargs="+",
        metavar="INPUT",
        help=(
            "Flow. One file, a case's folder, a pattern (name.%%04d.vti, also ####, @@@@, $F4, <F4>), "
            "or - for paths on standard input. Several are one flow, with the same times."
        ),
    )
    tool.add("-o", "--output", metavar="TEXT", required=True, help="Velocity files, such as v.%%04d.vdb.")
    tool.sequence(
        numbering="the steps of files that hold several, and paths on standard input,",
        frames=" The steps of a file with several count from 1.",
    )
    tool.add(
        "--times",
        metavar=("T0", "T1"),
        nargs=2,
        type=number,
        help="Use the steps from time T0 to time T1 only [seconds].",
    )
    tool.add(
        "--array",
        metavar="TEXT",
        help="Array that is the velocity, or two or three that are its components: U or u,v,w.",
    )
    tool.add("--carry", metavar="TEXT", help="Further arrays to convert: NAME,NAME.")
    tool.add(
        "--attribute",
        metavar="TEXT",
        nargs="+",
        help="What a file of NetCDF, Zarr or GRIB does not say, as if it did: NAME:ATTRIBUTE=VALUE ..., such as "
        "depth:positive=down u:units=cm/s v:standard_name=northward_wind.",
    )
    tool.add(
        "--layout",
        metavar="TEXT",
        help="Order of the axes of arrays (.npy .npz .h5 .mat): letters of t (time), c (component), x, y and z, such as "
        "cxyz or tczyx. Files in the form of vdblic_export need none.",
    )
    tool.add(
        "--explain",
        action="store_true",
        help="Tell how each coordinate and component of the first step is understood, with two values and units.",
    )
    tool.add("--like", metavar="TEXT", help="Resample to the voxels of a .vdb grid: FILE or FILE:GRID.")
    tool.add(
        "--size",
        metavar=("X", "Y", "Z"),
        nargs=3,
        type=whole(1, 131072),
        help="Resample to so many voxels along x, y and z.",
    )
    tool.add(
        "--voxel-size",
        metavar="FLOAT",
        nargs="+",
        type=positive,
        help="Resample to voxels of this size, or of three sizes along x, y and z [world].",
    )
    tool.add(
        "--bounds",
        metavar=("X0", "Y0", "Z0", "X1", "Y1", "Z1"),
        nargs=6,
        type=number,
        help="Box that the voxels fill [world]; all of the flow by default.",
    )
    tool.add(
        "--dt",
        metavar="FLOAT",
        type=positive,
        help="Seconds from one frame number to the next, in place of the files' times.",
    )
    return tool.run(words, run)


def run(options, console, stop):
    """Convert every selected step."""
    _check(options)
    warnings.simplefilter("ignore")  # warnings of packages are for programmers
    from .series import Series  # what takes long to load is loaded once the options are right

    outputs = Outputs(options, [".vdb"], console, stop)
    series = Series(options, stop)
    if not series.streamed:
        references = [options.like] if options.like and os.path.exists(options.like) else []
        outputs.check(series.frames, [*series.inputs(), *references], series.count)
    conversion = Conversion(options, console)
    written = 0
    for step in series.steps():
        outputs.write(step.frame, step.source.path, lambda path, step=step: conversion.write(step, series, path))
        written += 1
    if not written:
        raise InputError(f"{options.input[0]}: no step lies within --times {options.times[0]:g} {options.times[1]:g}")


def _check(options):
    """Raise ParameterError for options that exclude each other or have values of the wrong number."""
    options.array = names_of(options.array) if options.array else ()
    options.carry = names_of(options.carry) if options.carry else ()
    options.attribute = _answers(options.attribute or ())
    if options.layout and not re.fullmatch(r"(?=.*x)(?!.*(.).*\1)[tcxyz]{2,5}", options.layout):
        raise ParameterError("--layout is letters of t, c, x, y and z, each once, such as cxyz")
    if options.voxel_size and len(options.voxel_size) not in (1, 3):
        raise ParameterError("--voxel-size takes one number or three")
    if options.like and (options.size or options.voxel_size or options.bounds):
        raise ParameterError("--like gives size, voxels and bounds; leave out --size, --voxel-size and --bounds")
    if options.size and options.voxel_size:
        raise ParameterError("--size and --voxel-size exclude each other")
    if options.bounds and not all(low < high for low, high in zip(options.bounds[:3], options.bounds[3:])):
        raise ParameterError("--bounds is an empty box; it takes X0 Y0 Z0 X1 Y1 Z1, the second corner above the first")
    if options.times and options.times[0] > options.times[1]:
        raise ParameterError(f"--times {options.times[0]:g} {options.times[1]:g} runs backwards")


def _answers(words):
    """Attributes by variable: NAME:ATTRIBUTE=VALUE. Raises ParameterError."""
    answers = {}
    for word in words:
        match = re.fullmatch(r"([^=]+):(\w+)=(.*)", word)
        if not match:
            raise ParameterError(f"--attribute '{word[:60]}' is not NAME:ATTRIBUTE=VALUE, such as depth:positive=down")
        answers.setdefault(match[1], {})[match[2].lower()] = match[3]
    return answers


class Conversion:
    """Resamples steps to one grid, which the first step of the whole series chooses."""

    def __init__(self, options, console):
        self._options, self._console = options, console
        self._names, self._target = (), None
        self._told, self._coarse, self._grown, self._explained, self._summed = set(), False, False, [], False

    def write(self, step, series, path):
        """Write a step's .vdb file."""
        import vdblic
        from .resample import flow_at

        if self._target is None:
            self._target = self._choose(series)
        source, where = step.source, step.where()
        arrays = source.arrays(step.index)
        chosen(arrays, self._names, (), where)  # every step has them
        check_carried(arrays, self._options.carry, where)
        velocity, carried, mask, met, target = flow_at(
            source, step.index, self._names, self._options.carry, lambda flow: self._covering(flow, step), where
        )
        self._check_cells(met)
        self._tell_notes(source)
        if not mask.any():
            self._console.warn(f"{source.path}: frame {step.frame} has no values within the voxels")
        if self._options.explain and not self._explained:
            self._explained = [self._console.say(text) for text in source.explained.values()]
        self._tell_once(velocity, mask, step)
        grids = []
        for name, values in [("velocity", velocity), *carried.items()]:
            vector = values.shape[3] == 3
            place = target.matrix, target.first, name
            kind = {"vector_type": "contravariant relative"} if vector else {}
            grids.append(vdblic.Grid(values if vector else values[..., 0], mask, *place, kind))
        vdblic.write(path, grids, self._metadata(step, series))

    def _choose(self, series):
        """The arrays of the velocity and the grid, by the first step."""
        from .resample import Flow
        from .target import filling, like

        options, source = self._options, series.take_first()
        arrays = source.arrays(0)
        try:
            self._names, guessed = chosen(arrays, options.array, source.velocity(0), source.path)
        except InputError:
            self._tell_notes(source)
            raise
        if guessed:
            self._tell(f"the velocity is {self._names[0]}; --array chooses another of {contents(arrays)}")
        if len(self._names) == 2:
            self._tell(
                f"the vertical velocity is 0: {' and '.join(self._names)} have no third component; --array chooses"
                " others"
            )
        if options.like:
            target = like(options.like)
        else:
            flow = Flow(*source.parts(0, self._names, self._names)[0], source.path)
            if options.size or options.voxel_size or options.bounds:
                size = options.size or (None if options.voxel_size else flow.usual_target().size)
                target = filling(options.bounds or flow.bounds(), size, options.voxel_size)
            else:
                target = flow.usual_target()
        target.check()
        self._tell(f"{target}")
        return target

    def _covering(self, flow, step):
        """The voxels of a step: the first one's, and more of them where the flow reaches beyond its box."""
        if self._options.like or self._options.bounds:
            return self._target
        target = flow.covered(self._target)
        if target.size != self._target.size:
            try:
                target.check()
            except ParameterError as error:
                raise ParameterError(f"{step.source.path}: frame {step.frame}: {error}, or a box with --bounds") from None
            if not self._grown:
                self._console.say(
                    f"{step.source.path}: frame {step.frame} reaches beyond the box of the first step; such frames get "
                    "more of the same voxels; --bounds gives all frames one box"
                )
            self._grown = True
        return target

    def _check_cells(self, met):
        """Warn once if the voxels that nobody chose pass over most of the cells."""
        options = self._options
        are_chosen = options.like or options.size or options.voxel_size or options.bounds
        if met < 0.5 and not are_chosen and not self._coarse:
            self._coarse = True
            self._console.warn(
                f"only {100 * met:.0f} % of the cells have a voxel in them, because they differ in size or are turned "
                "against the axes; --size or --voxel-size makes voxels finer"
            )

    def _tell_once(self, velocity, mask, step):
        """A line by which a person can check the import: size, mean flow, first date, and which way is up."""
        source = step.source
        import numpy
        from .readers.times import date_of

        if self._summed or not mask.any():
            return
        self._summed = True
        size = self._target.spacing * self._target.size
        unit, scale = ("km", 1000) if source.unit == "m" and size.max() >= 10000 else (source.unit or "units", 1)
        mean = velocity[mask].astype(float).mean(axis=0)
        speed = numpy.linalg.norm(velocity[mask].astype(float), axis=1).mean()
        bearing = numpy.degrees(numpy.arctan2(mean[1], mean[0]))
        start = "no time" if step.time is None else f"from {step.time:g} s on"
        start = date_of(source.times[0], source.calendar) if source.calendar else start
        self._tell(
            f"{' x '.join(f'{length / scale:.4g}' for length in size)} {unit}; the mean flow is "
            f"({', '.join(f'{value:.3g}' for value in mean)}), {bearing:.0f} degrees from x towards y, with a mean "
            f"speed "
            f"of {speed:.3g} {source.unit or 'units'}/s; {start}; z is up"
        )

    def _tell_notes(self, source):
        for note in source.notes():
            self._tell(note)

    def _tell(self, message):
        """Say something once."""
        if message not in self._told:
            self._told.add(message)
            self._console.say(message)

    def _metadata(self, step, series):
        found = {
            "source": " ".join(map(str, step.source.paths)),
            "frame": step.frame,
            "velocity_array": ",".join(self._names),
            "velocity_unit": "world/s",
        }
        if step.source.unit:
            found["length_unit"] = step.source.unit
        if step.time is not None:
            found["time"] = float(step.time)
        else:
            self._tell("the files have no times; --dt gives their spacing, else vdblic_advect takes 1/24 s")
        if step.dt is not None:
            found["dt"] = float(step.dt)
        if series.start is not None and not self._options.dt:
            from .readers.times import date_of

            found["start"] = date_of(series.start, series.calendar)
        return found
