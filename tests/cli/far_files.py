"""Files with single voxels anywhere in index space, in all types of grids; pyopenvdb knows few."""

import struct
import zlib

# Name of the type → form of a value in struct, on disk.
TYPES = {"float": "f", "half": "e", "double": "d", "int32": "i", "int64": "q", "bool": "?", "mask": "?", "vec3s": "fff",
         "vec3half": "eee", "vec3d": "ddd", "vec3i": "iii"}


def _text(value):
    return struct.pack("<I", len(value)) + value.encode()


def _mask(bit, size):
    return (1 << bit).to_bytes(size // 8, "little")


def _zipped(data):
    packed = zlib.compress(data, 1)
    return struct.pack("<q", len(packed)) + packed


def far_file(kind, name, voxels):
    """A file in format 221 whose grid is 1 at voxels, of which no two are in one child of the root."""
    form, tree = TYPES[kind], kind.replace("vec3half", "vec3s").replace("half", "float")
    isHalf, one = "half" in kind, struct.pack("<" + form, *[1] * len(form))
    isMask = kind == "mask"
    told = {"name": ("string", name.encode()), "is_saved_as_half_float": ("bool", struct.pack("?", isHalf)),
            "dt": ("double", struct.pack("<d", 1)), "file_voxel_count": ("int64", struct.pack("<q", len(voxels))),
            "file_mem_bytes": ("int64", struct.pack("<q", 1 << 20)),
            "file_bbox_min": ("vec3i", struct.pack("<3i", *map(min, zip(*voxels)))),
            "file_bbox_max": ("vec3i", struct.pack("<3i", *map(max, zip(*voxels))))}
    metadata = struct.pack("<I", len(told))
    for key, (sort, value) in told.items():
        metadata += _text(key) + _text(sort) + struct.pack("<I", len(value)) + value
    place = _text("UniformScaleMap") + struct.pack("<15d", *[1] * 12, *[0.5] * 3)
    zero = b"" if isMask else bytes(struct.calcsize(form.replace("e", "f")))
    topology = struct.pack("<i", 1) + (b"\0" if isMask else zero) + struct.pack("<II", 0, len(voxels))
    leaves = b""
    for voxel in voxels:
        offset = lambda shift, bits: sum((at >> shift & (1 << bits) - 1) << bits * (2 - i) for i, at in enumerate(voxel))
        topology += struct.pack("<3i", *(at & ~4095 for at in voxel))
        for shift, bits in (7, 5), (3, 4):
            size = 1 << 3 * bits
            topology += _mask(offset(shift, bits), size) + bytes(size // 8)
            topology += _zipped(bytes(len(one) * (size - 1)))
        leaf, origin = _mask(offset(0, 3), 512), struct.pack("<3i", *(at & ~7 for at in voxel))
        topology += leaf
        if isMask:
            leaves += leaf + origin
        elif kind == "bool":
            leaves += leaf + origin + leaf
        else:
            leaves += leaf + origin + b"\1" + _zipped(one * 512)
    head = struct.pack("<qIII", 0x56444220, 221, 10, 0) + b"\1\1" + b"00000000-0000-4000-8000-000000000000"
    head += struct.pack("<Ii", 0, 1) + _text(name) + _text(f"Tree_{tree}_5_4_3" + "_HalfFloat" * isHalf) + _text("")
    begin = len(head) + 24
    blocks = begin + len(metadata + place + topology)
    return head + struct.pack("<3q", begin, blocks, blocks + len(leaves)) + metadata + place + topology + leaves
