"""vdblic_export into USD: one layer that names the files of a whole sequence."""

from vdblic._core import LINES, CameraFile, FramePattern, check_output, read_headers, write_file

from .errors import InputError, ParameterError
from .levels import Levels
from .outputs import check_not_inputs, frames_of, is_whole
from .tool import positive
from .velocity import names_of

_OPTIONS = {"camera": "--camera", "stretch": "--stretch", "fps": "--fps", "up": "--up", "meters": "--meters-per-unit"}


def add_options(tool):
    """The options that only layers have."""
    tool.add("--camera", metavar="FILE", help="Of a .usda: camera of a file of key frames, as vdblic_render takes it.")
    tool.add("--stretch", metavar=("X", "Y", "Z"), nargs=3, type=positive,
             help="Of a .usda: factors on the world's axes; the camera is in the stretched space.")  # fmt: skip
    tool.add("--fps", metavar="FLOAT", type=positive,
             help="Of a .usda: time codes in a second; by default 1 / dt of the files, where that is 10 to 120, else "
             "24.")  # fmt: skip
    tool.add("--up", metavar="AXIS", choices=("y", "z"),
             help="Of a .usda: y or z; by default y where the velocity is Houdini's, else z.")  # fmt: skip
    tool.add("--meters-per-unit", dest="meters", metavar="FLOAT", type=positive,
             help="Of a .usda: metres in a unit of the world; by default by the files' length_unit, else 1.")  # fmt: skip


def refuse_options(options):
    """Raise ParameterError if an option of layers is given for other files."""
    for name, option in _OPTIONS.items():
        if getattr(options, name) is not None:
            raise ParameterError(f"{option} is of a layer; write one with -o flow.usda, or leave it out")


def export_layer(options, console, stop, version):
    from .usd_curves import curves
    from .usd_layer import Frame, gaps_of, layer, settings_of  # NumPy loads slowly

    names = names_of(options.grids) if options.grids else ()
    output = FramePattern(options.output)
    if output.has_field:
        raise ParameterError(f"{options.output}: one layer names the files of all frames; leave its frame field out")
    path = output.path(0)
    check_output(path)
    camera = CameraFile(options.camera) if options.camera else None
    found = list(frames_of(options, stop, lambda frames, paths: None))
    numbers, sources = zip(*found)
    check_not_inputs([path], sources)
    coarse = None
    if options.levels:  # beside the layer, without the level in their pattern
        name = path.with_suffix(".vdb") if len(found) == 1 else path.with_name(f"{path.stem}.%04d.vdb")
        coarse = Levels(str(name), options.levels, options.grids, options.skip_existing)
        coarse.check(numbers, sources)
    if not (options.skip_existing and is_whole(path, console)):
        frames, proxy, left_out = {}, {}, set()
        has_lines = LINES in names or not names and _has_lines(sources[0])
        for frame, source in found:
            stop.check()
            frames[frame] = Frame(str(source), *_grids(source, names, left_out, has_lines))
        if left_out:
            console.say(f"without {', '.join(sorted(left_out))}: grids of another kind, or without a name")
        for stays, first, last in gaps_of(frames):
            console.say(f"frames {first} to {last} are missing: frame {stays} stays until then")
        first, up = frames[min(frames)], options.up and options.up.upper()
        settings = settings_of(first, options.fps, options.meters, up, options.stretch)
        for i, (frame, source) in enumerate(found if coarse else ()):
            stop.check()
            made = coarse.write(frame, source, console)[-1]
            proxy[frame] = Frame(str(made), *_grids(made, names, left_out))
            console.progress(frame, i + 1, len(found))
        streaks = curves("streaks", dict(found), settings, stop) if has_lines else None
        text = layer(path, frames, settings, camera, f"A flow, by vdblic_export {version}", proxy, streaks)
        write_file(path, text.encode())
    console.finished(path)


def _has_lines(source):
    return any(grid["name"] == LINES and grid["type"].startswith("ptdata") for grid in read_headers(source)[0])


def _grids(source, names, left_out, has_lines=False):
    """The chosen grids of a file by name, and its metadata; without names none beside lines.

    Raises InputError if a named one is missing.
    """
    grids, metadata = read_headers(source)
    names = tuple(name for name in names if name != LINES)
    if has_lines and not names:
        return {}, metadata
    usable = {grid["name"]: grid for grid in reversed(grids) if grid["numbers"] and grid["name"]}
    left_out |= {f"'{grid['name']}'" for grid in grids if grid["name"] not in usable and not names}
    order = [grid["name"] for grid in grids if grid["name"] in usable]
    for name in names:
        if name not in usable:
            there = ", ".join(order) or "none"
            raise InputError(f"{source}: no grid '{name}' of numbers or vectors; present: {there}")
    if not usable:
        raise InputError(f"{source}: no grid of numbers or vectors with a name; there is nothing to show")
    return {name: usable[name] for name in names or dict.fromkeys(order)}, metadata
