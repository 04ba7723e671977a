"""Whether the text files of an EnSight case are whole. VTK reads missing values as zeros, or repeats earlier ones."""

import re

from ..errors import InputError

COMPONENTS = {"scalar": 1, "vector": 3, "tensor symm": 6, "tensor asym": 9}
ELEMENTS = (
    rb"point|bar[23]|tria[36]|quad[48]|tetra4|tetra10|pyramid5|pyramid13|penta6|penta15|hexa8|hexa20|nsided|nfaced"
)
HEAD = re.compile(rb"^[ \t]*(part|coordinates|block|(?:g_)?(?:" + ELEMENTS + rb"))\b([^\n]*)(?:\n|$)", re.MULTILINE)


class Case:
    """The files of a case, by its case file."""

    def __init__(self, path):
        entries = _entries(path)
        self._folder, self._files = path.parent, []  # components, place (geometry, node, element), file name, time set
        self._gold = any(key == "type" and "gold" in value for section, key, value in entries if section == "FORMAT")
        self._in_one_file = any(section == "FILE" for section, *_ in entries)
        self._sets = dict(_time_sets([entry[1:] for entry in entries if entry[0] == "TIME"]))
        for section, key, value in entries:
            kind, _, place = key.partition(" per ")
            words = [word for word in value.split() if word != "change_coords_only"]
            numbers = [word for word in words[:-1] if word.isdigit()]  # the first is the time set
            name_and_set = words[-1] if words else "", numbers[0] if numbers else None
            if section == "GEOMETRY" and key == "model":
                self._files.append((None, "geometry", *name_and_set))
            elif section == "VARIABLE" and kind in COMPONENTS and place in ("node", "element"):
                self._files.append((COMPONENTS[kind], place, *name_and_set))

    def check(self, time):
        """Raise InputError if a file of a time, None for all times, ends too early."""
        if self._in_one_file:
            return  # VTK itself looks for the end of each step
        sizes = None
        for components, place, name, time_set in self._files:
            path = self._folder / self._numbered(name, time_set, time)
            if not path.is_file():
                continue  # VTK reports it
            text = path.read_bytes()
            if place == "geometry":
                if b"binary" in text[:80].lower():
                    return
                sizes = _check_geometry(path, text, self._gold)
            elif sizes is not None:
                _check_values(path, text, self._gold, sizes, components, place)

    def _numbered(self, name, time_set, time):
        """The name of the file that holds a time."""
        stars = re.search(r"\*+", name)
        if not stars:
            return name
        times, numbers = self._sets.get(time_set) or next(iter(self._sets.values()), ([], []))
        step = max((i for i, other in enumerate(times) if time is None or other <= time), default=0)
        number = numbers[step] if step < len(numbers) else 0
        return f"{name[:stars.start()]}{number:0{len(stars[0])}}{name[stars.end():]}"


def _entries(path):
    """The lines of a case file: section, key and value. A value may go on in the next lines."""
    entries, section = [], ""
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        line = line.strip()
        if re.fullmatch("[A-Z]+", line):
            section = line
        elif re.match("[a-z][a-z ]*:", line):
            key, _, value = line.partition(":")
            entries.append([section, " ".join(key.split()), value.strip()])
        elif entries and line and not line.startswith("#"):
            entries[-1][2] += " " + line
    return entries


def _time_sets(entries):
    """The name of each time set, its times, and the numbers of their files."""
    begins = [i for i, (key, _) in enumerate(entries) if key == "time set"]
    for begin, end in zip(begins, [*begins[1:], len(entries)]):
        found = {key: value.split() for key, value in entries[begin:end]}
        times = [float(word) for word in found.get("time values", [])]
        start, step = (int(found.get(f"filename {key}", ["1"])[0]) for key in ("start number", "increment"))
        numbers = [int(word) for word in found.get("filename numbers", [])]
        yield found["time set"][0], (times, numbers or [start + i * step for i in range(len(times))])


