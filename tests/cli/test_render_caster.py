"""The frames of an .exr sequence beside an independent ray caster in NumPy."""

import json
import unittest

import numpy
import pyopenvdb as vdb

from support import RenderTest

SHAPE = 26, 22, 18
WIDTH, HEIGHT, VIEW_HEIGHT, FOV = 48, 36, 2.6, 17
EYE, TARGET = numpy.array((6.0, -5.0, 5.5)), numpy.array((0.9, 1.6, 1.0))
BOX = numpy.array(((0.15, 0.9, 0.2), (1.6, 2.25, 1.75)))  # inside the voxels' centres
TURN = numpy.radians(25)
# Rows: where a step along each index leads, and where index 0 is.
TRANSFORM = numpy.array(((0.1 * numpy.cos(TURN), 0.1 * numpy.sin(TURN), 0),
                         (-0.1 * numpy.sin(TURN), 0.1 * numpy.cos(TURN), 0), (0, 0, 0.1), (0.2, 0.1, 0.15)))
COLORS = numpy.array(((0, 0.1, 0.2, 0.9), (0.4, 0.9, 0.8, 0.1), (1, 0.7, 0.1, 0.3)))
OPACITY = numpy.array(((0, 0), (0.3, 0.02), (0.7, 0.2), (1, 0.08)))
RANGE, OPACITY_RANGE = (0.1, 0.9), (-0.2, 1.2)
# Of red, green, blue and alpha. Samples that add less than 1/256 are shaded together, which alpha does not notice.
TOLERANCES = 2.5e-3, 2.5e-3, 2.5e-3, 5e-4


def fields(frame):
    """The texture that opacity follows, and the scalar that colour follows, at the voxels."""
    x, y, z = numpy.meshgrid(*map(numpy.arange, SHAPE), indexing="ij")
    density = 0.5 + 0.35 * numpy.sin(0.45 * x - 0.9 * frame) * numpy.cos(0.4 * y) + 0.15 * numpy.sin(0.5 * z + frame)
    return density, 0.5 + 0.4 * numpy.cos(0.3 * x + 0.2 * y - 0.35 * z + 0.7 * frame)


def interpolated(values, index):
    """Trilinear between voxels. @param index of shape (..., 3), inside the voxels' centres"""
    cell = numpy.floor(index).astype(int)
    part = index - cell
    result = 0
    for corner in numpy.ndindex(2, 2, 2):
        weight = numpy.prod(numpy.where(corner, part, 1 - part), axis=-1)
        result = result + weight * values[tuple(numpy.moveaxis(cell + corner, -1, 0))]
    return result


def position_in(limits, values):
    return (values - limits[0]) / (limits[1] - limits[0])


def linear(displayed):
    """sRGB to linear light."""
    return numpy.where(displayed <= 0.04045, displayed / 12.92, ((displayed + 0.055) / 1.055) ** 2.4)


def cast(frame, projection, steps=200):
    """Red, green, blue and alpha of the frame, premultiplied: emission and absorption along rays."""
    density, scalar = fields(frame)
    forward = (TARGET - EYE) / numpy.linalg.norm(TARGET - EYE)
    right = numpy.cross(forward, (0, 0, 1))
    right /= numpy.linalg.norm(right)
    up = numpy.cross(right, forward)
    is_flat = projection == "orthographic"
    pixel = (VIEW_HEIGHT if is_flat else 2 * numpy.tan(numpy.radians(FOV) / 2)) / HEIGHT
    across = (numpy.arange(WIDTH) + 0.5 - WIDTH / 2) * pixel
    upward = (HEIGHT / 2 - numpy.arange(HEIGHT) - 0.5) * pixel
    beside = across[None, :, None] * right + upward[:, None, None] * up
    origin, direction = (EYE + beside, forward + 0 * beside) if is_flat else (EYE + 0 * beside, forward + beside)
    direction /= numpy.linalg.norm(direction, axis=-1, keepdims=True)
    first, last = (BOX[0] - origin) / direction, (BOX[1] - origin) / direction
    enter = numpy.minimum(first, last).max(-1)
    leave = numpy.maximum(numpy.maximum(first, last).min(-1), enter)
    step = (leave - enter) / steps
    color, transmittance = numpy.zeros((HEIGHT, WIDTH, 3)), numpy.ones((HEIGHT, WIDTH))
    inside = leave > enter
    for number in range(steps):
        place = (origin + (enter + (number + 0.5) * step)[..., None] * direction)[inside]
        index = (place - TRANSFORM[3]) @ numpy.linalg.inv(TRANSFORM[:3])
        opacity = numpy.interp(position_in(OPACITY_RANGE, interpolated(density, index)), *OPACITY.T)
        at = position_in(RANGE, interpolated(scalar, index))
        seen = linear(numpy.stack([numpy.interp(at, COLORS[:, 0], channel) for channel in COLORS[:, 1:].T], axis=-1))
        left = (1 - opacity) ** (step[inside] / 0.1)  # the opacity is a voxel's
        color[inside] += (transmittance[inside] * (1 - left))[:, None] * seen
        transmittance[inside] *= left
    return numpy.dstack([color, 1 - transmittance])


class RenderCaster(RenderTest):
    def test_every_frame_is_the_one_of_an_independent_caster(self):
        frames = 7, 8, 9
        for frame in frames:
            grids = []
            for name, values in zip(("density", "magnitude"), fields(frame)):
                grids.append(vdb.FloatGrid())
                grids[-1].name = name
                grids[-1].copyFromArray(values.astype(numpy.float32), tolerance=-1)
                grids[-1].transform = vdb.createLinearTransform(numpy.c_[TRANSFORM, (0, 0, 0, 1)].tolist())
            vdb.write(str(self.folder / f"lic.{frame:04}.vdb"), grids=grids)
        (self.folder / "transfer.json").write_text(json.dumps({
            "range": RANGE, "opacity_range": OPACITY_RANGE, "colors": COLORS.tolist(), "opacity": OPACITY.tolist()}))
        for projection, extent in ("orthographic", ("--view-height", VIEW_HEIGHT)), ("perspective", ("--fov", FOV)):
            names = self.renders(
                "lic.%04d.vdb", "-o", "seen.%04d.exr", "--size", WIDTH, HEIGHT, "--samples", 1, "--precision", "float", "--projection",
                projection, *extent, "--eye", *EYE, "--target", *TARGET, "--clip-box", *BOX.ravel(), "--transfer",
                "transfer.json", "--by", "magnitude", "--opacity-by", "density", "--modulate", 0, "--limb-darkening", 0,
                "--shading", "none", "--halo", 0, "--depth-cue", 0, "--exposure", 0, "--step", 0.1, "--interpolation",
                "linear")
            self.assertEqual(names, [f"seen.{frame:04}.exr" for frame in frames])
            pictures = [numpy.dstack(self.pixels(name, "R", "G", "B", "A")) for name in names]
            for before, picture in zip(pictures, pictures[1:]):  # the frames are others, and show much
                self.assertGreater(abs(picture - before).max(), 0.1)
            for frame, picture in zip(frames, pictures):
                expected = cast(frame, projection)
                self.assertGreater(expected[..., 3].max(), 0.7)
                self.assertTrue((abs(picture - expected) < TOLERANCES).all(), abs(picture - expected).max((0, 1)))


if __name__ == "__main__":
    unittest.main()
