"""A flow of another program becomes a film."""

import argparse
import pathlib
import subprocess
import tempfile

import vdblic

parser = argparse.ArgumentParser(description=__doc__, epilog="Further options are those of vdblic_import.")
parser.add_argument("flow", help="what vdblic_import reads: CASE.foam, WINDS.nc, FLOW.pvd ...")
parser.add_argument("film", help="the film to write, an .mp4")
arguments, options = parser.parse_known_args()
with tempfile.TemporaryDirectory() as folder:
    velocities = pathlib.Path(folder) / "v.%04d.vdb"
    subprocess.run(["vdblic_import", arguments.flow, "-o", velocities, *options], check=True, stdout=subprocess.DEVNULL)
    vdblic.film(velocities, arguments.film, size=(640, 360), seconds=2)
