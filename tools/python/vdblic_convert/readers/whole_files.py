"""Whether files are as long as their headers say. On truncated files libraries read zeros, or loop."""

import math
import os
import struct

from ..errors import InputError

HDF5 = b"\x89HDF\r\n\x1a\n"
ADF = b"ADF Database Version "  # of CGNS, after four bytes; then its version, such as A02011 or B02012
WIDTHS = {1: 1, 2: 1, 3: 2, 4: 4, 5: 4, 6: 8, 7: 1, 8: 2, 9: 4, 10: 8, 11: 8}  # bytes of a value of NetCDF's types
STREAMING = 0xFFFFFFFF, 0xFFFFFFFFFFFFFFFF  # numbers of records that are unknown


def check_whole(path):
    """Raise InputError if a file ends too early: classic NetCDF (CDF-1, -2 and -5), HDF5 or ADF.

    Returns the form's name; None for files of another form.
    """
    with open(path, "rb") as file:
        start = file.read(4 + len(ADF))
        form = next((name for name, (place, sign, _) in FORMS.items() if start.startswith(sign, place)), None)
        try:
            needed = FORMS[form][2](file) if form else 0
        except (struct.error, KeyError, IndexError, ValueError):
            raise InputError(f"{path}: cannot be read as {form}: its header ends too early or is damaged") from None
    size = os.path.getsize(path)
    if size < needed:
        raise InputError(f"{path}: it ends too early: after {size} of the {needed} bytes in its header; copy it again")
    return form


def _number(file, kind, place=None):
    if place is not None:
        file.seek(place)
    return struct.unpack(kind, file.read(struct.calcsize(kind)))[0]


def _end_of_hdf5(file):
    """The end by the superblock, which has four versions."""
    return _number(file, "<Q", {0: 40, 1: 44, 2: 28, 3: 28}[_number(file, "B", len(HDF5))])


def _end_of_adf(file):
    """The last byte's place: the number of a block, and the byte in the block; in version A in hexadecimal digits."""
    if _number(file, "c", 4 + len(ADF)) == b"A":
        block, byte = _number(file, "8s", 0x92), _number(file, "4s")
        return 4096 * int(block, 16) + int(byte, 16)
    order = ">" if _number(file, "c", 0x64) == b"B" else "<"
    return 4096 * _number(file, order + "Q", 0x92) + _number(file, order + "I")


def _end_of_netcdf(file):
    """The byte after the last value, by the lists of the header in the order of the format (NetCDF Users Guide, B)."""
    version = _number(file, "B", 3)
    count = lambda: _number(file, ">Q" if version == 5 else ">I")
    skip = lambda size: file.seek(size + -size % 4, os.SEEK_CUR)

    def entries(read):
        """The entries of a list, each after its name."""
        _number(file, ">I")  # kind of the list
        return [(skip(count()), read())[1] for _ in range(count())]

    def attributes():
        entries(lambda: skip(WIDTHS[_number(file, ">I")] * count()))

    def variable():
        """The place of its first value, the bytes of all of them or of a record's, and whether there are records."""
        lengths = [dimensions[count()] for _ in range(count())]
        attributes()
        width, _ = WIDTHS[_number(file, ">I")], count()  # the size is cut off where it does not fit
        begin, of_records = _number(file, ">I" if version == 1 else ">Q"), lengths[:1] == [0]
        return begin, width * math.prod(lengths[of_records:]), of_records

    records, dimensions = count(), entries(count)
    attributes()
    variables = entries(variable)
    sizes = [size for _, size, of_records in variables if of_records]
    step = sum(size + -size % 4 for size in sizes) if len(sizes) > 1 else sum(sizes)
    records = 0 if records in STREAMING else records
    ends = [begin + size + (records - 1) * step * moves for begin, size, moves in variables if records or not moves]
    return max([0, *ends])


FORMS = {"NetCDF": (0, b"CDF", _end_of_netcdf), "HDF5": (0, HDF5, _end_of_hdf5), "ADF": (4, ADF, _end_of_adf)}
