"""Files of other programs that hold a known flow, for the tests of vdblic_import.

The flow is linear in space, so that interpolation on any cells is exact, and grows with time.
"""


import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import (vtkImageData, vtkMultiBlockDataSet, vtkRectilinearGrid, vtkStructuredGrid,
                                           vtkUnstructuredGrid)
from vtkmodules.vtkFiltersCore import vtkProbeFilter
from vtkmodules.vtkFiltersGeneral import vtkDataSetTriangleFilter
from vtkmodules.vtkIOLegacy import vtkGenericDataObjectWriter
from vtkmodules.vtkIOXML import vtkXMLDataObjectWriter

GRADIENT = numpy.array([[0.2, -1.5, 0.3], [1.5, 0.1, -0.4], [0.25, 0.6, -0.3]])
MEAN = numpy.array([1.0, -2.0, 0.5])


def flow(positions, time=0.0):
    """The velocity at positions (..., 3)."""
    return (MEAN + positions @ GRADIENT.T) * (1 + time)


def pressure(positions):
    return 3 + positions @ (1.0, 2.0, -1.0)


def axes(sizes=(9, 7, 5), warp=0.0):
    """Coordinates along each axis from 1 to 3, from -1 to 1, from 0 to 1; `warp` makes them uneven."""
    ends = (1, 3), (-1, 1), (0, 1)
    return [low + (high - low) * (t := numpy.linspace(0, 1, n)) ** (1 + warp) for n, (low, high) in zip(sizes, ends)]


def grid_positions(x, y, z):
    """Positions (z, y, x, 3), as VTK orders points."""
    z, y, x = numpy.meshgrid(z, y, x, indexing="ij")
    return numpy.stack([x, y, z], axis=-1)


def add(data, name, values):
    array = numpy_to_vtk(numpy.ascontiguousarray(values).reshape(-1, *values.shape[3:]), deep=True)
    array.SetName(name)
    data.AddArray(array)


def fill(grid, positions, time, cells=False):
    """Put velocity `U` and scalar `p` on a grid, and the time where VTK keeps it."""
    data = grid.GetCellData() if cells else grid.GetPointData()
    add(data, "U", flow(positions, time))
    add(data, "p", pressure(positions))
    stamp = numpy_to_vtk(numpy.array([time]), deep=True)
    stamp.SetName("TimeValue")
    grid.GetFieldData().AddArray(stamp)
    return grid


def image(time=0.0, sizes=(9, 7, 5), cells=False):
    x, y, z = axes(sizes)
    grid = vtkImageData()
    grid.SetDimensions(*sizes)
    grid.SetOrigin(x[0], y[0], z[0])
    grid.SetSpacing(x[1] - x[0], y[1] - y[0], z[1] - z[0])
    if cells:
        x, y, z = ((a[1:] + a[:-1]) / 2 for a in (x, y, z))
    return fill(grid, grid_positions(x, y, z), time, cells)


def rectilinear(time=0.0, axes=axes(warp=0.3)):
    grid, (x, y, z) = vtkRectilinearGrid(), axes
    grid.SetDimensions(len(x), len(y), len(z))
    grid.SetXCoordinates(numpy_to_vtk(x, deep=True))
    grid.SetYCoordinates(numpy_to_vtk(y, deep=True))
    grid.SetZCoordinates(numpy_to_vtk(z, deep=True))
    return fill(grid, grid_positions(x, y, z), time)


def structured(time=0.0, part=slice(None), axes=axes(), rise=0.2):
    """A grid whose layers follow a bottom that rises with x."""
    x, y, z = axes
    positions = grid_positions(x[part], y, z)
    positions[..., 2] += rise * (positions[..., 0] - 1) * (1 - positions[..., 2])
    grid, points = vtkStructuredGrid(), vtkPoints()
    points.SetData(numpy_to_vtk(positions.reshape(-1, 3), deep=True))
    grid.SetDimensions(*positions.shape[2::-1])
    grid.SetPoints(points)
    return fill(grid, positions, time)


def tetrahedra(time=0.0):
    split = vtkDataSetTriangleFilter()
    split.SetInputData(image(time))
    split.Update()
    return split.GetOutput()


def blocks(time=0.0):
    """Two grids side by side in a multi-block."""
    whole = vtkMultiBlockDataSet()
    whole.SetBlock(0, structured(time, slice(0, 5)))
    whole.SetBlock(1, structured(time, slice(4, None)))
    return whole


