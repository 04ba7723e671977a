"""VTK's own files, in XML and legacy form, and ParaView's .pvd lists of them."""

import json
import re
import xml.etree.ElementTree

from ..errors import InputError, needed
from ..vtk_data import arrays_of, blocks_of, bridge, check_cells, errors_of, merged, model
from . import Source

PARTS = {".pvti": "ImageData", ".pvtr": "RectilinearGrid", ".pvts": "StructuredGrid", ".pvtu": "UnstructuredGrid",
         ".pvtp": "PolyData"}  # fmt: skip
TIME_ARRAYS = ("TimeValue", "TIME", "time")


def open_source(path, options):  # pylint: disable=unused-argument
    return PvdFile(path) if path.suffix.lower() in (".pvd", ".series") else VtkFile(path)


def _reader_of(path):
    """VTK's reader of a file. Raises InputError."""
    ending = path.suffix.lower()
    if ending == ".vtk":
        reader = needed("vtkmodules.vtkIOLegacy").vtkGenericDataObjectReader()
        for kind in "Scalars", "Vectors", "Fields", "Tensors", "Normals":  # not only the first of each
            getattr(reader, f"ReadAll{kind}On")()
        return reader
    xml_io = needed("vtkmodules.vtkIOXML")
    if ending in PARTS:
        return getattr(xml_io, f"vtkXMLP{PARTS[ending]}Reader")()
    with open(path, "rb") as file:
        root = re.search(rb'<VTKFile type="(\w+)" version="([\d.]+)', file.read(1024))
    if not root or not re.search(b"Hierarchical|AMR", root[1]):
        return xml_io.vtkXMLGenericDataObjectReader()
    if float(root[2]) < 1.1:  # VTK would end the process
        raise InputError(f"{path}: VTK cannot read levels in the form of {root[2].decode()}, but from 1.1 on")
    reader = xml_io.vtkXMLUniformGridAMRReader()
    reader.SetMaximumLevelsToReadByDefault(0)  # which is all of them
    return reader


def read_file(path, notes):
    """The data set of one file. `notes` receives messages for the user. Raises InputError."""
    reader, lacking = _reader_of(path), None
    reader.SetFileName(str(path))
    while True:
        try:
            with errors_of(path):
                reader.Update()
            break
        except InputError as error:
            lacking = re.search("Piece (point|cell) data array (.*) not found", str(error))
            if not lacking:
                raise
            notes.append(f"{path}: a piece lacks the array {lacking[2]}, which is left out")
            getattr(reader, f"Get{lacking[1].capitalize()}DataArraySelection")().DisableArray(lacking[2])
    data = reader.GetOutputDataObject(0)
    if not any(block.GetNumberOfPoints() for block in blocks_of(data)):
        raise InputError(f"{path}: cannot be read as a VTK file, or it has no points")
    check_cells(data, path)
    for block in blocks_of(data):
        if block.IsA("vtkImageData"):  # a plane may have no spacing across it
            spacing = block.GetSpacing()
            usual = min((size for size in spacing if size > 0), default=1.0)
            block.SetSpacing([size or (usual if n == 1 else 0) for n, size in zip(block.GetDimensions(), spacing)])
    if path.suffix.lower() == ".pvtu" and data.GetCellData().GetNumberOfArrays():  # the pieces' points are apart
        whole, data = data, merged([data], list(arrays_of(data)))
        data.GetFieldData().ShallowCopy(whole.GetFieldData())
    return data


def time_of(data):
    """The time in the field data of a data set or of one of its blocks, if there is one."""
    for block in (data, *blocks_of(data)):
        for name in TIME_ARRAYS:
            values = block.GetFieldData().GetArray(name)
            if values is not None and values.GetNumberOfValues() > 0:
                return float(bridge.vtk_to_numpy(values).ravel()[0])
    return None


class VtkSource(Source):
    """Data sets of VTK, one step in memory at a time. `load(step)` reads it."""

    def __init__(self, path, times, notes=()):
        super().__init__(path, times)
        self._notes = notes
        self._step, self._data = None, None

    def load(self, step):
        raise NotImplementedError

    def arrays(self, step):
        return arrays_of(self.read(step, ()))

    def read(self, step, names):
        if self._step != step or self._data is None:
            self._data = None  # its memory, before the next one is read
            self._step, self._data = step, self.load(step)
        return self._data

    def free(self):
        self._data = None

    def notes(self):
        return self._notes


class VtkFile(VtkSource):
    """One file is one step."""

    def __init__(self, path):
        super().__init__(path, [None], [])
        self.times = [time_of(self.read(0, ()))]

    def load(self, step):
        self._notes.clear()
        return read_file(self.path, self._notes)


def _listed(path):
    """The files of a .pvd or .series, as (time, part, file); without times each is a step. Raises InputError."""
    try:
        if path.suffix.lower() == ".series":
            with open(path, encoding="utf-8") as file:
                found = [(entry.get("time"), None, entry["name"]) for entry in json.load(file)["files"]]
        else:
            root = xml.etree.ElementTree.parse(path).getroot()
            found = [(e.get("timestep"), e.get("part"), e.get("file")) for e in root.iter("DataSet")]
        if found and all(time is None for time, *_ in found) and len({part for _, part, _ in found}) < len(found):
            return [(None, i, path.parent / file) for i, (*_, file) in enumerate(found)]
        return [(float(time or 0), part, path.parent / file) for time, part, file in found]
    except (xml.etree.ElementTree.ParseError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise InputError(f"{path}: cannot be read as a list of files: {error}") from None


class PvdFile(VtkSource):
    """A list of files with their times; the files of one time are parts of one data set, or the last of one part."""

    def __init__(self, path):
        entries, steps, notes = _listed(path), {}, []
        if not entries:
            raise InputError(f"{path}: the list names no files")
        for time, part, file in entries:
            if not file.is_file():
                raise InputError(f"{path}: the list names {file}, which does not exist")
            files = steps.setdefault(part if time is None else time, {})
            key = file if part is None or time is None else part
            if key in files:
                notes.append(f"{path}: {time:g} s is listed twice; {file.name} is taken")
            files[key] = file
        timeless = entries[0][0] is None
        order = list(steps) if timeless else sorted(steps)
        self._parts = [list(steps[step].values()) for step in order]
        super().__init__(path, [None] * len(order) if timeless else order, notes)

    def load(self, step):
        parts = [read_file(part, self._notes) for part in self._parts[step]]
        if len(parts) == 1:
            return parts[0]
        whole = model.vtkMultiBlockDataSet()
        for i, part in enumerate(parts):
            whole.SetBlock(i, part)
        return whole
