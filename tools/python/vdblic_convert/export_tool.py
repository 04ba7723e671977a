"""vdblic_export: volumes into files for VTK, ParaView and NumPy, and into layers of USD."""

import errno
import io
import os
import re
import resource
import zipfile

from vdblic._core import Sequence, check_output, read_metadata, write_file

from . import levels
from .console import printable
from .errors import InputError, OutputError, ParameterError, needed
from .metadata import number_of
from .outputs import Outputs, check_not_inputs
from .tool import Tool
from .usd_export import add_options, export_layer, refuse_options
from .velocity import names_of

# Names of arrays that files hold beside the grids.
_TAKEN = {".npz": ("active", "matrix", "time", "dt", "frame"), ".vti": ("active", "vtkGhostType")}


def main(version, words):
    tool = Tool(
        "vdblic_export",
        version,
        (
            "Convert volumes, textures or velocities, into images of VTK (.vti, with a .pvd list of times) or NumPy's"
            " .npz, name their files in a layer of USD (.usda), or write coarser copies (.vdb)."
        ),
    )
    tool.add(
        "input",
        metavar="INPUT",
        help=(
            "Volumes. One file, a pattern (name.%%04d.vdb, also ####, @@@@, $F4, <F4>), or - for paths on standard"
            " input."
        ),
    )
    tool.add(
        "-o", "--output", metavar="TEXT", required=True, help="What to write: lic_%%04d.vti, .npz, .vdb, or flow.usda."
    )
    tool.sequence()
    tool.add("--grids", metavar="TEXT", help="Grids to export: NAME,NAME; all of numbers and vectors by default.")
    levels.add_options(tool)
    add_options(tool)
    return tool.run(words, lambda options, console, stop: run(options, console, stop, version))


def run(options, console, stop, version):
    """Convert every selected frame, or name them all in a layer."""
    if options.output.lower().endswith(".usda"):
        export_layer(options, console, stop, version)
        return
    refuse_options(options)
    if options.output.lower().endswith(".vdb"):
        levels.export_levels(options, console, stop)
        return
    if options.levels:
        raise ParameterError("--levels writes .vdb files; give -o lic.%04d.vdb, or a .usda that has them as a proxy")
    names = names_of(options.grids) if options.grids else ()
    outputs = Outputs(options, [".vti", ".npz", ".usda", ".vdb"], console, stop)
    times = TimeList(outputs.pattern) if options.output.lower().endswith(".vti") and outputs.pattern.has_field else None
    files = Sequence(options.input, options.frames, options.clamp_frames, options.renumber, stop.check)
    if options.input != "-":
        files = list(files)
        outputs.check([frame for frame, _ in files], [path for _, path in files], len(files))
        if times:
            times.check([path for _, path in files])
    path, told = None, []
    try:
        for frame, source in files:
            path = outputs.write(frame, source, lambda path, source=source: _write(path, source, names, console, told))
            if times:
                times.add(frame, source, path)
    finally:
        if times and times.entries:  # of finished steps, also when the run is stopped
            console.finished(times.write())
    if path is None:
        raise InputError("standard input names no files")


def _write(path, source, names, console, told):
    """Convert a file. `told` holds what was said of the files before."""
    from .dense import read_dense  # NumPy and VTK take long to load

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
    from .vtk_data import GHOSTS, HIDDEN_POINT, add_array, bridge, errors_of, model

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
    scalars = next((name for name, values in volume.arrays.items() if values.ndim == 3), None)
    vectors = next((name for name, values in volume.arrays.items() if values.ndim == 4), None)
    if scalars:
        points.SetActiveScalars(names.get(volume.metadata.get("texture"), names[scalars]))
    if vectors:
        points.SetActiveVectors(names[vectors])
    time = number_of(volume.metadata, "time")
    if time is not None:
        stamp = bridge.numpy_to_vtk(numpy.array([time]), deep=True)
        stamp.SetName("TimeValue")
        image.GetFieldData().AddArray(stamp)
    writer = needed("vtkmodules.vtkIOXML").vtkXMLImageDataWriter()
    writer.SetInputData(image)
    writer.SetCompressorTypeToLZ4()
    writer.EncodeAppendedDataOff()

    # The bytes stay in memory, because VTK does not notice every write that fails.
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