def probed(data, positions, name):
    """An array of VTK's data at positions, by its own probe, and where it has values."""
    points, cloud, probe = vtkPoints(), vtkUnstructuredGrid(), vtkProbeFilter()
    points.SetData(numpy_to_vtk(positions.reshape(-1, 3), deep=True))
    cloud.SetPoints(points)
    probe.SetInputData(cloud)
    probe.SetSourceData(data)
    probe.Update()
    data = probe.GetOutput().GetPointData()
    return vtk_to_numpy(data.GetArray(name)), vtk_to_numpy(data.GetArray("vtkValidPointMask")) != 0


def write_vtk(data, path):
    """Write VTK's data in the format of the path's ending."""
    writer = vtkGenericDataObjectWriter() if path.suffix == ".vtk" else vtkXMLDataObjectWriter()
    if data.IsA("vtkMultiBlockDataSet"):
        from vtkmodules.vtkIOXML import vtkXMLMultiBlockDataWriter
        writer = vtkXMLMultiBlockDataWriter()
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    assert writer.Write() == 1


def write_pvd(folder, times):
    """A .pvd list of .vtu files."""
    entries = ""
    for i, time in enumerate(times):
        write_vtk(tetrahedra(time), folder / f"part{i}.vtu")
        entries += f'<DataSet timestep="{time}" part="0" file="part{i}.vtu"/>'
    (folder / "flow.pvd").write_text(
        f'<VTKFile type="Collection"><Collection>{entries}</Collection></VTKFile>', encoding="utf-8")


def write_ensight(folder, times):
    """An EnSight Gold case of one block."""
    positions = grid_positions(*axes())
    sizes = " ".join(map(str, positions.shape[2::-1]))
    column = lambda values: "\n".join(f"{value:12.5e}" for value in values.reshape(-1, 3).T.ravel())
    (folder / "flow.geo").write_text("a box\nof points\nnode id assign\nelement id assign\npart\n1\nbox\nblock\n"
                                     f"{sizes}\n{column(positions)}\n", encoding="utf-8")
    for step, time in enumerate(times):
        values = column(flow(positions, time))
        (folder / f"flow.U.{step:04}").write_text(f"U\npart\n1\nblock\n{values}\n", encoding="utf-8")
    (folder / "flow.case").write_text(
        "FORMAT\ntype: ensight gold\n\nGEOMETRY\nmodel: flow.geo\n\nVARIABLE\nvector per node: 1 U flow.U.****\n\n"
        f"TIME\ntime set: 1\nnumber of steps: {len(times)}\nfilename start number: 0\nfilename increment: 1\n"
        f"time values: {' '.join(map(str, times))}\n", encoding="utf-8")