def _sections(path, text, gold, begin, described):
    """The sections of a file: part, keyword, rest of the keyword's line, and the text up to the next section."""
    heads, place, part = [], begin, None
    while head := HEAD.search(text, place):
        place, keyword, rest = head.end(), head[1].removeprefix(b"g_").decode(), head[2]
        if keyword == "part":
            if gold:
                rest, place = _line(text, place)
            part = rest.strip()
            place = _line(text, place)[1] if described else place
        heads.append((part, keyword, rest, head.start(), place))
    if not heads or heads[-1][1] == "part":
        what = f"{_named(heads[-1][0])} is empty" if heads else "there is no part"
        raise InputError(f"{path}: it ends too early: {what}; copy it again")
    ends = [head[3] for head in heads[1:]] + [len(text)]
    return [(*head[:3], text[head[4] : end]) for head, end in zip(heads, ends) if head[1] != "part"]


def _line(text, begin):
    """A line, and where the next one begins."""
    end = text.find(b"\n", begin)
    return (text[begin:end], end + 1) if end >= 0 else (text[begin:], len(text))


def _check_geometry(path, text, gold):
    """How many values there are of each section, for nodes and for elements: (part, keyword) → number."""
    place, header = 0, []
    for _ in range(4):
        line, place = _line(text, place)
        header.append(line.split()[-1:])
    # Numbers of nodes and of elements stand in lines of their own.
    ids = [gold and line in ([b"given"], [b"ignore"]) for line in header[2:]]
    sizes = {}
    for part, keyword, rest, values in _sections(path, text, gold, place, True):
        try:
            counts = [int(word) for word in _line(values, 0)[0].split()]
            nodes = counts[0] * counts[1] * counts[2] if keyword == "block" else counts[0]
        except (ValueError, IndexError):
            what = f"'{keyword}' of {_named(part)} lacks its size"
            raise InputError(f"{path}: it ends too early: {what}; copy it again") from None
        sizes[part, keyword] = nodes
        if keyword == "block":
            cells = max(counts[0] - 1, 1) * max(counts[1] - 1, 1) * max(counts[2] - 1, 1)
            sizes[part, "cells"] = cells
            lines = 3 * nodes if gold else 3 * (-(-nodes // 6))
            lines = 6 if b"uniform" in rest else sum(counts[:3]) if b"rectilinear" in rest else lines
            lines += ids[0] * nodes + ids[1] * cells
        elif keyword == "coordinates":
            lines = (3 if gold else 1) * nodes + ids[0] * nodes
        else:
            lines = (1 + (keyword in ("nsided", "nfaced")) + ids[1]) * nodes
        _expect(path, part, keyword, _lines(values) - 1, lines, "lines")
        corners = re.search(r"\d+$", keyword)
        if corners and nodes:
            last = values.rstrip().rpartition(b"\n")[2].split()
            _expect(path, part, f"last line of {keyword}", len(last), int(corners[0]), "nodes")
    return sizes


def _check_values(path, text, gold, sizes, components, place):
    _, begin = _line(text, 0)
    if not gold and place == "node":  # the values of all nodes come first
        head = HEAD.search(text, begin)
        sections = [(None, "coordinates", b"", text[begin : head.start() if head else len(text)])]
        sections += _sections(path, text, gold, head.start(), False) if head else []
    else:
        sections = _sections(path, text, gold, begin, False)
    for part, keyword, rest, values in sections:
        size = sizes.get((part, "cells" if keyword == "block" and place == "element" else keyword))
        if size is None or b"partial" in rest:
            continue
        found = _lines(values) if gold else -(-(len(values) - values.count(b"\n") - values.count(b"\r")) // 12)
        _expect(path, part, keyword, found, components * size, "values")


def _lines(text):
    """The number of lines; the last one may lack its end."""
    return text.count(b"\n") + (text.rpartition(b"\n")[2].strip() != b"")


def _expect(path, part, keyword, found, needed, what):
    if found < needed:
        raise InputError(
            f"{path}: it ends too early: '{keyword}' of {_named(part)} has {found} of {needed} {what}; copy it again"
        )


def _named(part):
    return f"part {part.decode(errors='replace')}" if part else "all parts"
