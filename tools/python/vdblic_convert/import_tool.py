"""vdblic_import: flows of other programs into velocity sequences."""

import os
import re
import warnings

from vdblic._core import Parsing

from .errors import InputError, ParameterError
from .outputs import Outputs
from .tool import Tool, number, positive, whole
from .velocity import check_carried, chosen, contents, names_of


def main(version, words):
    tool = Tool("vdblic_import", version,
                "Convert the flows of other programs into velocity volumes: files of VTK (.vti .vtr .vts .vtu .vtm .vtk "
                ".pvd), cases of OpenFOAM, EnSight and CGNS, NetCDF (CF, WRF, ROMS, FVCOM, MPAS, UGRID), Zarr, GRIB, "
                "arrays (.npz .npy .h5 .mat).")  # fmt: skip
    add, box = tool.add, ("X0", "Y0", "Z0", "X1", "Y1", "Z1")
    add("input", nargs="+", metavar="INPUT",
        help="Flow. One file, a case's folder, a pattern (name.%%04d.vti, also ####, @@@@, $F4, <F4>), or - for paths "
        "on standard input. Several are one flow, with the same times.")  # fmt: skip
    add("-o", "--output", metavar="TEXT", required=True, help="Velocity files, such as v.%%04d.vdb.")
    tool.sequence("the steps of files that hold several, and paths on standard input,",
                  " The steps of a file with several count from 1.")  # fmt: skip
    add("--times", metavar=("T0", "T1"), nargs=2, type=number,
        help="Use the steps from time T0 to time T1 only [seconds].")  # fmt: skip
    add("--array", metavar="TEXT",
        help="Array that is the velocity, or two or three that are its components: U or u,v,w.")  # fmt: skip
    add("--carry", metavar="TEXT", help="Further arrays to convert: NAME,NAME.")
    add("--attribute", metavar="TEXT", nargs="+",
        help="What a file of NetCDF, Zarr or GRIB does not say, as if it did: NAME:ATTRIBUTE=VALUE ..., such as "
        "depth:positive=down u:units=cm/s v:standard_name=northward_wind.")  # fmt: skip
    add("--layout", metavar="TEXT",
        help="Order of the axes of arrays (.npy .npz .h5 .mat): letters of t (time), c (component), x, y and z, such as "
        "cxyz or tczyx. Files in the form of vdblic_export need none.")  # fmt: skip
    add("--explain", action="store_true",
        help="Tell how each coordinate and component of the first step is understood, with two values and units.")  # fmt: skip
    add("--like", metavar="TEXT", help="Resample to the voxels of a .vdb grid: FILE or FILE:GRID.")
    add("--size", metavar=("X", "Y", "Z"), nargs=3, type=whole(1, 131072),
        help="Resample to so many voxels along x, y and z.")  # fmt: skip
    add("--voxel-size", metavar="FLOAT", nargs="+", type=positive,
        help="Resample to voxels of this size, or of three sizes along x, y and z [world].")  # fmt: skip
    add("--bounds", metavar=box, nargs=6, type=number,
        help="Box that the voxels fill [world]; all of the flow by default.")  # fmt: skip
    add("--globe", action="store_true",
        help="Make a shell around the Earth of longitude, latitude and height: Cartesian voxels, in units of 1000 km, x to "
        "0 degrees east on the equator, z to the north pole. --voxel-size is one length; by default the data's spacing on "
        "the equator.")  # fmt: skip
    add("--exaggerate", metavar="FLOAT", type=positive,
        help="Factor on the heights of --globe; by default the shell is a twentieth to a tenth of the Earth's radius.")  # fmt: skip
    add("--dt", metavar="FLOAT", type=positive,
        help="Seconds from one frame number to the next, in place of the files' times.")  # fmt: skip
    return tool.run(words, run)


def run(options, console, stop):
    """Convert every selected step."""
    _check(options)
    warnings.simplefilter("ignore")  # warnings of packages are for programmers
    from .series import Series  # slow imports wait until the options are valid

    if options.globe:
        from .globe import GRIDS, Globe

        for name in sorted(set(GRIDS).intersection(options.carry)):
            raise ParameterError(f"--carry {name}: --globe writes a grid of that name; rename the array")
        options.globe = Globe(options.exaggerate, options.voxel_size and options.voxel_size[0])
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
    low, high = (options.bounds or ())[:3], (options.bounds or ())[3:]
    times = options.times or (0, 0)
    order = r"(?=.*x)(?!.*(.).*\1)[tcxyz]{2,5}"
    for wrong, message in (
        (options.layout and not re.fullmatch(order, options.layout),
         "--layout is letters of t, c, x, y and z, each once, such as cxyz"),
        (options.voxel_size and len(options.voxel_size) not in (1, 3), "--voxel-size takes one number or three"),
        (options.like and (options.size or options.voxel_size or options.bounds),
         "--like gives size, voxels and bounds; leave out --size, --voxel-size and --bounds"),
        (options.size and options.voxel_size, "--size and --voxel-size exclude each other"),
        (not all(a < b for a, b in zip(low, high)),
         "--bounds is an empty box; it takes X0 Y0 Z0 X1 Y1 Z1, the second corner above the first"),
        (options.globe and (options.like or options.size or options.bounds),
         "--globe makes voxels of its own; leave out --like, --size and --bounds"),
        (options.globe and len(options.voxel_size or [1]) > 1, "--voxel-size takes one number with --globe"),
        (options.exaggerate and not options.globe, "--exaggerate is for --globe"),
        (times[0] > times[1], f"--times {times[0]:g} {times[1]:g} runs backwards"),
    ):  # fmt: skip
        if wrong:
            raise ParameterError(message)


