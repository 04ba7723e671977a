"""vdblic_export: volumes into files for VTK, ParaView and NumPy, and into layers of USD."""

import errno
import io
import os
import re
import resource
import zipfile

from vdblic._core import check_output, read_lines, read_metadata, write_file

from . import levels
from .console import printable
from .errors import InputError, OutputError, ParameterError, needed
from .metadata import number_of
from .html_export import add_page_options, export_page, refuse_page_options
from .outputs import Outputs, check_not_inputs, frames_of
from .tool import Tool
from .usd_export import add_options, export_layer, refuse_options
from .velocity import names_of

# Names of arrays that files hold beside the grids.
_TAKEN = {".npz": ("active", "matrix", "time", "dt", "frame"), ".vti": ("active", "vtkGhostType")}


def main(version, words):
    tool = Tool("vdblic_export", version,
                "Convert volumes, textures or velocities, into images of VTK (.vti, with a .pvd list of times) or NumPy's"
                " .npz, streaks into lines of VTK (.vtp) or USD (.usda) or a page that any browser shows (.html), name "
                "their files in a layer of USD (.usda), or write coarser copies (.vdb).")  # fmt: skip
    tool.add("input", metavar="INPUT", help="Volumes. One file, a pattern (name.%%04d.vdb, also ####, @@@@, $F4, <F4>), "
             "or - for paths on standard input.")  # fmt: skip
    tool.add("-o", "--output", metavar="TEXT", required=True,
             help="What to write: lic_%%04d.vti, .vtp, .npz, .vdb, flow.usda or flow.html.")  # fmt: skip
    tool.sequence()
    tool.add("--grids", metavar="TEXT", help="Grids to export: NAME,NAME; all of numbers and vectors by default, into a "
             ".usda the streaks alone where they are lines.")  # fmt: skip
    levels.add_options(tool)
    add_options(tool)
    add_page_options(tool)
    return tool.run(words, lambda options, console, stop: run(options, console, stop, version))


def run(options, console, stop, version):
    """Convert every selected frame, or name them all in a layer."""
    kind = os.path.splitext(options.output)[1].lower()
    if kind != ".html":
        refuse_page_options(options)
    if kind == ".usda":
        export_layer(options, console, stop, version)
        return
    refuse_options(options)
    if kind == ".html":
        export_page(options, console, stop)
        return
    if kind == ".vdb":
        levels.export_levels(options, console, stop)
        return
    if options.levels:
        raise ParameterError("--levels writes .vdb files; give -o lic.%04d.vdb, or a .usda that has them as a proxy")
    names = names_of(options.grids) if options.grids else ()
    outputs = Outputs(options, [".vti", ".vtp", ".npz", ".usda", ".vdb"], console, stop)
    times = TimeList(outputs.pattern) if kind in (".vti", ".vtp") and outputs.pattern.has_field else None

    def check(frames, sources):
        outputs.check(frames, sources)
        if times:
            times.check(sources)

    told = []
    try:
        for frame, source in frames_of(options, stop, check):
            path = outputs.write(frame, source, lambda path, source=source: _write(path, source, names, console, told))
            if times:
                times.add(frame, source, path)
    finally:
        if times and times.entries:  # of finished steps, also when the run is stopped
            console.finished(times.write())


def _write(path, source, names, console, told):
    """Convert a file. `told` holds the messages about earlier files."""
    from .dense import read_dense  # NumPy and VTK take long to load

    if path.suffix.lower() == ".vtp":
        write_file(path, _curves(path, source))
        return
    volume = read_dense(source, names, console)
    if volume.is_sparse and not told:
        told.append(source)
        console.say(
            f"{source}: {volume.active.mean():.1%} of the {volume.active.size / 1e6:.3g} million voxels of the"
            f" texture's box are active, and the file has all of them in each of {len(volume.arrays)} arrays; --grids"
            " selects some"
        )
    kind = path.suffix.lower()
    for name in volume.arrays:
        if name in _TAKEN[kind] or (kind == ".npz" and not (name and name.isprintable())):
            raise InputError(
                f"{source}: grid '{name}': an array of {kind} files cannot have this name; choose others with --grids"
            )
    write_file(path, _image(path, volume) if kind == ".vti" else _arrays(volume))


def _arrays(volume):
    """The .npz file of a volume, as vdblic_import reads it."""
    import numpy

    place = {"active": volume.active, "matrix": volume.matrix}
    numbers = {key: number_of(volume.metadata, key) for key in ("time", "dt", "frame")}
    place |= {key: volume.metadata[key] for key, value in numbers.items() if value is not None}
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as file:  # numpy.savez() has names of its own, such as `file`
        for name, values in (volume.arrays | place).items():
            with file.open(f"{name}.npy", "w", force_zip64=True) as array:
                numpy.lib.format.write_array(array, numpy.asanyarray(values), allow_pickle=False)
    return data.getbuffer()