def write_ensight_cells(folder, gold=True):
    """An EnSight case of hexahedra, flow.case: Gold in two parts with numbers of nodes, or the older form in one."""
    sizes = nx, ny, nz = 5, 4, 3
    nodes = grid_positions(*axes(sizes)).reshape(-1, 3)
    first = lambda i, j, k: i + nx * (j + ny * k) + 1
    corners = [[first(i + a, j + b, k + c) for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
               for k in range(nz - 1) for j in range(ny - 1) for i in range(nx - 1)]
    column = lambda values: "".join(f"{value:12.5e}\n" for value in values.T.ravel())
    rows = lambda table, form, n: "".join("".join(form % x for x in line) + "\n" for line in
                                          (table[i:i + n] for i in range(0, len(table), n)))
    hexahedra = lambda form: f"hexa8\n{form % len(corners)}\n{rows(sum(corners, []), form, 8)}"
    geometry, values = "a box\nof cells\nnode id given\nelement id assign\n", "U\n"
    if gold:
        for part in 1, 2:
            at = nodes + [2 * (part - 1), 0, 0]
            numbers = "".join(f"{i:10}\n" for i in range(len(at)))
            geometry += (f"part\n{part:10}\nblock of cells\ncoordinates\n{len(at):10}\n{numbers}{column(at)}"
                         f"{hexahedra('%10d')}")
            values += f"part\n{part:10}\ncoordinates\n{column(flow(at))}"
    else:
        lines = "".join(f"{i:8}{x:12.5e}{y:12.5e}{z:12.5e}\n" for i, (x, y, z) in enumerate(nodes, 1))
        geometry += f"coordinates\n{len(nodes):8}\n{lines}part 1\nbox\n{hexahedra('%8d')}"
        values += rows(flow(nodes).ravel(), "%12.5e", 6)
    (folder / "flow.geo").write_text(geometry, encoding="utf-8")
    (folder / "flow.U").write_text(values, encoding="utf-8")
    (folder / "flow.case").write_text(f"FORMAT\ntype: ensight{' gold' if gold else ''}\n\nGEOMETRY\nmodel: flow.geo\n\n"
                                      "VARIABLE\nvector per node: U flow.U\n", encoding="utf-8")


FOAM_HEADER = "FoamFile {{ version 2.0; format ascii; class {kind}; location \"{place}\"; object {name}; }}\n"


def write_foam(folder, times, pieces=1, sizes=(8, 6, 4)):
    """An OpenFOAM case of a box of hexahedra, in one piece or decomposed along x."""
    (folder / "system").mkdir(parents=True)
    (folder / "system/controlDict").write_text(
        FOAM_HEADER.format(kind="dictionary", place="system", name="controlDict") +
        "application none; startFrom startTime; startTime 0; stopAt endTime; endTime 10; deltaT 0.5;\n"
        "writeControl timeStep; writeInterval 1; writeFormat ascii; writePrecision 8; timeFormat general;\n", encoding="utf-8")
    x, y, z = axes([n + 1 for n in sizes])
    for piece, cells in enumerate(numpy.array_split(numpy.arange(sizes[0]), pieces)):
        place = folder / f"processor{piece}" if pieces > 1 else folder
        edges = x[cells[0]:cells[-1] + 2], y, z
        _write_mesh(place / "constant/polyMesh", *edges)
        centres = grid_positions(*((a[1:] + a[:-1]) / 2 for a in edges)).reshape(-1, 3)
        for time in times:
            (place / f"{time:g}").mkdir()
            velocity = "\n".join(f"({u:.8g} {v:.8g} {w:.8g})" for u, v, w in flow(centres, time))
            (place / f"{time:g}/U").write_text(
                FOAM_HEADER.format(kind="volVectorField", place=f"{time:g}", name="U") +
                "dimensions [0 1 -1 0 0 0 0];\n"
                f"internalField nonuniform List<vector>\n{len(centres)}\n(\n{velocity}\n);\n"
                "boundaryField { walls { type zeroGradient; } }\n", encoding="utf-8")


def _write_mesh(folder, x, y, z):
    """OpenFOAM's mesh of a box: faces between cells first, then those of the walls."""
    folder.mkdir(parents=True)
    nx, ny, nz = len(x) - 1, len(y) - 1, len(z) - 1
    point = lambda i, j, k: i + (nx + 1) * (j + (ny + 1) * k)
    cell = lambda i, j, k: i + nx * (j + ny * k)
    inner, outer = [], []
    for k in range(nz):
        for j in range(ny):
            for i in range(nx):
                here, corner = (i, j, k), numpy.array((i, j, k))
                for axis, count in enumerate((nx, ny, nz)):
                    a, b = numpy.eye(3, dtype=int)[(axis + 1) % 3], numpy.eye(3, dtype=int)[(axis + 2) % 3]
                    for side in 0, 1:
                        start = corner + side * numpy.eye(3, dtype=int)[axis]
                        loop = [start, start + a, start + a + b, start + b][::1 if side else -1]
                        face = [point(*p) for p in loop]
                        other = corner + (2 * side - 1) * numpy.eye(3, dtype=int)[axis]
                        if not 0 <= other[axis] < count:
                            outer.append((face, cell(*here), None))
                        elif side:
                            inner.append((face, cell(*here), cell(*other)))
    inner.sort(key=lambda face: face[1:])
    faces = inner + outer
    points = grid_positions(x, y, z).reshape(-1, 3)

    def put(name, kind, entries):
        head = FOAM_HEADER.format(kind=kind, place="constant/polyMesh", name=name)
        (folder / name).write_text(f"{head}{len(entries)}\n(\n" + "\n".join(entries) + "\n)\n", encoding="utf-8")

    put("points", "vectorField", [f"({a:.8g} {b:.8g} {c:.8g})" for a, b, c in points])
    put("faces", "faceList", [f"4({' '.join(map(str, face))})" for face, _, _ in faces])
    put("owner", "labelList", [str(owner) for _, owner, _ in faces])
    put("neighbour", "labelList", [str(neighbour) for _, _, neighbour in inner])
    put("boundary", "polyBoundaryMesh", [f"walls {{ type wall; nFaces {len(outer)}; startFace {len(inner)}; }}"])
