"""The choice of the velocity's arrays."""

import re

from .errors import InputError, ParameterError

VECTORS = ("velocity", "Velocity", "VELOCITY", "vel", "vel_", "VEL", "v", "U", "u", "V", "UMean")
OTHERS = re.compile("disp|moment|normal|magnet|vortic|force|accel|grad|coord|position|^[BC]$", re.IGNORECASE)
TRIPLES = [tuple(names.split()) for names in (
    "u v w", "U V W", "vx vy vz", "VX VY VZ", "Vx Vy Vz", "vx1 vx2 vx3", "v1 v2 v3", "Ux Uy Uz", "velx vely velz",
    "velocity_x velocity_y velocity_z", "velocityX velocityY velocityZ", "x_velocity y_velocity z_velocity",
    "X_VELOCITY Y_VELOCITY Z_VELOCITY", "velocity.x velocity.y velocity.z")]  # fmt: skip


def names_of(option):
    """The names in an option: NAME or NAME,NAME. Raises ParameterError."""
    names = option.split(",")
    if any(not name.strip() or "\n" in name or "\0" in name for name in names):
        raise ParameterError(f"'{option[:60]!r}' is not a list of names; write NAME or NAME,NAME")
    return tuple(name.strip() for name in names)


def chosen(arrays, asked, usual, path):
    """The arrays of the velocity: one with three components, or two or three scalars.

    `arrays` maps names to numbers of components, `asked` is the user's choice or empty, `usual` the file's own choice
    or empty. Returns the names, and whether they are a guess to report. Raises InputError.
    """
    if asked:
        _check(arrays, asked, path)
        return asked, False
    if usual:
        return usual, False
    vectors = [name for name, components in arrays.items() if components == 3]
    for name in VECTORS:
        if name in vectors:
            return (name,), len(vectors) > 1
    for names in TRIPLES:
        if all(arrays.get(name) == 1 for name in names):
            return names, False
    if len(vectors) == 1 and not OTHERS.search(vectors[0]):
        return (vectors[0],), True
    raise InputError(
        f"{path}: no array is known as a velocity; choose with --array NAME or --array U,V,W; the file holds "
        f"{contents(arrays)}"
    )


def contents(arrays):
    """The arrays of a file, for messages."""
    shown = [f"{name} ({components})" if components != 1 else name for name, components in sorted(arrays.items())]
    return ", ".join(shown[:30]) + (" ..." if len(shown) > 30 else "") or "no arrays"


def check_carried(arrays, names, path):
    for name in names:
        if arrays.get(name) not in (1, 3):
            raise InputError(
                f"{path}: no array '{name}' of 1 or 3 components to carry; the file holds {contents(arrays)}"
            )


def _check(arrays, names, path):
    if len(names) > 3:
        raise ParameterError(
            f"--array {','.join(names)} names {len(names)} arrays; a velocity is one with three components, "
            "or two or three scalars"
        )
    for name in names:
        if name not in arrays:
            raise InputError(f"{path}: no array '{name}'; the file holds {contents(arrays)}")
        wanted = 3 if len(names) == 1 else 1
        if arrays[name] != wanted:
            raise InputError(
                f"{path}: array '{name}' has {arrays[name]} components, not {wanted}; a velocity is one array "
                "with three components, or two or three scalars: --array u,v,w"
            )