def _answers(words):
    """Attributes by variable: NAME:ATTRIBUTE=VALUE. Raises ParameterError."""
    answers = {}
    for word in words:
        match = re.fullmatch(r"([^=]+):(\w+)=(.*)", word)
        if not match:
            raise ParameterError(f"--attribute '{word[:60]}' is not NAME:ATTRIBUTE=VALUE, such as depth:positive=down")
        answers.setdefault(match[1], {})[match[2].lower()] = match[3]
    return answers


def _date(seconds, calendar):
    from .readers.times import date_of  # which needs cftime

    return date_of(seconds, calendar)


class Conversion:
    """Resamples steps to one grid, which the first step of the whole series chooses."""

    def __init__(self, options, console):
        self._options, self._console = options, console
        self._names, self._target, self._told, self._done = (), None, set(), set()

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
        if self._options.globe:
            self._write_globe(step, series, path, where)
            return
        with Parsing(source.path, "the library that reads it", False):
            velocity, carried, mask, met, target = flow_at(
                source, step.index, self._names, self._options.carry, lambda flow: self._covering(flow, step), where
            )
        self._check_cells(met)
        self._tell_of(source)
        if not mask.any():
            self._console.warn(f"{source.path}: frame {step.frame} has no values within the voxels")
        if mask.any() and self._first("summed"):
            self._tell(self._summary(velocity[mask].astype(float), step))
        grids = []
        for name, values in [("velocity", velocity), *carried.items()]:
            vector = values.shape[3] == 3
            place = target.matrix, target.first, name
            kind = {"vector_type": "contravariant relative"} if vector else {}
            grids.append(vdblic.Grid(values if vector else values[..., 0], mask, *place, kind))
        vdblic.write(path, grids, self._metadata(step, series))

    def _write_globe(self, step, series, path, where):
        import vdblic

        source, options = step.source, self._options
        with Parsing(source.path, "the library that reads it", False):
            arrays, box, told = options.globe.grids(source, step.index, self._names, options.carry, where)
        self._tell_of(source)
        if not told:
            self._console.warn(f"{source.path}: frame {step.frame} has no values within the voxels")
        elif self._first("summed"):
            self._tell(told)
        grids = []
        for name, (values, active, told) in arrays.items():
            grids.append(vdblic.Grid(values, active, box.matrix, box.first, name, told))
        vdblic.write(path, grids, self._metadata(step, series) | options.globe.metadata())

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
        if options.globe:
            with Parsing(source.path, "the library that reads it", False):
                self._tell(options.globe.choose(source, self._names))
            return options.globe
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
            where = f"{step.source.path}: frame {step.frame}"
            try:
                target.check()
            except ParameterError as error:
                raise ParameterError(f"{where}: {error}, or a box with --bounds") from None
            if self._first("grown"):
                self._console.say(
                    f"{where} reaches beyond the box of the first step; such frames get more of the same voxels; "
                    "--bounds gives all frames one box"
                )
        return target

    def _check_cells(self, met):
        """Warn once if the default voxels miss most of the cells."""
        options = self._options
        are_chosen = options.like or options.size or options.voxel_size or options.bounds
        if met < 0.5 and not are_chosen and self._first("coarse"):
            self._console.warn(
                f"only {100 * met:.0f} % of the cells have a voxel in them, because they differ in size or are turned "
                "against the axes; --size or --voxel-size makes voxels finer"
            )

    def _summary(self, flow, step):
        """A line by which a person can check the import: size, mean flow, first date, and which way is up."""
        import numpy

        source, size = step.source, self._target.spacing * self._target.size
        unit, scale = ("km", 1000) if source.unit == "m" and size.max() >= 10000 else (source.unit or "units", 1)
        mean, speed = flow.mean(axis=0), numpy.linalg.norm(flow, axis=1).mean()
        bearing = numpy.degrees(numpy.arctan2(mean[1], mean[0]))
        start = "no time" if step.time is None else f"from {step.time:g} s on"
        start = _date(source.times[0], source.calendar) if source.calendar else start
        return (
            f"{' x '.join(f'{length / scale:.4g}' for length in size)} {unit}; the mean flow is "
            f"({', '.join(f'{value:.3g}' for value in mean)}), {bearing:.0f} degrees from x towards y, with a mean "
            f"speed of {speed:.3g} {source.unit or 'units'}/s; {start}; z is up"
        )

    def _tell_of(self, source):
        self._tell_notes(source)
        for text in source.explained.values() if self._options.explain and self._first("explained") else ():
            self._console.say(text)

    def _tell_notes(self, source):
        for note in source.notes():
            self._tell(note)

    def _tell(self, message):
        """Say something once."""
        if message not in self._told:
            self._told.add(message)
            self._console.say(message)

    def _first(self, what):
        """Whether this is the first time that something happens."""
        known, self._done = what in self._done, self._done | {what}
        return not known

    def _metadata(self, step, series):
        if step.time is None:
            self._tell("the files have no times; --dt gives their spacing, else vdblic_advect takes 1/24 s")
        start = _date(series.start, series.calendar) if series.start is not None and not self._options.dt else None
        found = {
            "source": " ".join(map(str, step.source.paths)), "frame": step.frame, "velocity_unit": "world/s",
            "velocity_array": ",".join(self._names), "length_unit": step.source.unit, "start": start,
            "time": None if step.time is None else float(step.time), "dt": None if step.dt is None else float(step.dt),
        }  # fmt: skip
        return {name: value for name, value in found.items() if value is not None}
