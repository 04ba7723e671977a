"""The headers of a .vdb file, without its voxels: metadata, and name, type, transform and box of each grid.

The layout is that of OpenVDB's files from version 222 on (io/File.cc, io/Archive.cc). Blender tells none of this, and
a file is better looked at before Blender opens it: a damaged one ends Blender.
"""

import dataclasses
import math
import os
import struct

MAGIC = 0x56444220
MOST_TEXT = 1 << 20
_NUMBERS = {
    "bool": "<?",
    "float": "<f",
    "double": "<d",
    "int32": "<i",
    "int64": "<q",
    "vec3i": "<3i",
    "vec3s": "<3f",
    "vec3d": "<3d",
}


class DamagedFile(ValueError):
    """A file that is no readable .vdb file; the message names it."""


@dataclasses.dataclass
class Grid:
    """`matrix`: three axes and the origin in world space, None if the transform is not linear; `box`: low and high."""

    name: str
    kind: str
    metadata: dict
    matrix: tuple
    box: tuple

    @property
    def is_mirrored(self):
        if self.matrix is None:
            return False
        (a, b, c), (d, e, f), (g, h, i) = self.matrix[:3]
        return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0

    def to_world(self, index):
        """The world position of a point in index space."""
        return tuple(self.matrix[3][axis] + sum(index[i] * self.matrix[i][axis] for i in range(3)) for axis in range(3))


@dataclasses.dataclass
class Header:
    path: str
    metadata: dict
    grids: list

    def grid(self, name):
        return next((grid for grid in self.grids if grid.name == name), None)

    @property
    def is_sparse(self):
        """Whether inactive voxels are empty: streaks and dye (docs/formats.md)."""
        return self.metadata.get("inactive") == "empty"

    @property
    def texture(self):
        """The name of the texture's grid: told by our files, else `density`, else the first grid of numbers."""
        told = self.metadata.get("texture")
        names = [grid.name for grid in self.grids if grid.kind.startswith("Tree_float")]
        return next((name for name in (told, "density", *names) if name and self.grid(name)), None)

    @property
    def scalars(self):
        return [grid.name for grid in self.grids if grid.kind.startswith("Tree_float") and grid.name]

    @property
    def velocity(self):
        """The name of a grid of velocities, for motion blur."""
        vectors = {grid.name for grid in self.grids if grid.kind.startswith("Tree_vec3")}
        return next((name for name in ("vel", "velocity", "v") if name in vectors), None)

    @property
    def dt(self):
        """Seconds between the frames; None if the file has no such number."""
        told = self.metadata.get("dt")
        return told if type(told) in (int, float) and 0 < told < math.inf else None

    @property
    def is_y_up(self):
        """Whether file or velocity came from Houdini, whose y is up."""
        return any(str(self.metadata.get(key, "")).startswith("Houdini") for key in ("creator", "source_creator"))

    @property
    def refinement(self):
        """Texture voxels in a voxel of the velocity, along each axis."""
        told = self.metadata.get("refine")
        told = told if isinstance(told, tuple) and len(told) == 3 else (1, 1, 1)
        return tuple(n / 2 ** self.metadata.get("level", 0) for n in told)


class _Reader:
    def __init__(self, path):
        self._file = open(path, "rb")
        self._size = os.fstat(self._file.fileno()).st_size

    def close(self):
        self._file.close()

    def bytes(self, count):
        if not 0 <= count <= MOST_TEXT:
            raise ValueError("a length is out of range")
        data = self._file.read(count)
        if len(data) < count:
            raise ValueError("it ends too early")
        return data

    def number(self, form):
        values = struct.unpack(form, self.bytes(struct.calcsize(form)))
        return values if len(values) > 1 else values[0]

    def text(self):
        return self.bytes(self.number("<I")).decode("utf-8", "replace")

    def metadata(self):
        found = {}
        for _ in range(min(self.number("<I"), 10000)):
            name, kind = self.text(), self.text()
            value = self.bytes(self.number("<I"))
            if kind == "string":
                found[name] = value.decode("utf-8", "replace")
            elif kind in _NUMBERS and len(value) == struct.calcsize(_NUMBERS[kind]):
                values = struct.unpack(_NUMBERS[kind], value)
                found[name] = values if len(values) > 1 else values[0]
        return found

    def seek(self, position):
        if not 0 <= position <= self._size:
            raise ValueError("it is cut off")
        self._file.seek(position)

    def matrix(self):
        """A linear transform as three axes and the origin, or None."""
        kind, axes, origin = self.text(), [[1, 0, 0], [0, 1, 0], [0, 0, 1]], (0.0, 0.0, 0.0)
        if kind in ("AffineMap", "UnitaryMap"):
            values = self.number("<16d")
            axes, origin = [values[4 * i : 4 * i + 3] for i in range(3)], values[12:15]
        elif kind == "TranslationMap":
            origin = self.number("<3d")
        elif kind in ("UniformScaleMap", "ScaleMap", "UniformScaleTranslateMap", "ScaleTranslateMap"):
            origin = self.number("<3d") if kind.endswith("TranslateMap") else origin
            axes = [[x * (i == j) for j in range(3)] for i, x in enumerate(self.number("<3d"))]
        else:
            return None
        return (*map(tuple, axes), tuple(origin))


def read_header(path):
    """Read the header of a file. Raises DamagedFile naming it, OSError."""
    reader = _Reader(path)
    try:
        return _read(path, reader)
    except (ValueError, struct.error) as error:
        raise DamagedFile(f"{path}: this is no whole .vdb file ({error}); write it again") from None
    finally:
        reader.close()


def headers_of(files):
    """The headers of up to five files over a sequence. Raises DamagedFile, OSError."""
    last = len(files) - 1
    return [read_header(files[i]) for i in sorted({last * i // 4 for i in range(5)})]


def _read(path, reader):
    if reader.number("<q") != MAGIC:
        raise ValueError("it does not begin as one")
    version = reader.number("<I")
    if version < 222:
        raise ValueError(f"version {version} of the format is too old")
    reader.number("<II")
    if not reader.number("<?"):
        raise ValueError("it does not tell where its grids are")
    reader.bytes(36)
    header = Header(str(path), reader.metadata(), [])
    for _ in range(min(reader.number("<i"), 10000)):
        name, kind, parent = reader.text(), reader.text(), reader.text()
        start, _, end = reader.number("<3q")
        if parent:
            continue
        reader.seek(end)
        reader.seek(start)
        reader.number("<I")
        metadata, matrix = reader.metadata(), reader.matrix()
        box = metadata.get("file_bbox_min"), metadata.get("file_bbox_max")
        box = box if None not in box and all(a <= b for a, b in zip(*box)) else None
        header.grids.append(Grid(name.split("\x1e")[0], kind.replace("_HalfFloat", ""), metadata, matrix, box))
        reader.seek(end)
    return header
