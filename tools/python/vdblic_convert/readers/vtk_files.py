"""VTK's own files, in XML and legacy form, and ParaView's .pvd lists of them."""

import pathlib
import xml.etree.ElementTree

from ..errors import InputError, needed
from ..vtk_data import arrays_of, blocks_of, bridge, errors_of, model
from . import Source

TIME_ARRAYS = ("TimeValue", "TIME", "time")


def open_source(path, options):  # pylint: disable=unused-argument
    return PvdFile(path) if path.suffix.lower() == ".pvd" else VtkFile(path)


def read_file(path):
    """The data set of one file. Raises InputError."""
    if path.suffix.lower() == ".vtk":
        reader = needed("vtkmodules.vtkIOLegacy").vtkGenericDataObjectReader()
    elif path.suffix.lower().startswith(".pvt"):
        xml_io = needed("vtkmodules.vtkIOXML")
        reader = {
            "i": xml_io.vtkXMLPImageDataReader,
            "r": xml_io.vtkXMLPRectilinearGridReader,
            "s": xml_io.vtkXMLPStructuredGridReader,
            "u": xml_io.vtkXMLPUnstructuredGridReader,
        }[path.suffix[4].lower()]()
    else:
        reader = needed("vtkmodules.vtkIOXML").vtkXMLGenericDataObjectReader()
    with errors_of(path):
        reader.SetFileName(str(path))
        reader.Update()
    data = reader.GetOutputDataObject(0)
    if not any(block.GetNumberOfPoints() for block in blocks_of(data)):
        raise InputError(f"{path}: cannot be read as a VTK file, or it has no points")
    return data


def time_of(data):
    """The time in the field data of a data set or of one of its blocks, if there is one."""
    for block in (data, *blocks_of(data)):
        for name in TIME_ARRAYS:
            values = block.GetFieldData().GetArray(name)
            if values is not None and values.GetNumberOfValues() > 0:
                return float(bridge.vtk_to_numpy(values).ravel()[0])
    return None


class VtkFile(Source):
    """One file is one step."""

    def __init__(self, path):
        self._data = read_file(path)
        super().__init__(path, [time_of(self._data)])

    def arrays(self, step):
        return arrays_of(self.read(step, ()))

    def read(self, step, names):
        if self._data is None:
            self._data = read_file(self.path)
        return self._data

    def free(self):
        self._data = None


class PvdFile(Source):
    """A list of files with their times; the files of one time are parts of one data set."""

    def __init__(self, path):
        try:
            root = xml.etree.ElementTree.parse(path).getroot()
            entries = [
                (float(entry.get("timestep", 0)), path.parent / entry.get("file")) for entry in root.iter("DataSet")
            ]
        except (xml.etree.ElementTree.ParseError, UnicodeDecodeError, ValueError, TypeError) as error:
            raise InputError(f"{path}: cannot be read as a list of files: {error}") from None
        if not entries:
            raise InputError(f"{path}: the list names no files")
        self._parts = {}
        for time, part in entries:
            if not part.is_file():
                raise InputError(f"{path}: the list names {part}, which does not exist")
            self._parts.setdefault(time, []).append(pathlib.Path(part))
        self._read = None, None  # the last step and its data: a step is read once
        super().__init__(path, sorted(self._parts))

    def arrays(self, step):
        return arrays_of(self.read(step, ()))

    def read(self, step, names):
        if self._read[0] != step:
            self._read = None, None
            parts = [read_file(part) for part in self._parts[self.times[step]]]
            whole = parts[0]
            if len(parts) > 1:
                whole = model.vtkMultiBlockDataSet()
                for i, part in enumerate(parts):
                    whole.SetBlock(i, part)
            self._read = step, whole
        return self._read[1]

    def free(self):
        self._read = None, None
