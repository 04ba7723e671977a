"""The bytes of .vdb files: the numbers that tell how to read the rest, the metadata, and our own checksums."""

import ctypes
import struct

IDENTITY = slice(21, 57)


class Walk:
    """A file's numbers that are lengths, counts, offsets or kinds, as (what, where, form of struct), and its parts."""

    def __init__(self, data):
        self.data, self.at, self.fields, self.grids, self.kinds = data, 0, [], [], []
        for what, form in ("version", "<I"), ("library", "<I"), ("library", "<I"), ("whether offsets follow", "<B"):
            self.at = self.at or 8
            self.number(what, form)
        self.at = IDENTITY.stop
        self.metadata = self.pairs()
        self.metadata_end = self.at
        count = self.number("count of grids", "<i")
        self.header_end = self.at
        for _ in range(count):
            self.grid()

    def number(self, what, form):
        self.fields.append((what, self.at, form))
        value, = struct.unpack_from(form, self.data, self.at)
        self.at += struct.calcsize(form)
        return value

    def text(self, what):
        length = self.number(f"length of {what}", "<I")
        self.at += length
        return self.data[self.at - length:self.at].decode("utf-8", "replace")

    def pairs(self):
        """Metadata: name → (type, where the value begins and ends)."""
        found = {}
        for _ in range(self.number("count of metadata", "<I")):
            name, kind = self.text("a name"), self.text("a type")
            size = self.number("size of a value", "<I")
            found[name] = kind, self.at, self.at + size
            self.at += size
        return found

    def grid(self):
        begin = self.at
        _, kind, _ = (self.text(what) for what in ("a grid's name", "a grid's type", "an instance's name"))
        head, blocks, end = (self.number("offset", "<q") for _ in range(3))
        self.grids.append((begin, end))
        self.kinds.append(kind)
        self.at = head
        self.number("compression", "<I")
        self.pairs()
        transform = self.text("a transform's type")
        self.at += {"AffineMap": 128}.get(transform, 144 if "Translate" in transform else 120)
        self.number("count of buffers", "<i")
        self.at += 12 if kind.startswith("Tree_vec3s") else 4  # the background
        for what in "count of tiles", "count of children", "place of a child", "place of a child", "place of a child":
            self.number(what, "<i")
        for what, at, form in ("flags of a node", self.at + 2 * 4096, "<B"), ("flags of a leaf", blocks + 64, "<B"), (
                "size of a leaf", blocks + 65, "<q"), ("a leaf's mask", blocks, "<Q"):
            if at + struct.calcsize(form) <= end:
                self.fields.append((what, at, form))
        self.at = end


def pairs(data):
    """The file metadata but the checksums: name → (type, bytes)."""
    return {name: (kind, data[begin:end]) for name, (kind, begin, end) in Walk(data).metadata.items()
            if name != "checksum"}


def changed(data, **values):
    """A file with other file metadata: bytes replace a value, None removes it, (type, bytes) are new; offsets stay right.

    Its checksums are those of its bytes, as those of an attacker would be.
    """
    walk = Walk(data)
    pairs = {name: (kind, data[begin:end]) for name, (kind, begin, end) in walk.metadata.items()}
    for name, value in values.items():
        if value is None:
            pairs.pop(name)
        else:
            pairs[name] = value if isinstance(value, tuple) else (pairs[name][0], value)
    told = lambda text: struct.pack("<I", len(text)) + text
    head = data[:IDENTITY.stop] + struct.pack("<I", len(pairs))
    for name, (kind, value) in pairs.items():
        head += told(name.encode()) + told(kind.encode()) + told(value)
    shift = len(head) - walk.metadata_end
    result = bytearray(head + data[walk.metadata_end:])
    for what, at, form in walk.fields:
        if what == "offset":
            struct.pack_into(form, result, at + shift, struct.unpack_from(form, data, at)[0] + shift)
    return sealed(bytes(result))


def sealed(data):
    """A file with the checksums of its bytes (lib/vdblic/io/checksum.cpp)."""
    walk, hashes = Walk(data), ctypes.CDLL("libxxhash.so.0")

    class Wide(ctypes.Structure):
        _fields_ = [("low", ctypes.c_uint64), ("high", ctypes.c_uint64)]

    hashes.XXH3_64bits.restype, hashes.XXH3_128bits.restype = ctypes.c_uint64, Wide
    hashes.XXH3_64bits.argtypes = hashes.XXH3_128bits.argtypes = ctypes.c_char_p, ctypes.c_size_t
    _, begin, end = walk.metadata["checksum"]
    parts = [data[:IDENTITY.start] + data[IDENTITY.stop:begin] + data[end:walk.header_end],
             *(data[first:last] for first, last in walk.grids)]
    text = ",".join(f"{hashes.XXH3_64bits(part, len(part)):016x}" for part in parts).encode()
    wide = hashes.XXH3_128bits(text, len(text))
    high, low = wide.high & ~0xf000 | 0x8000, wide.low & ~(3 << 62) | 2 << 62
    identity = f"{high >> 32:08x}-{high >> 16 & 0xffff:04x}-{high & 0xffff:04x}-{low >> 48:04x}-{low & 0xffffffffffff:012x}"
    result = bytearray(data)
    result[begin:end], result[IDENTITY] = text, identity.encode()
    return bytes(result)
