"""Unstructured meshes in layers, of FVCOM, MPAS and UGRID, as prisms between the layers."""

import re

import numpy

from ..errors import InputError
from ..units import measures
from ..vtk_data import WEDGE, add_array, bridge, core, model
from .earth import local_plane
from .gridded import Gridded
from .heights import HEIGHTS, TERMS, by_formula, heights_of_axis

METRES = {"eta": "m", "depth": "m"}  # as FVCOM has them where a file does not say so
DIMENSIONS = "nSCHISM_hgrid_node", "nCells", "ncells", "nod2", "elem", "nele"  # of meshes that are described elsewhere
MODELS = (  # the nodes around a face, and the places of nodes, as models have them
    ("nv", ("lon", "lat")),
    ("nv", ("x", "y")),
    ("elements", ("lon", "lat")),
    ("SCHISM_hgrid_face_nodes", ("SCHISM_hgrid_node_x", "SCHISM_hgrid_node_y")),
    ("cellsOnVertex", ("lonCell", "latCell")),
)
ZCOR = "zcor", "zCoordinates"  # SCHISM's heights
USUAL = (
    ("u", "uReconstructZonal", "velocityZonal", "hvel x", "horizontalVelX"),
    ("v", "uReconstructMeridional", "velocityMeridional", "hvel y", "horizontalVelY"),
    ("ww", "w", "vertVelocityTop", "vertical_velocity", "verticalVelocity"),
)


def is_mesh(data):
    located = any(data.text(name, "mesh") and data.text(name, "location") for name in data.variables)
    return bool(_topologies(data)) or located or any(name in data.sizes for name in DIMENSIONS)


def has_topology(data):
    return bool(_topologies(data)) or any({joined, *nodes} <= set(data.variables) for joined, nodes in MODELS)


def _topologies(data):
    return [name for name in data.variables if data.text(name, "face_node_connectivity")]


