"""Numbers in the metadata of volumes, which may hold anything."""

import math


def number_of(metadata, key):
    """A finite number by its key; None where there is none."""
    try:
        value = float(metadata[key])
    except (KeyError, TypeError, ValueError):
        return None
    return value if math.isfinite(value) else None
