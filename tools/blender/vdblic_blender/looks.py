"""Presets: where a texture begins to be seen, colours, light. No Blender is needed here."""

import dataclasses

# From low to high values, as displayed; linear() converts them.
EMBER = 0x3F3FA0, 0x7D46A8, 0xB94F96, 0xE4646F, 0xF68A4E, 0xFCB945, 0xFBE77A, 0xFFFBE0
VIRIDIS = 0x440154, 0x472D7B, 0x3B528B, 0x2C728E, 0x21918C, 0x28AE80, 0x5EC962, 0xADDC30, 0xFDE725
PAPER = 0xF29E21, 0xE65C33, 0xBD2B61, 0x66248F, 0x172480
INK = 0x7D8AA5, 0x44546F, 0x1C2A44, 0x0B1226
ICE = 0x16324F, 0x2F6F9F, 0x6FB3D9, 0xC4E6F5, 0xFFFFFF
GRAY = 0x8C949E, 0xF7F5F0


@dataclasses.dataclass
class Kind:
    """What a texture is like: values at which it begins and is full, its share of the volume, mean optical depth."""

    begin: float
    full: float
    share: float
    depth: float


@dataclasses.dataclass
class Look:
    colors: tuple
    glow: float
    background: tuple
    depth: float = 1  # factor on the optical depth


KINDS = {"DENSE": Kind(0.62, 0.76, 0.12, 4), "STREAKS": Kind(0.1, 0.6, 0.06, 1.2), "DYE": Kind(0.0, 1.0, 0.2, 2)}
LOOKS = {
    "FLOW": Look(EMBER, 0.3, (0.004, 0.006, 0.010)),
    "VIRIDIS": Look(VIRIDIS, 0.3, (0.004, 0.006, 0.010)),
    "PAPER": Look(PAPER, 0.5, (0.85, 0.87, 0.90), 2),
    "INK": Look(INK, 0.4, (0.92, 0.89, 0.82), 2),
    "SMOKE": Look(GRAY, 0.05, (0.004, 0.006, 0.010)),
    "XRAY": Look(ICE, 0.8, (0.004, 0.006, 0.010), 0.3),
}
LOOK_ITEMS = tuple((name, name.title(), f"Colours and light of the look {name.lower()}") for name in LOOKS)


def linear(color):
    """A colour 0xRRGGBB as displayed (sRGB), in linear light."""
    parts = [(color >> shift & 255) / 255 for shift in (16, 8, 0)]
    return tuple(part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)


def kind_of(header):
    """The kind of a file's texture."""
    return "STREAKS" if header.is_sparse else "DENSE"


def opacities(shares):
    """Opacity by value: high and rare values are more opaque, so that common ones do not hide the rest.

    @param shares  of the volume, for values evenly spaced over the range
    """
    last = len(shares) - 1
    return [min((0.1 + i / last) / max(share * last, 0.25), 1) for i, share in enumerate(shares)]
