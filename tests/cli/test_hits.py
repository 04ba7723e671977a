"""vdblic_advect --with hits: what each voxel received in the step, as an Int32 grid."""

import json
import unittest

import numpy
import pyopenvdb as vdb

from support import ToolTest

SIZE = 20, 24, 18


class Hits(ToolTest):
    def setUp(self):
        super().setUp()
        self.outputs("vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", *SIZE, "--frames", "1-3")

    def advect(self, *arguments):
        return self.outputs("vdblic_advect", "v.%04d.vdb", *arguments)

    def values(self, path, grid):
        array = numpy.zeros(SIZE, numpy.float32)
        vdb.read(str(self.folder / path), grid).copyToArray(array)
        return array

    def test_they_are_the_hits_of_the_report(self):
        for method in "uflic", "auflic-2004", "auflic":
            self.advect("-o", f"{method}.%04d.vdb", "--method", method, "--with", "hits", "--json", "run.json")
            run = json.loads((self.folder / "run.json").read_text())["frames"]
            self.run_tool("vdblic_coherence", "v.%04d.vdb", f"{method}.%04d.vdb", "--json", "measured.json")
            measured = json.loads((self.folder / "measured.json").read_text())["frames"]
            self.assertEqual(len(measured), 3)
            for made, found in zip(run, measured):
                voxels = made["voxels"]
                self.assertAlmostEqual(found["hits"]["zero_share"], made["empty_voxels"] / voxels, delta=1e-9)
                rounding = 0.05 if method == "auflic" else 1e-9  # values that have faded count for less
                self.assertAlmostEqual(found["hits"]["mean"] * voxels / made["hits"], 1, delta=rounding)

    def test_the_grid_is_of_integers_on_the_textures_voxels(self):
        self.advect("-o", "t.%04d.vdb", "--refine", 2, "--substeps", 2, "--with", "q,hits")
        printed = self.printed("t.0002.vdb")
        names = [line.split()[1] for line in printed.splitlines() if line.startswith("Name: ")]
        self.assertEqual(names, ["density", "hits", "magnitude", "q"], printed)
        hits = printed.split("Name: hits")[1].split("Name: ")[0]
        self.assertIn("Tree_int32_5_4_3", hits)
        self.assertIn("active voxels:       69,120", hits)  # all of the texture's

    def test_they_change_nothing_else(self):
        self.advect("-o", "plain.%04d.vdb")
        self.advect("-o", "with.%04d.vdb", "--with", "hits", "--threads", 1)
        self.advect("-o", "again.%04d.vdb", "--with", "hits", "--threads", 3)
        for frame in range(1, 4):
            self.assertEqual(self.contents(f"with.{frame:04}.vdb"), self.contents(f"again.{frame:04}.vdb"))
            for grid in "density", "magnitude":
                plain, other = (self.values(f"{name}.{frame:04}.vdb", grid) for name in ("plain", "with"))
                numpy.testing.assert_array_equal(plain, other)

    def test_mistakes(self):
        for words, *options in (
            ("'hits' is asked for twice", "--with", "hits,hits"),
            ("'hits' cannot be the texture's name", "--with", "hits", "--texture-name", "hits"),
            ("'hits' to carry along has the name of an output", "--with", "hits", "--carry", "hits"),
        ):
            with self.subTest(words):
                self.assertIn(words, self.fails(2, "vdblic_advect", "v.%04d.vdb", "-o", "x.%04d.vdb", *options))
        for method in "lic", "streaks", "ibfv", "lea", "ufac":
            asked = "--with", "hits", "--method", method
            message = self.fails(2, "vdblic_advect", "v.%04d.vdb", "-o", "x.%04d.vdb", *asked)
            self.assertIn(f"--with hits: with --method {method} no values are scattered into voxels", message)
            self.assertIn("auflic, auflic-2004 or uflic", message)


if __name__ == "__main__":
    unittest.main()
