"""vdblic_export: volumes into files for VTK, ParaView and NumPy."""

import io
import os
import pathlib

from .errors import ParameterError
from .files import bytes_of, check_not_inputs, check_output, write_file
from .tool import MOST_NUMBER, Tool, whole
from .velocity import names_of


def main(version, words):
    tool = Tool(
        "vdblic_export",
        version,
        (
            "Convert volumes, textures or velocities, into images of VTK (.vti, with a .pvd list of times) or NumPy's"
            " .npz."
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
    tool.add("-o", "--output", metavar="TEXT", required=True, help="Files to write, such as lic_%%04d.vti, or .npz.")
    tool.add(
        "--frames", metavar="TEXT", help="Frames to use: 1-100, 1-100x2 or 1,5,9-20; every frame found by default."
    )
    tool.add(
        "--renumber",
        metavar=f"INT:INT in [{-MOST_NUMBER} - {MOST_NUMBER}]",
        type=whole(-MOST_NUMBER, MOST_NUMBER),
        help="Number paths on standard input from this number on as they come, whatever their names.",
    )
    tool.add(
        "--skip-existing", action="store_true", help="Leave outputs that are there as they are, and print their paths."
    )
    tool.add("--grids", metavar="TEXT", help="Grids to export: NAME,NAME; all of numbers and vectors by default.")
    return tool.run(words, run)


def run(options, console, stop):
    """Convert every selected frame."""
    from .sequences import Outputs, Pattern, numbered, parse_frames, paths_on_standard_input

    names = names_of(options.grids) if options.grids else ()
    outputs = Outputs(options, [".vti", ".npz"], console, stop)
    chosen = parse_frames(options.frames) if options.frames else None
    times = TimeList(outputs.pattern) if options.output.lower().endswith(".vti") and outputs.pattern.has_field else None
    if options.input == "-":
        if chosen:
            raise ParameterError("--frames cannot select from paths on standard input")
        files = _streamed(options.renumber, paths_on_standard_input(stop), numbered)
    elif options.renumber is not None:
        raise ParameterError("--renumber is for paths on standard input; a pattern has the numbers")
    else:
        files = Pattern(options.input).select(chosen)
        outputs.check([frame for frame, _ in files], [path for _, path in files], len(files))
        if times:
            times.check([path for _, path in files])
    try:
        for frame, source in files:
            path = outputs.write(frame, source, lambda output, source=source: _data(output, source, names, console))
            if times:
                times.add(frame, source, path)
    finally:
        if times and times.entries:  # of what is finished, also when the run is stopped
            console.finished(times.write())


def _streamed(number, paths, numbered):
    taken = {}
    for path in paths:
        yield numbered(path, number, taken), path
        number = None if number is None else number + 1


def _data(output, source, names, console):
    """The bytes of one output."""
    from .dense import read_dense

    volume = read_dense(source, names, console)
    return _image(output, volume) if str(output).lower().endswith(".vti") else _arrays(volume)


def _arrays(volume):
    """The .npz file of a volume, as vdblic_import reads it."""
    import numpy

    place = {"active": volume.active, "matrix": volume.matrix}
    place |= {key: volume.metadata[key] for key in ("time", "dt", "frame") if key in volume.metadata}
    data = io.BytesIO()
    numpy.savez(data, **volume.arrays, **place)
    return data.getbuffer()


def _image(output, volume):
    """The .vti file of a volume: its voxels are the image's points."""
    import numpy
    from .errors import needed
    from .vtk_data import add_array, bridge, errors_of, model

    spacing = numpy.linalg.norm(volume.matrix[:3, :3], axis=0)
    image = model.vtkImageData()
    image.SetDimensions(*volume.active.shape)
    image.SetOrigin(*volume.matrix[:3, 3])
    image.SetSpacing(*spacing)
    image.SetDirectionMatrix(*(volume.matrix[:3, :3] / spacing).ravel())
    points = image.GetPointData()
    for name, values in {**volume.arrays, "active": volume.active.astype(numpy.uint8)}.items():
        values = values.reshape(*volume.active.shape, -1)
        add_array(points, name, values.transpose(2, 1, 0, 3).reshape(-1, values.shape[3]))
    scalars = next((name for name, values in volume.arrays.items() if values.ndim == 3), None)
    vectors = next((name for name, values in volume.arrays.items() if values.ndim == 4), None)
    if scalars:
        points.SetActiveScalars(volume.metadata.get("texture", scalars) if scalars else scalars)
    if vectors:
        points.SetActiveVectors(vectors)
    if "time" in volume.metadata:
        stamp = bridge.numpy_to_vtk(numpy.array([float(volume.metadata["time"])]), deep=True)
        stamp.SetName("TimeValue")
        image.GetFieldData().AddArray(stamp)
    writer = needed("vtkmodules.vtkIOXML").vtkXMLImageDataWriter()
    writer.SetInputData(image)
    writer.SetCompressorTypeToLZ4()
    writer.EncodeAppendedDataOff()

    def write(name):
        writer.SetFileName(name)
        writer.Write()

    with errors_of(output):
        return bytes_of(output, write)


class TimeList:
    """ParaView's .pvd list of files and their times."""

    def __init__(self, pattern):
        self._path = pattern.companion(".pvd")
        self.entries = []

    def check(self, inputs):
        check_output(self._path)
        check_not_inputs([self._path], inputs)

    def add(self, frame, source, output):
        """Add a file; without a time in the volume it gets the frame's number."""
        from .volumes import metadata_of

        time = metadata_of(source).get("time", frame)
        name = os.path.relpath(output, self._path.parent)
        self.entries.append(f'    <DataSet timestep="{float(time)!r}" part="0" file="{_escaped(name)}"/>\n')

    def write(self):
        text = (
            '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n '
            f' <Collection>\n{"".join(self.entries)}  </Collection>\n</VTKFile>\n'
        )
        write_file(self._path, text.encode())
        return pathlib.Path(self._path)


def _escaped(name):
    from xml.sax.saxutils import escape

    return escape(name, {'"': "&quot;"})
