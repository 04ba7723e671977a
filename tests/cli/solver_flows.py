"""Files of two solvers' forms, AMReX's plot files and Plot3D: as their manuals describe them."""

import struct

import numpy

DOUBLES = "((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))"  # little endian, as AMReX says it


def box(low, high):
    return "((" + ") (".join(",".join(map(str, part)) for part in (low, high, (0, 0, 0))) + "))"


def write_amrex(folder, levels, names, flow, time=0.25, spacing=1.0):
    """Plot file of cells in boxes. `levels` has, for each, a list of boxes (low, high) in its cells; `flow` gives values."""
    fine = len(levels) - 1
    domains = [(tuple(numpy.min([low for low, _ in boxes], axis=0)), tuple(numpy.max([high for _, high in boxes], axis=0)))
               for boxes in levels[:1]]
    domains += [(tuple(2 ** n * numpy.array(domains[0][0])), tuple(2 ** n * (numpy.array(domains[0][1]) + 1) - 1))
                for n in range(1, fine + 1)]
    low, high = domains[0]
    steps = [spacing / 2 ** n for n in range(fine + 1)]
    text = ["HyperCLaw-V1.1", len(names), *names, 3, time, fine, " ".join(str(spacing * n) for n in low),
            " ".join(str(spacing * (n + 1)) for n in high), " ".join(["2"] * fine), " ".join(box(*d) for d in domains),
            " ".join(["10"] * (fine + 1)), *(" ".join([str(step)] * 3) for step in steps), 0, 0]
    for level, (boxes, step) in enumerate(zip(levels, steps)):
        text += [f"{level} {len(boxes)} {time}", 10]
        for low, high in boxes:
            text += [f"{step * a} {step * (b + 1)}" for a, b in zip(low, high)]
        text += [f"Level_{level}/Cell"]
        (folder / f"Level_{level}").mkdir(parents=True)
        data, places, ranges = b"", [], []
        for low, high in boxes:
            axes = [step * (numpy.arange(a, b + 1) + 0.5) for a, b in zip(low, high)]
            z, y, x = numpy.meshgrid(*axes[::-1], indexing="ij")
            values = flow(numpy.stack([x, y, z], axis=-1), level)
            places.append(f"FabOnDisk: Cell_D_00000 {len(data)}")
            ranges.append([values.min(axis=(0, 1, 2)), values.max(axis=(0, 1, 2))])
            data += f"FAB {DOUBLES}{box(low, high)} {len(names)}\n".encode()
            data += b"".join(values[..., i].astype("<f8").tobytes() for i in range(len(names)))
        (folder / f"Level_{level}/Cell_D_00000").write_bytes(data)
        lines = ["1", "1", str(len(names)), "0", f"({len(boxes)} 0", *(box(*b) for b in boxes), ")", str(len(boxes)), *places, ""]
        for end in 0, 1:
            lines += [f"{len(boxes)},{len(names)}", *("".join(f"{v:.17e}," for v in part[end]) for part in ranges), ""]
        (folder / f"Level_{level}/Cell_H").write_text("\n".join(lines) + "\n", encoding="ascii")
    (folder / "Header").write_text("\n".join(map(str, text)) + "\n", encoding="ascii")


def write_plot3d(grid, solution, blocks, flow, **form):
    """A grid (x, y, z [, marks of points that count]) and a solution (density, momentum, energy), block by block.

    `blocks` are arrays of positions (z, y, x, 3). The form: `order` of bytes, `records` of Fortran, `many` blocks,
    `width` of numbers, `marks` of points, `flat` for files of planes, `text`.
    """
    form = {"order": "<", "records": False, "many": True, "width": 8, "marks": None, "flat": False, "text": False} | form
    dimension = 2 if form["flat"] else 3
    numbers = f"{form['order']}f{form['width']}"

    def record(*parts):
        if form["text"]:
            return (" ".join(repr(value) for part in parts for value in numpy.ravel(part).tolist()) + "\n").encode()
        data = b"".join(numpy.ascontiguousarray(part).tobytes() for part in parts)
        mark = struct.pack(form["order"] + "i", len(data)) if form["records"] else b""
        return mark + data + mark

    whole = lambda values: numpy.array(values, f"{form['order']}i4")
    sizes = [at.shape[2::-1][:dimension] for at in blocks]
    head = (record(whole(len(blocks))) if form["many"] else b"") + record(whole(sizes))
    places, values = head, head
    for at in blocks:
        parts = [at[..., i].astype(numbers) for i in range(dimension)]
        places += record(*parts, *([whole(form["marks"](at))] if form["marks"] else []))
        density = 1 + 0.1 * at[..., 0]
        momentum = [(density * part).astype(numbers) for part in numpy.moveaxis(flow(at), -1, 0)[:dimension]]
        values += record(numpy.array([0.5, 0, 1e5, 3], numbers))
        values += record(density.astype(numbers), *momentum, (2.5 + 0 * density).astype(numbers))
    grid.write_bytes(places)
    solution.write_bytes(values)