class MeshFile(Gridded):
    """Fields at the nodes, or in the middle of the faces, of a mesh of polygons, which are cut into triangles.

    MPAS's velocity in its hexagons is at the nodes of the dual mesh, whose triangles join three hexagons.
    """

    usual = USUAL

    def __init__(self, data, options):
        for name in [name for name, variable in data.variables.items() if variable.dims[-1:] == ("two",)]:
            both = data.variables.pop(name)  # SCHISM's vectors
            data.variables |= {f"{name} {axis}": both.isel(two=i) for i, axis in enumerate("xy")}
        super().__init__(data, options)
        nodes, connectivity, start = self._topology()
        self._nodes, self._node = nodes, data.variables[nodes[0]].dims[-1]
        self._triangles, self._of_face = self._cut(connectivity, start)
        self._face = next(
            (d for d in data.variables[connectivity].dims if data.sizes[d] == self._of_face[-1] + 1), None
        )
        if "cellsOnVertex" in data.variables:
            self._face = None
        self._fields = {name: space for name in data.variables if (space := self._space(name))}
        self.check_fields("is on the mesh's nodes or faces")

    def levels_of(self, name):
        return self._fields[name][1]

    def _topology(self):
        """The names of the nodes' coordinates and of the nodes around a face, and the number of the first node."""
        data = self.data
        if found := _topologies(data):
            connectivity = data.text(found[0], "face_node_connectivity")
            nodes = data.text(found[0], "node_coordinates").split()
            for name in (connectivity, *nodes):
                if name not in data.variables:
                    raise InputError(f"{self.path}: the mesh '{found[0]}' names '{name}', which the file lacks")
            if len(nodes) < 2:
                raise InputError(f"{self.path}: the mesh '{found[0]}' names no node_coordinates")
            start = data.text(connectivity, "start_index") or "0"
            return tuple(nodes[:2]), connectivity, int(float(start))
        for connectivity, nodes in MODELS:
            if {connectivity, *nodes} <= set(data.variables) and numpy.ptp(self.place(nodes[0], 0)) > 0:
                return nodes, connectivity, 1
        if found := self._corners():
            return found
        raise InputError(
            f"{self.path}: it is an unstructured mesh ({', '.join(data.sizes)}), but nothing tells which nodes its "
            "cells join: neither a mesh of UGRID (face_node_connectivity), bounds of the cells' longitude and latitude "
            "nor the variables of FVCOM (nv), SCHISM (SCHISM_hgrid_face_nodes), FESOM (elements) or MPAS "
            f"(cellsOnVertex) and those of its nodes; name the file of the mesh, too: vdblic_import {self.path} MESH.nc"
        )

    def _corners(self):
        """Nodes by the bounds of cells, as ICON has them: corners at one place are one node. None without bounds."""
        data, degrees = self.data, []
        for kind in "longitude", "latitude":
            told = (n for n, v in data.variables.items() if v.ndim == 1 and data.text(n, "standard_name") == kind)
            name = next((name for name in told if data.text(name, "bounds") in data.variables), None)
            if name is None or data.sizes[data.variables[data.text(name, "bounds")].dims[-1]] < 3:
                return None
            bounds = data.text(name, "bounds")
            degrees.append(self.in_unit(bounds, self.place(bounds, 0), "degree", data.text(name, "units"), "corners"))
        east, north = numpy.radians(degrees)
        places = numpy.cos(north) * numpy.cos(east), numpy.cos(north) * numpy.sin(east), numpy.sin(north)
        places = numpy.stack(places, axis=-1).reshape(-1, 3).round(7)
        _, first, joined = numpy.unique(places, axis=0, return_index=True, return_inverse=True)
        data.add("corners of cells", data.variables[bounds].dims, joined.reshape(east.shape))
        for name, values in zip(("longitude of corners", "latitude of corners"), degrees):
            data.add(name, ("corner",), values.ravel()[first], units="degree")
        return ("longitude of corners", "latitude of corners"), "corners of cells", 0

    def _cut(self, connectivity, start):
        """Triangles as numbers of nodes (triangles, 3), and the face that each is of."""
        joined = self.variable(connectivity, 0)
        dims = self.data.variables[connectivity].dims
        if self.data.sizes[dims[0]] < self.data.sizes[dims[-1]] and self.data.sizes[dims[0]] <= 12:
            joined = joined.T
        joined = numpy.where(numpy.isfinite(joined), joined - start, -1).astype(int)
        count = self.data.sizes[self._node]
        if joined.max() >= count:
            raise InputError(f"{self.path}: '{connectivity}' names node {joined.max() + start} of {count}")
        faces = numpy.arange(len(joined))
        fans = [numpy.stack([joined[:, 0], joined[:, i], joined[:, i + 1]], 1) for i in range(1, joined.shape[1] - 1)]
        triangles, faces = numpy.concatenate(fans), numpy.tile(faces, len(fans))
        whole = (triangles >= 0).all(axis=1)
        order = numpy.argsort(faces[whole], kind="stable")
        return triangles[whole][order], faces[whole][order]

    def _space(self, name):
        """Where a field is, at nodes or in faces, and its vertical dimension or None; empty for other variables."""
        variable, long = self.data.variables[name], self.long(name)
        place = [d for d in long if d in (self._node, self._face)]
        is_field = variable.dtype.kind in "fiu" and self.in_time(name)
        if len(place) != 1 or len(long) > 2 or not is_field or name in self._nodes:
            return ()
        return (place[0], next((d for d in long if d != place[0]), None))

    def _read(self, step, names, velocity):
        (place, levels), (x, y, keep) = self._fields[names[0]], self._horizontal()
        z = self._heights(step, place, levels, x, y)
        count, (triangles, faces) = z.shape[1], (self._triangles[keep], self._of_face[keep])
        lower = numpy.concatenate([triangles + layer * count for layer in range(len(z) - 1)])
        points, cells, grid = core.vtkPoints(), model.vtkCellArray(), model.vtkUnstructuredGrid()
        places = numpy.stack([numpy.tile(x, len(z)), numpy.tile(y, len(z)), z.ravel()], axis=1)
        points.SetData(bridge.numpy_to_vtk(places, deep=True))
        corners = numpy.concatenate([lower, lower + count], axis=1)
        cells.SetData(6, bridge.numpy_to_vtkIdTypeArray(corners.ravel().astype(numpy.int64), deep=True))
        grid.SetPoints(points)
        grid.SetCells(WEDGE, cells)
        for name in names:
            values = self._field(name, step, place, velocity).astype(numpy.float32)
            if place == self._node:
                add_array(grid.GetPointData(), name, numpy.repeat(values, 1 + (levels is None), axis=0).ravel())
            else:
                add_array(grid.GetCellData(), name, values[:, faces].ravel())
        return grid

    def _field(self, name, step, place, velocity):
        """A variable as (levels, nodes or faces)."""
        values, long = self.variable(name, step), self.long(name)
        values = (values.T if long[0] == place else values).reshape(-1, self.data.sizes[place])
        role = f"component {'xyz'[velocity.index(name)]}" if name in velocity else ""
        return self.in_unit(name, values, "m/s", role=role) if role else values

    def _horizontal(self):
        """x and y of the nodes, and which triangles do not lie across the end of the plane."""
        usual = "radian" if self._nodes == ("lonCell", "latCell") else ""
        flat = all((unit := self.data.text(name, "units")) and measures(unit, "m") for name in self._nodes)
        unit = "m" if flat else "degree"
        x, y = (self.in_unit(name, self.place(name, 0), unit, usual, "a coordinate of nodes") for name in self._nodes)
        if flat:
            return x, y, slice(None)
        around = numpy.sort(x % 360)
        gaps = numpy.diff(around, append=around[0] + 360)
        first = around[(numpy.argmax(gaps) + 1) % len(around)]
        x = (x - first + 1e-9) % 360 + first
        keep = numpy.ptp(x[self._triangles], axis=1) < 180
        if not keep.all():
            self._notes.append(f"{numpy.count_nonzero(~keep)} triangles across {first:.4g} degrees are left out")
        x, y, _, middle = local_plane(x, y, self.middle and self.middle[:2], unordered=True)
        self.middle = self.middle or (*middle, False)
        return x, y, keep

    def _heights(self, step, place, levels, x, y):
        """Heights (levels, nodes): of values at nodes, or of the faces between the layers."""
        data, nodes = self.data, self.data.sizes[self._node]
        if levels is None:
            sides = self._triangles[:, :2]
            width = numpy.median(numpy.hypot(numpy.diff(x[sides]), numpy.diff(y[sides])))
            return numpy.repeat(numpy.array([[-0.5], [0.5]]) * width, nodes, axis=1)
        if place != self._node:
            for name, variable in data.variables.items():  # a coordinate of one level more
                if self._is_formula(name) and data.sizes[levels] + 1 in variable.shape:
                    return self._formula(name, step, nodes)
        z = self._heights_of(step, levels, nodes)
        return z if place == self._node else _edges(z)

    def _heights_of(self, step, levels, nodes):
        """The heights of a vertical dimension at the nodes."""
        data = self.data
        if "zgrid" in data.variables and self._nodes == ("lonCell", "latCell"):
            faces = self.in_unit("zgrid", self.place("zgrid", step), "m", "m", "the heights between layers").T
            return faces if len(faces) == data.sizes[levels] else (faces[1:] + faces[:-1]) / 2
        for name, variable in data.variables.items():
            if levels in variable.dims and self._is_formula(name):
                return self._formula(name, step, nodes)
            told = data.text(name, "standard_name"), data.text(name, "positive").lower()
            known = name in ZCOR or told[0] in (*HEIGHTS, "depth") or told[1] in ("up", "down")
            if known and set(self.long(name)) == {levels, self._node} and variable.dtype.kind == "f":
                z = self.placed(name, self._field(name, step, self._node, ()), True)
                z = self.in_unit(name, z, "m", "m" * (name in ZCOR), "the height or depth of layers")
                return -z if told[1] == "down" or told == ("depth", "") else z
        if levels in data.variables:
            return numpy.repeat(heights_of_axis(self, levels)[:, None], nodes, axis=1)
        raise InputError(
            f"{self.path}: nothing tells the heights of the levels '{levels}': neither formula_terms nor a variable of "
            "heights"
        )

    def _is_formula(self, name):
        return self.data.text(name, "standard_name") in TERMS and self.data.variables[name].ndim <= 2

    def _formula(self, axis, step, nodes):
        kind = self.data.text(axis, "standard_name")
        if kind != "ocean_sigma_coordinate":
            raise InputError(f"{self.path}: levels of the kind {kind} are not read on a mesh")
        z, _ = by_formula(self, axis, step, True, METRES if "nv" in self.data.variables else None, 1, axis)
        return numpy.broadcast_to(z, (len(z), nodes))


def _edges(z):
    """Heights half way between the layers', and as far beyond the outer ones."""
    middle = (z[1:] + z[:-1]) / 2
    return numpy.concatenate([z[:1] - (middle[:1] - z[:1]), middle, z[-1:] + (z[-1:] - middle[-1:])])
