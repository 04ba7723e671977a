"""CGNS files as its own library writes them, in both forms, for the tests of vdblic_import."""

import ctypes

import numpy

import flows

FORMS = {"ADF": 1, "HDF5": 2}
WRITE, DOUBLE, VERTEX, STRUCTURED = 1, 4, 2, 2


def library():
    """VTK's copy of the library; None where there is none."""
    try:
        return ctypes.CDLL("libvtkcgns-9.1.so.1")
    except OSError:
        return None


def write(path, form):
    """A box of points with the known flow."""
    def call(name, *arguments):
        if getattr(library(), f"vtkcgns_cg_{name}")(*arguments):
            raise OSError(f"cg_{name} of {path}")

    def put(name, text, values, *before):
        values = numpy.ascontiguousarray(values, float)
        call(name, *before, DOUBLE, text.encode(), values.ctypes.data_as(ctypes.c_void_p), ctypes.byref(ctypes.c_int()))

    file, base, zone, solution = (ctypes.c_int() for _ in range(4))
    positions = flows.grid_positions(*flows.axes())
    points = positions.shape[2::-1]
    sizes = (ctypes.c_long * 9)(*points, *(n - 1 for n in points), 0, 0, 0)
    call("set_file_type", FORMS[form])
    call("open", str(path).encode(), WRITE, ctypes.byref(file))
    call("base_write", file, b"Base", 3, 3, ctypes.byref(base))
    call("zone_write", file, base, b"Zone", sizes, STRUCTURED, ctypes.byref(zone))
    call("sol_write", file, base, zone, b"Flow", VERTEX, ctypes.byref(solution))
    for axis, letter in enumerate("XYZ"):
        put("coord_write", f"Coordinate{letter}", positions[..., axis], file, base, zone)
        put("field_write", f"Velocity{letter}", flows.flow(positions)[..., axis], file, base, zone, solution)
    call("close", file)
