"""vdblic_import --globe of the grids of ocean models, which have two north poles on land and are folded between these."""

import unittest

import numpy
import pyopenvdb as vdb

import earth_flows
from earth_flows import OMEGA, RADIUS
from imports import ImportHere, velocity_of

CENTRES, FACES = ((0.5, 0.5), (0.5, 0.5)), ((1, 0.5), (0.5, 1))
VOXEL = 0.12


class Tripolar(ImportHere):
    def globe(self, places, **options):
        """Values, mask and positions of the grid's flow."""
        names = []
        for slot, file in enumerate(earth_flows.tripolar(places, **options)):
            names.append(f"{'uv'[slot]}.nc")
            earth_flows.write(self.folder / names[-1], file)
        path, = self.imports(*names, "-o", "v.%04d.vdb", "--globe", "--voxel-size", VOXEL)
        return velocity_of(path)

    def assert_whole(self, active, at):
        """Values everywhere, across seam and fold, but on land and at the south end; the land is solid."""
        radius = numpy.linalg.norm(at, axis=-1)
        layer = abs(radius - RADIUS / 1e6) < 1.4 * VOXEL
        from_land = numpy.min([numpy.linalg.norm(at / radius[..., None].clip(1) - pole, axis=-1) for pole in self.poles()], axis=0)
        in_grid = layer & (at[..., 2] > -0.93 * radius)
        self.assertTrue(active[in_grid & (from_land > 0.2)].all())
        self.assertFalse(active[layer & (from_land < 0.06)].any())
        solid = vdb.read(str(self.folder / "v.0001.vdb"), "solid").getConstAccessor()
        for pole in self.poles():
            self.assertGreater(solid.getValue(tuple(round(x) for x in pole * RADIUS / 1e6 / VOXEL)), 0)
        self.assertEqual(solid.getValue((0, 0, round(RADIUS / 1e6 / VOXEL))), 0)
        self.assertEqual(solid.getValue((0, 0, -round(RADIUS / 1e6 / VOXEL))), 0)  # no cells, so no land

    @staticmethod
    def poles():
        at = 90 - 2 * numpy.degrees(numpy.arctan(0.15))
        return [earth_flows.unit_vectors(numpy.float64(longitude), at)[0] for longitude in (0, 180)]

    def test_rotation(self):
        """About a tilted axis: the flow goes over the pole, where the fold is. On centres, faces, and with a halo."""
        for places in CENTRES, FACES:
            for halo in (False, True) if places is CENTRES else (False,):
                values, active, at = self.globe(places, halo=halo)
                self.assert_whole(active, at)
                expected = numpy.cross(OMEGA, at)
                error = numpy.linalg.norm(values - expected, axis=-1)[active] / abs(expected[active]).max()
                self.assertLess(error.max(), 0.02)  # by the land around the grid's poles, where its cells are bent
                self.assertLess(numpy.sort(error)[int(0.99 * len(error))], 2e-3)

    def test_wind_along_parallels(self):
        """Components along the grid become a flow eastward: beside the fold, too, and at the pole."""
        values, active, at = self.globe(CENTRES, spin=numpy.array([0, 0, 1e-5]))
        east = numpy.stack([-at[..., 1], at[..., 0], 0 * at[..., 0]], axis=-1)
        inner = active & (numpy.hypot(at[..., 0], at[..., 1]) < 0.6)
        self.assertGreater(inner.sum(), 200)
        numpy.testing.assert_allclose(values[inner], 1e-5 * east[inner], atol=1e-3 * 1e-5)


if __name__ == "__main__":
    unittest.main()
