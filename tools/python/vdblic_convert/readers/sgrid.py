"""C grids by SGRID's attributes: where values on the edges, faces and nodes of cells lie that have no coordinates."""

import re

import numpy

from ..errors import InputError

PADDING = {"none": (0, 0), "low": (1, 0), "high": (0, 1), "both": (1, 1)}  # faces before the first node, after the last
PAIR = re.compile(r"([^\s:()]+)(?:\s*:\s*([^\s:()]+))?\s*(?:\(\s*padding\s*:\s*(\w*)\s*\))?")


class CGrid:
    """The dimensions of staggered grids: `axes` has X, Y or Z for each."""

    def __init__(self, data, axis_of):
        self.axes, self._place, nodes = {}, {}, {}  # dimension → that of the nodes, place of the first in nodes
        for name in data.variables:
            if data.text(name, "cf_role") != "grid_topology":
                continue
            told = {key: str(value) for key, value in data.attrs(name).items() if key.lower().endswith("_dimensions")}
            order = sorted(told, key=lambda key: (not key.lower().startswith("node"), key))
            for key in order:
                for dimension, node, padding in PAIR.findall(told[key]):
                    self._keep(data, f"{name}:{key}={told[key]}", dimension, node or dimension, padding, nodes)
        groups = {node: [d for d, (own, _) in self._place.items() if own == node] for node in nodes}
        known = {node: {axis for d in group if (axis := axis_of(data, d))} for node, group in groups.items()}
        known = {node: axes.pop() for node, axes in known.items() if len(axes) == 1}
        for node, group in groups.items():
            known.setdefault(node, next((axis for axis in "XYZ" if axis not in known.values()), None))
            self.axes |= dict.fromkeys(group, known[node])

    def _keep(self, data, told, dimension, node, padding, nodes):
        """Record an attribute's value for a dimension. Raises InputError for contradictions."""
        mend = f"correct it: --attribute '{told}'"
        if padding and padding not in PADDING:
            raise InputError(f"{data.path}: '{padding}' is no padding, which is none, low, high or both; {mend}")
        before, after = PADDING.get(padding, (0.5, 0.5))  # without padding it is the nodes' place
        place = node, 0.5 - before
        if self._place.setdefault(dimension, place) != place:
            raise InputError(f"{data.path}: the grid contradicts itself about the padding of '{dimension}'; {mend}")
        size = data.sizes.get(dimension)
        count = nodes[node] = nodes.get(node) or size and size + 1 - before - after
        if size and size != count - 1 + before + after:
            raise InputError(
                f"{data.path}: {count:g} nodes along '{node}' and the padding '{padding or 'missing'}' make "
                f"{count - 1 + before + after:g} places along '{dimension}', which has {size}; {mend}"
            )

    def others(self, dimensions):
        """The dimensions on the same nodes as the given ones, the nearest first."""
        alike = [[d for d, (node, _) in self._place.items() if node == self._place[own][0]]
                 for own in dimensions if own in self._place]  # fmt: skip
        found = [()] if len(alike) == len(dimensions) else []
        for choices in alike:
            found = [(*before, choice) for before in found for choice in choices]
        return sorted(found, key=lambda other: sum(a != b for a, b in zip(other, dimensions)))

    def moved(self, values, there, here, sizes):
        """Values of the dimensions `there` at the places of `here`: half way between, or beyond the outer ones."""
        for axis, (a, b) in enumerate(zip(there, here)):
            at = numpy.arange(sizes[b]) + self._place[b][1] - self._place[a][1]
            low = numpy.clip(numpy.floor(at), 0, values.shape[axis] - 2).astype(int)
            share = (at - low).reshape([-1 if i == axis else 1 for i in range(values.ndim)])
            values = numpy.take(values, low, axis) * (1 - share) + numpy.take(values, low + 1, axis) * share
        return values
