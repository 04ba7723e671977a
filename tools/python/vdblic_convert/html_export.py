"""vdblic_export of streaks into a page for browsers."""

import argparse
import re

from vdblic._core import FramePattern, check_output, read_lines, solid_mesh, write_file

from .console import printable
from .errors import InputError, ParameterError
from .outputs import check_not_inputs, frames_of, is_whole


def size(text):
    """A number of bytes, for options: 25M."""
    match = re.fullmatch(r"(\d{1,9})([kMG]?)", text)
    if not match or not int(match[1]):
        raise argparse.ArgumentTypeError(f"'{text[:60]}' is no size such as 25M: a number of bytes, or of k, M or G")
    return int(match[1]) * 1000.0 ** "kMG".find(match[2]) * 1000 if match[2] else float(match[1])


def add_page_options(tool):
    tool.add("--max-size", metavar="SIZE", type=size,
             help="Of an .html: its largest size, 25M by default; a page that would be larger leaves lines out.")  # fmt: skip
    tool.add("--solid", metavar="FILE[:GRID] or domain",
             help="Of an .html: opaque body, as of vdblic_render; a page shows that of the first frame.")  # fmt: skip


def refuse_page_options(options):
    """Raise ParameterError if an option of pages is given for other files."""
    for name in "max_size", "solid":
        if getattr(options, name) is not None:
            raise ParameterError(f"`{name}` is of a page; write one with -o flow.html, or leave it out")


def export_page(options, console, stop):
    from vdblic.pages import gathered, page  # NumPy takes long to load
    from vdblic.volumes import read

    if options.grids or options.levels:
        raise ParameterError("a page has the lines with all their scalars; leave --grids and --levels out")
    output = FramePattern(options.output)
    if output.has_field:
        raise ParameterError(f"{options.output}: one page shows all frames; leave its frame field out")
    path = output.path(0)
    check_output(path)
    found = sorted(frames_of(options, stop, lambda frames, sources: check_not_inputs([path], sources)))
    check_not_inputs([path], [source for _, source in found])
    if not (options.skip_existing and is_whole(path, console)):
        paths, frames, first = gathered(_read(found, console, stop))
        if not paths.radius:
            raise InputError(f"{found[0][1]}: no line in any frame; there is nothing to show")
        solid = _solid(options.solid, found, console)
        title = printable(str(first.get("title", path.stem)))
        size = {"most": options.max_size} if options.max_size else {}
        shown = read(found[len(found) // 2][1])
        write_file(path, page(paths.finish(), title, frames, first, shown, console.say, solid=solid, **size))
    console.finished(path)


def _solid(source, found, console):
    """A solid of the first frame's file, as a page takes it."""
    if source is None:
        return None
    (frame, path), *others = found
    points, triangles, changes = solid_mesh(source, path, frame)
    if not len(triangles):
        raise InputError(f"{path}: `solid` {printable(source)} has no surface; leave it out, or choose another")
    if source == "domain":  # compared with two other frames only: the solid of a domain takes long to make
        others = [solid_mesh(source, path, frame)[0] for frame, path in {*others[len(others) // 2 :][:1], *others[-1:]}]
        changes = any(other.shape != points.shape or (other != points).any() for other in others)
    if changes:
        console.say(f"the page shows the solid of frame {frame}, at all times")
    return source, points, triangles


def _read(found, console, stop):
    for done, (frame, source) in enumerate(found, 1):
        stop.check()
        lines, metadata = read_lines(source)
        yield frame, lines, metadata
        console.progress(frame, done, len(found))
