"""A sequence of volumes as a layer of USD: a Volume whose fields name the files, and a camera.

Fields and volume follow OpenUSD's schemas UsdVol (Volume, OpenVDBAsset), the camera UsdGeomCamera. World space is that
of the files: OpenVDB's, a voxel half an index to each side of its centre.
"""

import dataclasses
import itertools
import math

import numpy

from .errors import InputError, ParameterError
from .metadata import number_of
from .usd_text import asset, attribute, identifier, matrix, prim, samples, text, tuple_of

METERS = {"m": 1, "km": 1000, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
USUAL_RATE = 24
_CLASSES = {"fog volume": "fogVolume", "level set": "levelSet", "staggered": "staggered"}
_TYPES = {"vec3s": "float3", "vec3d": "double3"}
_APERTURE = 36, 20.25  # of a film camera at 16:9 [tenths of a unit]


@dataclasses.dataclass
class Frame:
    """The grids of a frame's file by name, as read_headers() tells of them."""

    path: str
    grids: dict
    metadata: dict


@dataclasses.dataclass
class Settings:
    """How the world is told: units a second and a metre, the axis that is up, the stretch of the world's axes."""

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
    return Settings(
        fps or rate,
        meters or METERS.get(str(frame.metadata.get("length_unit", "m")).strip(), 1),
        up or ("Y" if houdini else "Z"),
        tuple(stretch or (1, 1, 1)),
    )


def corners_of(grid):
    """The corners of the box around a grid's active voxels in world space, or None if there are none."""
    if grid["box"] is None:
        return None
    low, high = (numpy.array(corner, float) + side for corner, side in zip(grid["box"], (-0.5, 0.5)))
    index = numpy.array(list(itertools.product(*zip(low, high))))
    return index @ grid["transform"][:3, :3].T + grid["transform"][:3, 3]


def bounds_of(frame):
    """The box around all active voxels of a frame in world space, or None."""
    corners = [found for grid in frame.grids.values() if (found := corners_of(grid)) is not None]
    if not corners:
        return None
    corners = numpy.concatenate(corners)
    return corners.min(axis=0), corners.max(axis=0)


def gaps_of(frames):
    """The missing frame numbers, as (the frame that stays, first, last), where frames are not evenly spaced."""
    numbers = sorted(frames)
    steps = [b - a for a, b in zip(numbers, numbers[1:])]
    if len(set(steps)) < 2:
        return []
    return [(a, a + 1, b - 1) for a, b in zip(numbers, numbers[1:]) if b - a > min(steps)]


def layer(path, frames, settings, camera, doc, proxy=None):
    """The text of a layer.

    @param frames  number → Frame
    @param camera  a CameraFile or None
    @param proxy  the frames of a coarser level, or None
    """
    bounds = {number: box for number, frame in frames.items() if (box := bounds_of(frame)) is not None}
    if not bounds:
        raise InputError(f"{next(iter(frames.values())).path}: no voxel in any frame; there is nothing to show")
    numbers = sorted(frames)
    end = max(numbers[-1], numbers[0] + 1)  # one frame lasts a frame: renderers blur motion over an interval
    purpose = 'uniform token purpose = "{}"'.format
    full = [purpose("render"), "rel proxyPrim = </flow/proxy>"] if proxy else []
    children = _volume("volume", path, frames, bounds, settings, full)
    if proxy:
        coarse = {number: box for number, frame in proxy.items() if (box := bounds_of(frame)) is not None}
        children += ["", *_volume("proxy", path, proxy, coarse, settings, [purpose("proxy")])]
    if camera:
        children += ["", *_camera(camera, range(numbers[0], end + 1), bounds.values(), settings)]
    head = [
        'defaultPrim = "flow"',
        f"doc = {text(doc)}",
        f"endTimeCode = {end}",
        f"framesPerSecond = {tuple_of([settings.rate])[1:-1]}",
        f"metersPerUnit = {tuple_of([settings.meters])[1:-1]}",
        f"startTimeCode = {numbers[0]}",
        f"timeCodesPerSecond = {tuple_of([settings.rate])[1:-1]}",
        f'upAxis = "{settings.up}"',
    ]
    lines = ["#usda 1.0", "(", *(f"    {line}" for line in head), ")", ""]
    lines += prim("Xform", "flow", children, ['kind = "component"'])
    return "\n".join(lines) + "\n"


def _volume(volume, path, frames, bounds, settings, role):
    """A Volume, with one field for each grid that any frame has. @param role  lines that tell what it is for"""
    names = list(dict.fromkeys(name for number in sorted(frames) for name in frames[number].grids))
    taken = set()
    fields = {name: identifier(name, taken) for name in names}
    lines = role + samples("float3[] extent", _extents(frames, bounds))
    lines += [f"rel field:{field} = </flow/{volume}/{field}>" for field in fields.values()]
    if settings.stretch != (1, 1, 1):
        lines += attribute("double3 xformOp:scale", tuple_of(settings.stretch))
        lines += attribute("uniform token[] xformOpOrder", '["xformOp:scale"]')
    for name, field in fields.items():
        lines += ["", *_field(path, name, field, frames)]
    return prim("Volume", volume, lines)


def _extents(frames, bounds):
    """Extents at time codes. Extents are interpolated and files are not, so that of a gap stays until its end."""
    extent = lambda box: f"[{tuple_of(box[0])}, {tuple_of(box[1])}]"
    values = {number: extent(box) for number, box in bounds.items()}
    for stays, _, last in gaps_of(frames):
        if stays in values:
            values[last] = values[stays]
    return values


def _field(path, name, field, frames):
    """A field: the files at time codes, blocked where a file lacks the grid."""
    holders = [frame for _, frame in sorted(frames.items()) if name in frame.grids]
    grid = holders[0].grids[name]
    kind = _TYPES.get(grid["type"], grid["type"])
    files = {number: asset(frame.path, path) if name in frame.grids else "None" for number, frame in frames.items()}
    lines = attribute("token fieldClass", f'"{_CLASSES.get(grid["class"], "unknown")}"')
    lines += attribute("token fieldDataType", f'"{kind}"')
    lines += attribute("token fieldName", text(name))
    lines += samples("asset filePath", files)
    if kind.endswith("3"):
        lines += attribute("token vectorDataRoleHint", '"Vector"')
    return prim("OpenVDBAsset", field, lines)


def _camera(camera, numbers, bounds, settings):
    """The camera of a file of key frames, in the stretched space, as vdblic_render has it."""
    boxes = [numpy.array(box) * settings.stretch for box in bounds]
    corners = numpy.concatenate([list(itertools.product(*zip(*box))) for box in boxes])
    places, lengths, heights, distances = {}, {}, {}, []
    for number in numbers:
        keys = camera.at(number)
        for name in "eye", "target":
            if name not in keys:
                raise ParameterError(f'--camera: no key has "{name}"; the camera of a layer needs eye and target')
        rows, forward = _view(number, keys)
        distances += list((corners - keys["eye"]) @ forward)
        places[number] = matrix(rows)
        heights[number] = keys.get("height")
        lengths[number] = _APERTURE[1] / 2 / math.tan(math.radians(keys.get("fov", 35)) / 2)
    flat = None not in heights.values()
    wide, tall = _APERTURE
    far = max(max(distances), 1e-6) * 2
    near = max(min(distances) / 2, far * 1e-4)
    lines = attribute("float2 clippingRange", tuple_of((near, far)))
    if flat:
        lines += samples(
            "float horizontalAperture", {n: tuple_of([h * 10 * wide / tall])[1:-1] for n, h in heights.items()}
        )
        lines += samples("float verticalAperture", {n: tuple_of([h * 10])[1:-1] for n, h in heights.items()})
    else:
        lines += samples("float focalLength", {n: tuple_of([length])[1:-1] for n, length in lengths.items()})
        lines += attribute("float horizontalAperture", tuple_of([wide])[1:-1])
        lines += attribute("float verticalAperture", tuple_of([tall])[1:-1])
    lines += attribute("token projection", '"orthographic"' if flat else '"perspective"')
    lines += samples("matrix4d xformOp:transform", places)
    lines += attribute("uniform token[] xformOpOrder", '["xformOp:transform"]')
    return prim("Camera", "camera", lines)


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
    axes = right, numpy.cross(right, forward), -forward
    return [[*axis, 0] for axis in axes] + [[*eye, 1]], forward
