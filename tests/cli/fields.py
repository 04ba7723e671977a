"""The numbers of a file that tell how to read the rest, as (what, where, form of struct); and other numbers in their places."""

import re
import struct

import vdb_bytes


def fields_of(data):
    """Lengths, counts, offsets and kinds in a .vdb, NetCDF, HDF5, .npy or .npz file."""
    formats = {b" BDV": _vdb, b"CDF": _netcdf, b"\x89HDF": _hdf, b"\x93NUM": _numpy, b"PK": _zip}
    return next(find for magic, find in formats.items() if data.startswith(magic))(data)


def misplaced(data, choice):
    """A file with another number in one such place. @param choice  a random.Random"""
    fields = fields_of(data)
    what, at, form = choice.choice(fields)
    if form == "text":
        end = re.compile(rb"\d+").match(data, at).end()
        return what, data[:at] + choice.choice([b"0", b"-1", b"7", b"1e3", b"99999999999", b"2147483648", b"True"]) + data[end:]
    size = struct.calcsize(form)
    order = "big" if form[0] == ">" else "little"
    old = int.from_bytes(data[at:at + size], order)
    other = choice.choice(fields)[1]
    value = choice.choice([0, 1, old + 1, old - 1, 2 * old, old ^ 1 << choice.randrange(8 * size), -1, 1 << 8 * size - 1,
                           (1 << 8 * size - 1) - 1, 1 << 20, 1 << 31, len(data), len(data) + 1,
                           int.from_bytes(data[other:other + size], order)])
    return what, data[:at] + (value % (1 << 8 * size)).to_bytes(size, order) + data[at + size:]


def _vdb(data):
    return vdb_bytes.Walk(data).fields


class _Cursor:
    def __init__(self, data):
        self.data, self.at, self.fields = data, 0, []

    def number(self, what, form):
        self.fields.append((what, self.at, form))
        value, = struct.unpack_from(form, self.data, self.at)
        self.at += struct.calcsize(form)
        return value

    def pass_over(self, size):
        self.at += -(-size // 4) * 4


def _netcdf(data):
    """A header of the classic formats (the user's guide of NetCDF, appendix B)."""
    cursor = _Cursor(data)
    cursor.at = 3
    version = cursor.number("version", ">B")
    count, place = (">Q" if version == 5 else ">I"), (">I" if version == 1 else ">Q")
    sizes = {1: 1, 2: 1, 3: 2, 4: 4, 5: 4, 6: 8}

    def entries(read):
        cursor.number("tag", ">I")
        for _ in range(cursor.number("count", count)):
            cursor.pass_over(cursor.number("length of a name", count))
            read()

    def attribute():
        kind = cursor.number("type", ">I")
        cursor.pass_over(cursor.number("length", count) * sizes[kind])

    def variable():
        for _ in range(cursor.number("count of dimensions", count)):
            cursor.number("dimension", count)
        entries(attribute)
        for what, form in ("type", ">I"), ("size", count), ("offset", place):
            cursor.number(what, form)

    cursor.number("records", count)
    entries(lambda: cursor.number("length of a dimension", count))
    entries(attribute)
    entries(variable)
    return cursor.fields


def _hdf(data):
    """What follows the signatures of HDF5's structures: versions, sizes, flags, counts and addresses."""
    fields = [("superblock", 8 + i, "<B") for i in range(16)] + [("superblock", 12 + 8 * i, "<Q") for i in range(5)]
    for match in re.finditer(rb"OHDR|OCHK|FRHP|FHDB|FHIB|BTHD|BTLF|BTIN|TREE|HEAP|SNOD|GCOL|FSHD|FSSE|SMTB|SMLI|FAHD|EAHD", data):
        name = match[0].decode()
        for i in range(40):
            fields.append((name, match.end() + i, "<B"))
        for i in range(0, 40, 2):
            fields += [(name, match.end() + i, form) for form in ("<H", "<I", "<Q")]
    return [field for field in fields if field[1] + 8 <= len(data)]


def _numpy(data):
    fields = [("version", 6, "<B"), ("version", 7, "<B"), ("length of the header", 8, "<H")]
    return fields + [("a number in the header", match.start(), "text") for match in re.finditer(rb"\d+", data[:data.find(b"\n")])]


def _zip(data):
    """Versions, flags, sizes, counts and offsets of a .zip file, and of the arrays in it."""
    fields = []
    for signature, forms in (b"PK\3\4", "HHHHHIIIHH"), (b"PK\1\2", "HHHHHHIIIHHHHHII"), (b"PK\5\6", "HHHHIIH"):
        for match in re.finditer(re.escape(signature), data):
            at = match.end()
            for form in forms:
                fields.append((f"zip {signature[2]}", at, "<" + form))
                at += struct.calcsize(form)
    for match in re.finditer(b"\x93NUMPY", data):
        end = data.find(b"\n", match.start())
        fields += [(what, match.start() + at, form) for what, at, form in _numpy(data[match.start():end + 1])]
    return [field for field in fields if field[1] + 8 <= len(data)]
