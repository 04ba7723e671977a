"""A check of .vdb files before OpenVDB reads them: on a truncated file OpenVDB may hang or take any amount of memory."""

import os
import struct

from .errors import InputError

MAGIC = 0x56444220
LONGEST = 1 << 20  # bytes of a name or of a metadata value


def check_header(path):
    """Raise InputError if a file is no .vdb file, or if its grids do not lie within it."""
    if not os.path.isfile(path):
        raise InputError(f"{path}: no such file")
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        try:
            _check(_Reader(file), size)
        except ValueError as error:
            raise InputError(f"{path}: cannot be read as a .vdb file: {error}") from None


def _check(reader, size):
    if reader.number("<q") != MAGIC:
        raise ValueError("it is of another kind")
    reader.skip(4 * 3 + 1 + 36)  # versions, a flag, the identifier
    for _ in range(reader.number("<I")):
        reader.skip_text()  # name
        reader.skip_text()  # type
        reader.skip_text()  # value
    for _ in range(reader.number("<i")):
        for _ in range(3):  # name, type, parent
            reader.skip_text()
        grid, blocks, end = (reader.number("<q") for _ in range(3))
        if not 0 < grid <= blocks <= end <= size:
            raise ValueError(f"it ends too early: a grid ends at byte {end} of {size}")
        reader.go_to(end)


class _Reader:
    def __init__(self, file):
        self._file = file

    def number(self, kind):
        count = struct.calcsize(kind)
        data = self._file.read(count)
        if len(data) < count:
            raise ValueError("it ends in its header")
        return struct.unpack(kind, data)[0]

    def skip(self, count):
        if count > LONGEST or len(self._file.read(count)) < count:
            raise ValueError("it ends in its header")

    def skip_text(self):
        self.skip(self.number("<I"))

    def go_to(self, place):
        self._file.seek(place)
