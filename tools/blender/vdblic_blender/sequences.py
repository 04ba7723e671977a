"""The files of a numbered sequence, as Blender plays them."""

import dataclasses
import pathlib
import re


class SequenceError(ValueError):
    """A sequence that Blender cannot play; the message names the file and the mend."""


@dataclasses.dataclass
class FileSequence:
    """`files` in order of number; `first` is the number of the first, None where a single file has none."""

    files: list
    first: int

    @property
    def last(self):
        return None if self.first is None else self.first + len(self.files) - 1


def sequence_of(path):
    """All files of a file's sequence. Raises SequenceError."""
    path = pathlib.Path(path).absolute()
    if not path.is_file():
        raise SequenceError(f"{path}: no such file; choose one that is there")
    number = re.search(r"\d+$", path.stem)
    if path.suffix.lower() != ".vdb":
        raise SequenceError(f"{path}: not a .vdb file; choose one")
    if not number:
        return FileSequence([path], None)
    prefix = path.stem[: number.start()]
    digits = re.compile(re.escape(prefix) + r"(\d+)" + re.escape(path.suffix))
    matches = [
        (int(match[1]), match[1], file) for file in path.parent.iterdir() if (match := digits.fullmatch(file.name))
    ]
    found = {frame: file for frame, _, file in matches}
    widths = {len(text) for _, text, _ in matches if text.startswith("0") and len(text) > 1}
    where = f"{path.parent / prefix}*.vdb"
    if (
        len(found) < len(matches)
        or len(widths) > 1
        or widths
        and any(len(text) < max(widths) for _, text, _ in matches)
    ):
        raise SequenceError(
            f"{where}: numbers of different widths, which Blender does not join; give all the same width"
        )
    first, last = min(found), max(found)
    missing = next((frame for frame in range(first, last) if frame not in found), None)
    if missing is not None:
        raise SequenceError(
            f"{where}: frame {missing} is missing, and Blender plays only sequences without gaps; "
            "compute it, or number the files without gaps"
        )
    return FileSequence([found[frame] for frame in sorted(found)], first)


def pattern_of(path):
    """The pattern of a file's sequence, as our tools take it: lic.0001.vdb gives lic.%04d.vdb."""
    path = pathlib.Path(path)
    number = re.search(r"\d+$", path.stem)
    if not number:
        return str(path)
    field = f"%0{len(number[0])}d" if len(number[0]) > 1 else "%d"
    return str(path.with_name(f"{path.stem[:number.start()]}{field}{path.suffix}"))


def frames_of(pattern):
    """The numbers of the files of a pattern that are on disk, in order."""
    path = pathlib.Path(pattern)
    field = re.search(r"%0?(\d*)d", path.name)
    if not field:
        return [None] if path.is_file() else []
    form = re.compile(re.escape(path.name[: field.start()]) + r"(\d+)" + re.escape(path.name[field.end() :]))
    if not path.parent.is_dir():
        return []
    found = (form.fullmatch(file.name) for file in path.parent.iterdir())
    return sorted(int(match[1]) for match in found if match and path.name % int(match[1]) == match[0])
