"""USD's text form: values, attributes and prims as lines of a layer (.usda). No USD library is needed."""

import os
import re

from .errors import InputError


def number(value):
    """A number; a whole one without a point."""
    value = float(value)
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def tuple_of(values):
    return f"({', '.join(map(number, values))})"


def matrix(rows):
    return f"({', '.join(map(tuple_of, rows))})"


def text(value):
    """A text; control characters, and bytes of a file that are no UTF-8, as their hexadecimal escapes."""
    escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{re.sub(_UNSAFE, lambda match: _hexadecimal(match[0]), escaped)}"'


_UNSAFE = "[\x00-\x1f\x7f-\x9f\u2028\u2029\udc80-\udcff]"


def _hexadecimal(character):
    return "".join(f"\\x{byte:02x}" for byte in character.encode("utf-8", "surrogateescape"))


def asset(path, layer):
    """A file as it is found from the folder of a layer, so that both can be moved together. Raises InputError."""
    relative = os.path.relpath(os.path.abspath(path), os.path.dirname(os.path.abspath(layer)))
    if not relative.isprintable():
        raise InputError(
            f"{path!r}: a name of control characters, or of bytes that are no UTF-8, cannot be written into a layer;"
            " rename the file"
        )
    anchored = relative if relative.startswith("../") else f"./{relative}"
    mark = "@@@" if "@" in anchored else "@"
    return f"{mark}{anchored.replace('@@@', chr(92) + '@@@')}{mark}"


def identifier(name, taken):
    """A new name for a prim, added to the names `taken`."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    plain = plain if re.match(r"[A-Za-z_]", plain) else f"_{plain}"
    result, count = plain, 1
    while result in taken:
        count += 1
        result = f"{plain}_{count}"
    taken.add(result)
    return result


def attribute(declaration, value):
    return [f"{declaration} = {value}"]


def samples(declaration, values):
    """An attribute with a value at each time code; a constant is written once."""
    values = dict(values)
    if len(set(values.values())) == 1:
        return attribute(declaration, next(iter(values.values())))
    lines = [f"    {number(time)}: {value}," for time, value in sorted(values.items())]
    return [f"{declaration}.timeSamples = {{", *lines, "}"]


def prim(kind, name, lines, metadata=()):
    """A prim with its attributes and children, which are lines themselves."""
    head = f"def {kind} {text(name)}"
    opening = [f"{head} (", *(f"    {line}" for line in metadata), ")", "{"] if metadata else [head, "{"]
    return [*opening, *(f"    {line}" if line else "" for line in lines), "}"]
