"""A flow of another program becomes a film."""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import vdblic

parser = argparse.ArgumentParser(description=__doc__, epilog="Further options are those of vdblic_import.")
parser.add_argument("flow", help="what vdblic_import reads: CASE.foam, WINDS.nc, FLOW.pvd ...")
parser.add_argument("film", help="the film to write, an .mp4")
arguments, options = parser.parse_known_args()
with tempfile.TemporaryDirectory() as folder:
    velocities = str(pathlib.Path(folder) / "v.%04d.vdb")
    subprocess.run(["vdblic_import", arguments.flow, "-o", velocities, *options], check=True, stdout=subprocess.DEVNULL)
    render = vdblic.Renderer(size=(640, 360), look="flow")
    encoder = subprocess.Popen(
        ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", "640x360", "-r", "24",
         "-i", "-", "-pix_fmt", "yuv420p", "-c:v", "libx264", arguments.film], stdin=subprocess.PIPE)
    for texture in vdblic.advect(velocities, refine=2, substeps=4):
        encoder.stdin.write(vdblic.displayed(render(texture)).tobytes())
    encoder.stdin.close()
    sys.exit(encoder.wait())
