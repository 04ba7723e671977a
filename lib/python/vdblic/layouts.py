"""The order of the axes of arrays, as letters of t (time), c (component), x, y and z."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy


def checked(layout: str | None) -> str | None:
    """A layout. Raises ValueError if it names no order of axes."""
    is_order = isinstance(layout, str) and len(set(layout)) == len(layout) and set("xyz") <= set(layout) <= set("tcxyz")
    if layout is not None and not is_order:
        raise ValueError(
            f"`layout` cannot be {layout!r:.100}; it is letters of t, c, x, y and z, each once, such as 'xyz' or 'tzyxc'"
        )
    return layout


def field(values: numpy.ndarray, layout: str | None) -> numpy.ndarray:
    """An array as (x, y, z) or (x, y, z, 3). Raises ValueError if it is neither a scalar nor a vector field.

    Without a layout, the array must have one of these orders. A layout without c puts components last.
    """
    values = numpy.asanyarray(values)
    axes = (layout or "xyz").replace("t", "")
    orders = [axes if "c" in axes else f"{axes}c", axes.replace("c", "")]
    for order in orders:
        if len(order) == values.ndim and ("c" not in order or values.shape[order.index("c")] == 3):
            return values.transpose([order.index(axis) for axis in "xyzc"[: values.ndim]])
    what = f"an array of the shape {values.shape} is no field"
    if layout is not None:
        raise ValueError(f"{what} in the layout '{layout}', of which the vectors have 3 components")
    told = _told("cxyz", "czyx") if values.ndim == 4 and values.shape[0] == 3 else ""
    raise ValueError(f"{what}; {told or 'a field is numbers (x, y, z) or (x, y, z, 3)'}")


def times(values: Any, layout: str | None) -> tuple[Iterator[Any], int]:
    """An iterator over the fields of an array with a time axis, and their number.

    Raises ValueError if the axis is unknown.
    """
    if layout is None:
        raise ValueError(
            f"nothing tells the order of the axes of an array of the shape {values.shape}; "
            f"{_told('txyzc', 'tzyxc')}"
        )
    order = layout if "c" in layout else f"{layout}c"
    if "t" not in order:
        raise ValueError(f"an array of the shape {values.shape} has more axes than the layout '{layout}'")
    axis = order.index("t")
    count = values.shape[axis]
    return (values[(slice(None),) * axis + (index,)] for index in range(count)), count


def _told(first, second):
    return f"say it: layout='{first}' or layout='{second}'"
