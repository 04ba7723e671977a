"""Whether files are as long as their headers say. Libraries read zeros for what a truncated file lacks, or loop."""

import os
import struct

from ..errors import InputError

HDF5 = b"\x89HDF\r\n\x1a\n"
ADF = b"ADF Database Version "  # of CGNS, after four bytes; then its version, such as A02011 or B02012
WIDTHS = {1: 1, 2: 1, 3: 2, 4: 4, 5: 4, 6: 8, 7: 1, 8: 2, 9: 4, 10: 8, 11: 8}  # bytes of a value of NetCDF's types
STREAMING = 0xFFFFFFFF, 0xFFFFFFFFFFFFFFFF  # numbers of records that nobody wrote down


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
    file.seek(3)
    return _Header(file).end()


FORMS = {"NetCDF": (0, b"CDF", _end_of_netcdf), "HDF5": (0, HDF5, _end_of_hdf5), "ADF": (4, ADF, _end_of_adf)}


class _Header:
    """A header of NetCDF: its lists, in the order of the format (NetCDF Users Guide, appendix B)."""

    def __init__(self, file):
        self._file = file
        self._version = _number(file, "B")
        self._records = self._count()
        self._dimensions = self._list(self._count)
        self._attributes()
        self._variables = self._list(self._variable)

    def end(self):
        """The byte after the last value."""
        if self._records in STREAMING:
            self._records = 0
        fixed = [begin + size for begin, size, of_records in self._variables if not of_records]
        records = [(begin, size) for begin, size, of_records in self._variables if of_records]
        step = sum(size + -size % 4 for _, size in records) if len(records) > 1 else sum(size for _, size in records)
        last = [begin + (self._records - 1) * step + size for begin, size in records if self._records]
        return max([0, *fixed, *last])

    def _variable(self):
        """The place of its first value, the bytes of all of them or of a record's, and whether there are records."""
        lengths = [self._dimensions[self._count()] for _ in range(self._count())]
        self._attributes()
        size = WIDTHS[_number(self._file, ">I")]
        self._count()  # the size, which is cut off where it does not fit
        begin = _number(self._file, ">I" if self._version == 1 else ">Q")
        of_records = lengths[:1] == [0]
        for length in lengths[of_records:]:
            size *= length
        return begin, size, of_records

    def _attributes(self):
        self._list(lambda: self._skip(WIDTHS[_number(self._file, ">I")] * self._count()))

    def _list(self, read):
        """The entries of a list, each after its name."""
        _number(self._file, ">I")  # what kind of list it is

        def entry():
            self._skip(self._count())
            return read()

        return [entry() for _ in range(self._count())]

    def _count(self):
        return _number(self._file, ">Q" if self._version == 5 else ">I")

    def _skip(self, count):
        self._file.seek(count + -count % 4, os.SEEK_CUR)
