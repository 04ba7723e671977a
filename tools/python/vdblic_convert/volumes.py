""".vdb files of dense arrays, and back."""

import hashlib
import uuid

import numpy

from .errors import InputError, needed
from .files import bytes_of
from .header import check_header

_OUTSIDE = float(numpy.finfo(numpy.float32).max)  # what no value is: it marks inactive voxels
_IDENTIFIER = slice(21, 57)  # of a file, in its header


def grid_of(name, values, mask, target):
    """A float or vector grid of an array (x, y, z, components), active where the mask is."""
    vdb = needed("pyopenvdb")
    values = numpy.where(mask[..., None], values, _OUTSIDE).astype(numpy.float32)
    if values.shape[3] == 1:
        grid = vdb.FloatGrid(_OUTSIDE)
        values = values[..., 0]
    else:
        grid = vdb.Vec3SGrid((_OUTSIDE,) * 3)
        grid.vectorType = "contravariant relative"
    grid.copyFromArray(numpy.ascontiguousarray(values), target.first)
    grid.background = (0, 0, 0) if values.ndim == 4 else 0
    grid.name = name
    grid.transform = vdb.createLinearTransform(target.matrix.T.tolist())
    return grid


def bytes_of_volume(output, grids, metadata):
    """The .vdb file of an output. Equal grids give equal bytes: an identifier of the content replaces OpenVDB's."""
    vdb = needed("pyopenvdb")
    data = bytearray(bytes_of(output, lambda path: vdb.write(path, grids, metadata)))
    data[_IDENTIFIER] = b"0" * 36
    data[_IDENTIFIER] = str(uuid.UUID(bytes=hashlib.sha256(data).digest()[:16])).encode()
    return data


def read_volume(path):
    """The grids and the file metadata of a .vdb file. Raises InputError."""
    vdb = needed("pyopenvdb")
    check_header(path)
    try:
        return vdb.readAll(str(path))
    except Exception as error:  # OpenVDB reports what it met as errors of many kinds
        reason = "".join(char for char in str(error) if char.isprintable()).strip()
        raise InputError(f"{path}: cannot be read as a .vdb file: {' '.join(reason.split())[:200]}") from None


def metadata_of(path):
    """The time, spacing and number of a volume, from the file or from its first grid that has them."""
    vdb = needed("pyopenvdb")
    found = dict(vdb.readMetadata(str(path)))
    for grid in vdb.readAllGridMetadata(str(path)):
        found = {**{key: grid[key] for key in ("time", "dt", "frame") if key in grid.metadata}, **found}
    return found
