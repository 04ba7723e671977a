"""A sequence of volumes as a layer of USD in its text form: a Volume whose fields name the files, and a camera.

Fields and volume follow OpenUSD's schemas UsdVol (Volume, OpenVDBAsset), the camera UsdGeomCamera. World space is that
of the files: OpenVDB's, a voxel half an index to each side of its centre. No USD library is needed.
"""

import dataclasses
import itertools
import math
import os
import re

import numpy

from .errors import InputError, ParameterError
from .metadata import number_of

METERS = {"m": 1, "Mm": 1000000, "km": 1000, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
USUAL_RATE = 24
_CLASSES = {"fog volume": "fogVolume", "level set": "levelSet", "staggered": "staggered"}
_TYPES = {"vec3s": "float3", "vec3d": "double3"}
_APERTURE = 36, 20.25  # of a film camera at 16:9 [tenths of a unit]
_UNSAFE = "[\x00-\x1f\x7f-\x9f\u2028\u2029\udc80-\udcff]"


@dataclasses.dataclass
class Frame:
    """The grids of a frame's file by name, as read_headers() returns them."""

    path: str
    grids: dict
    metadata: dict

    def bounds(self):
        """The box around all active voxels in world space, or None."""
        corners = []
        for grid in self.grids.values():
            if grid["box"] is not None:
                low, high = (numpy.array(corner, float) + side for corner, side in zip(grid["box"], (-0.5, 0.5)))
                index = numpy.array(list(itertools.product(*zip(low, high))))
                corners.append(index @ grid["transform"][:3, :3].T + grid["transform"][:3, 3])
        return (numpy.min(corners, axis=(0, 1)), numpy.max(corners, axis=(0, 1))) if corners else None


@dataclasses.dataclass
class Settings:
    """The metrics of the layer: frames a second, metres a unit, the up axis, the stretch of the axes."""

    rate: float
    meters: float
    up: str
    stretch: tuple


def settings_of(frame, fps, meters, up, stretch):
    """Arguments that are not given come from the metadata of a frame."""
    dt = number_of(frame.metadata, "dt")
    # Of six digits: dt may be a float.
    rate = float(f"{1 / dt:.6g}") if dt and 1 / 120 <= dt <= 1 / 10 else USUAL_RATE
    houdini = any(str(frame.metadata.get(key, "")).startswith("Houdini") for key in ("source_creator", "creator"))
    meters = meters or METERS.get(str(frame.metadata.get("length_unit", "m")).strip(), 1)
    return Settings(fps or rate, meters, up or ("Y" if houdini else "Z"), tuple(stretch or (1, 1, 1)))


def gaps_of(frames):
    """The missing frame numbers, as (the frame that stays, first, last), where frames are not evenly spaced."""
    pairs = list(itertools.pairwise(sorted(frames)))
    least = min((b - a for a, b in pairs), default=0)
    return [(a, a + 1, b - 1) for a, b in pairs if b - a > least]


def layer(path, frames, settings, camera, doc, proxy=None, streaks=None):
    """The text of a layer.

    @param frames  number → Frame
    @param camera  a CameraFile or None
    @param proxy  the frames of a coarser level, or None
    @param streaks  their Curves, or None
    """
    volumes = [box for frame in frames.values() if (box := frame.bounds()) is not None]
    boxes = volumes + (streaks.boxes if streaks else [])
    if not boxes:
        raise InputError(f"{next(iter(frames.values())).path}: no voxel in any frame; there is nothing to show")
    numbers = sorted(frames)
    end = max(numbers[-1], numbers[0] + 1)  # one frame lasts a frame: renderers blur motion over an interval
    role = {"uniform token purpose": _text("render"), "rel proxyPrim": "</flow/proxy>"} if proxy else {}
    children = [streaks.prim] if streaks else []
    if volumes:
        children.append(_volume("volume", path, frames, settings, role))
    if proxy:
        children.append(_volume("proxy", path, proxy, settings, {"uniform token purpose": _text("proxy")}))
    if camera:
        children.append(_camera(camera, range(numbers[0], end + 1), boxes, settings))
    head = {
        "defaultPrim": _text("flow"), "doc": _text(doc), "endTimeCode": end, "framesPerSecond": settings.rate,
        "metersPerUnit": settings.meters, "startTimeCode": numbers[0], "timeCodesPerSecond": settings.rate,
        "upAxis": _text(settings.up)}  # fmt: skip
    lines = ["#usda 1.0", "(", *_indented(f"{name} = {_value(value)}" for name, value in head.items()), ")", ""]
    return "\n".join(lines + prim("Xform", "flow", {}, children, ['kind = "component"'])) + "\n"


def _volume(volume, path, frames, settings, attributes):
    """A Volume, with one field for each grid that any frame has. @param attributes  that state its purpose"""
    taken = set()
    names = dict.fromkeys(name for number in sorted(frames) for name in frames[number].grids)
    fields = {name: identifier(name, taken) for name in names}
    # Extents are interpolated and files are not, so that of a gap stays until its end.
    extents = {number: box for number, frame in frames.items() if (box := frame.bounds()) is not None}
    extents |= {last: extents[stays] for stays, _, last in gaps_of(frames) if stays in extents}
    attributes = attributes | {"float3[] extent": {n: f"[{_value(a)}, {_value(b)}]" for n, (a, b) in extents.items()}}
    attributes |= {f"rel field:{field}": f"</flow/{volume}/{field}>" for field in fields.values()}
    return prim("Volume", volume, attributes | stretched(settings), [_field(path, *field, frames) for field in fields.items()])


def stretched(settings):
    """The attributes that scale a prim as the world's axes are stretched."""
    if settings.stretch == (1, 1, 1):
        return {}
    return {"double3 xformOp:scale": settings.stretch, "uniform token[] xformOpOrder": '["xformOp:scale"]'}


def _field(path, name, field, frames):
    """A field: the files at time codes, blocked where a file lacks the grid."""
    grid = next(frame.grids[name] for _, frame in sorted(frames.items()) if name in frame.grids)
    kind = _TYPES.get(grid["type"], grid["type"])
    files = {number: _asset(frame.path, path) if name in frame.grids else "None" for number, frame in frames.items()}
    attributes = {
        "token fieldClass": _text(_CLASSES.get(grid["class"], "unknown")),
        "token fieldDataType": _text(kind), "token fieldName": _text(name), "asset filePath": files}  # fmt: skip
    vector = {"token vectorDataRoleHint": '"Vector"'} if kind.endswith("3") else {}
    return prim("OpenVDBAsset", field, attributes | vector)


def _camera(camera, numbers, boxes, settings):
    """The camera of a file of key frames, in the stretched space, as vdblic_render has it."""
    corners = [list(itertools.product(*zip(*(numpy.array(box) * settings.stretch)))) for box in boxes]
    corners = numpy.concatenate(corners)
    places, lengths, heights, distances = {}, {}, {}, []
    for number in numbers:
        keys = camera.at(number)
        for name in "eye", "target":
            if name not in keys:
                raise ParameterError(f'--camera: no key has "{name}"; the camera of a layer needs eye and target')
        places[number], forward = _view(number, keys)
        distances += list((corners - keys["eye"]) @ forward)
        heights[number] = keys.get("height")
        lengths[number] = _APERTURE[1] / 2 / math.tan(math.radians(keys.get("fov", 35)) / 2)
    flat = None not in heights.values()
    wide, tall = _APERTURE
    far = max(max(distances), 1e-6) * 2
    attributes = {"float2 clippingRange": (max(min(distances) / 2, far * 1e-4), far)}
    attributes |= {} if flat else {"float focalLength": lengths}
    attributes |= {
        "float horizontalAperture": {n: h * 10 * wide / tall for n, h in heights.items()} if flat else wide,
        "float verticalAperture": {n: h * 10 for n, h in heights.items()} if flat else tall,
        "token projection": _text("orthographic" if flat else "perspective"),
        "matrix4d xformOp:transform": places, "uniform token[] xformOpOrder": '["xformOp:transform"]'}  # fmt: skip
    return prim("Camera", "camera", attributes)


def _view(frame, keys):
    """The rows of the matrix from camera to world, and the direction of view. USD's cameras look along -z, y up."""
    eye, target = numpy.array(keys["eye"]), numpy.array(keys["target"])
    forward = target - eye
    length = numpy.linalg.norm(forward)
    if not length > 0:
        raise ParameterError(f"--camera: frame {frame}: eye and target are one point; move one of them")
    forward /= length
    up = numpy.array(keys.get("up", (0, 1, 0) if abs(forward[2]) > 1 - 1e-9 else (0, 0, 1)), float)
    right = numpy.cross(forward, up)
    if not numpy.linalg.norm(right) > 1e-9 * numpy.linalg.norm(up):
        raise ParameterError(f'--camera: frame {frame}: the view is along up; change "up"')
    right /= numpy.linalg.norm(right)
    return ((*right, 0), (*numpy.cross(right, forward), 0), (*-forward, 0), (*eye, 1)), forward


def prim(kind, name, attributes, children=(), metadata=()):
    """The lines of a prim. An attribute has a value, or one at each time code; a constant is written once."""
    lines = []
    for declaration, value in attributes.items():
        texts = {time: _value(one) for time, one in value.items()} if isinstance(value, dict) else {0: _value(value)}
        if len(set(texts.values())) == 1:
            lines.append(f"{declaration} = {next(iter(texts.values()))}")
        else:
            samples = (f"{_value(time)}: {one}," for time, one in sorted(texts.items()))
            lines += [f"{declaration}.timeSamples = {{", *_indented(samples), "}"]
    for child in children:
        lines += ["", *child] if lines else child
    head = f"def {kind} {_text(name)}"
    opening = [f"{head} (", *_indented(metadata), ")"] if metadata else [head]
    return [*opening, "{", *_indented(lines), "}"]


def _indented(lines):
    return [f"    {line}" if line else "" for line in lines]


def _value(value):
    """A number, whole ones without a point; a tuple of values; a text as it is."""
    if isinstance(value, str):
        return value
    if numpy.ndim(value):
        return f"({', '.join(map(_value, value))})"
    value = float(value)
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def _text(value):
    """A text; control characters, and bytes of a file that are no UTF-8, as their hexadecimal escapes."""
    escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    codes = lambda match: "".join(f"\\x{byte:02x}" for byte in match[0].encode("utf-8", "surrogateescape"))
    return f'"{re.sub(_UNSAFE, codes, escaped)}"'


def _asset(path, layer_path):
    """A file as it is found from the folder of a layer, so that both can be moved together. Raises InputError."""
    relative = os.path.relpath(os.path.abspath(path), os.path.dirname(os.path.abspath(layer_path)))
    if not relative.isprintable():
        raise InputError(
            f"{path!r}: a name of control characters, or of bytes that are no UTF-8, cannot be written into a layer;"
            " rename the file"
        )
    anchored = relative if relative.startswith("../") else f"./{relative}"
    mark = "@@@" if "@" in anchored else "@"
    return f"{mark}{anchored.replace('@@@', chr(92) + '@@@')}{mark}"


def identifier(name, taken):
    """A new name for a prim, which is added to the names `taken`."""
    plain = re.sub(r"^(?=\d)|^$", "_", re.sub(r"[^A-Za-z0-9_]", "_", name))
    names = itertools.chain([plain], (f"{plain}_{count}" for count in itertools.count(2)))
    result = next(one for one in names if one not in taken)
    taken.add(result)
    return result