def _image(output, volume):
    """The .vti file of a volume: its voxels are the image's points."""
    import numpy
    from .vtk_data import GHOSTS, HIDDEN_POINT, add_array, model

    spacing = numpy.linalg.norm(volume.matrix[:3, :3], axis=0)
    image = model.vtkImageData()
    image.SetDimensions(*volume.active.shape)
    image.SetOrigin(*volume.matrix[:3, 3])
    image.SetSpacing(*spacing)
    image.SetDirectionMatrix(*(volume.matrix[:3, :3] / spacing).ravel())
    points = image.GetPointData()
    names = {}  # placeholders, because VTK writes names as they are
    masks = {"active": volume.active}
    if not volume.is_sparse:  # empty space has the value 0
        masks[GHOSTS] = numpy.where(volume.active, 0, HIDDEN_POINT)
    for name, values in (volume.arrays | {name: mask.astype(numpy.uint8) for name, mask in masks.items()}).items():
        values = values.reshape(*volume.active.shape, -1)
        names[name] = name if name in masks else f"vdblic-array-{len(names)}"
        add_array(points, names[name], values.transpose(2, 1, 0, 3).reshape(-1, values.shape[3]))
    scalars, vectors = ([name for name, values in volume.arrays.items() if values.ndim == n] for n in (3, 4))
    if scalars:
        points.SetActiveScalars(names.get(str(volume.metadata.get("texture")), names[scalars[0]]))
    if vectors:
        points.SetActiveVectors(names[vectors[0]])
    _add_time(image, volume.metadata)
    return _file_of(needed("vtkmodules.vtkIOXML").vtkXMLImageDataWriter(), image, output, names)


def _curves(output, source):
    """The .vtp file of a file's streaks: polylines, with their scalars at the points."""
    import numpy
    from .vtk_data import add_array, bridge, core, model

    lines, metadata = read_lines(source)
    ends = numpy.concatenate([[0], numpy.cumsum(lines["counts"])]).astype(numpy.int64)
    points, cells, data = core.vtkPoints(), model.vtkCellArray(), model.vtkPolyData()
    points.SetData(bridge.numpy_to_vtk(lines["points"], deep=True))
    ids = (bridge.numpy_to_vtkIdTypeArray(values, deep=True) for values in (ends, numpy.arange(ends[-1])))
    cells.SetData(*ids)
    data.SetPoints(points)
    data.SetLines(cells)
    names = {}
    for name in "id", "source":
        add_array(data.GetCellData(), name, lines[name])
    for name, values in ({name: lines[name] for name in ("radius", "opacity", "age")} | lines["scalars"]).items():
        names[name] = f"vdblic-array-{len(names)}"
        add_array(data.GetPointData(), names[name], values)
    if "magnitude" in names:
        data.GetPointData().SetActiveScalars(names["magnitude"])
    _add_time(data, metadata)
    return _file_of(needed("vtkmodules.vtkIOXML").vtkXMLPolyDataWriter(), data, output, names)


def _add_time(data, metadata):
    import numpy
    from .vtk_data import add_array

    time = number_of(metadata, "time")
    if time is not None:
        add_array(data.GetFieldData(), "TimeValue", numpy.array([time]))


def _file_of(writer, data, output, names):
    """The bytes of a file of VTK. They stay in memory, because VTK does not notice every write that fails.

    @param names  of arrays in the file → their placeholders in the data, because VTK writes names as they are
    """
    from .vtk_data import errors_of

    writer.SetInputData(data)
    writer.SetCompressorTypeToLZ4()
    writer.EncodeAppendedDataOff()
    descriptor = os.memfd_create("output")
    with os.fdopen(descriptor, "rb") as file, errors_of(output):
        writer.SetFileName(f"/proc/self/fd/{descriptor}")
        writer.Write()
        data = file.read()
        limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
        if 0 <= limit <= len(data):
            raise OutputError(f"{output}: cannot be written: {os.strerror(errno.EFBIG)}")
    head, mark, values = data.partition(b"<AppendedData")
    escaped = {placeholder.encode(): xml_text(name).encode() for name, placeholder in names.items()}
    return re.sub(rb"vdblic-array-\d+(?=\")", lambda match: escaped[match[0]], head) + mark + values


def xml_text(text):
    """A text as the value of an attribute of XML, which knows neither control characters nor bytes that are no UTF-8."""
    from xml.sax.saxutils import escape

    return escape(printable(text), {'"': "&quot;"})


class TimeList:
    """ParaView's .pvd list of files and their times."""

    def __init__(self, pattern):
        common = os.path.commonprefix([pattern.path(frame).name for frame in (1, -1)]).rstrip("._- ")
        self._path = pattern.path(1).with_name(f"{common or 'frames'}.pvd")
        self.entries = []

    def check(self, inputs):
        check_output(self._path)
        check_not_inputs([self._path], inputs)

    def add(self, frame, source, output):
        """Add a file; without a time in the volume it gets the frame's number."""
        time = number_of(read_metadata(source), "time")
        time = float(frame) if time is None else time
        name = os.path.relpath(output, self._path.parent)
        self.entries.append(f'    <DataSet timestep="{time!r}" part="0" file="{xml_text(name)}"/>\n')

    def write(self):
        text = (
            '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n '
            f' <Collection>\n{"".join(self.entries)}  </Collection>\n</VTKFile>\n'
        )
        write_file(self._path, text.encode())
        return self._path
