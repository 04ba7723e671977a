"""A flow of another program becomes a film: python3 import_to_film.py CASE.foam|WINDS.nc|FLOW.pvd film.mp4"""

import pathlib
import subprocess
import sys
import tempfile

import vdblic

flow, film, *options = sys.argv[1:]
with tempfile.TemporaryDirectory() as folder:
    velocities = str(pathlib.Path(folder) / "v.%04d.vdb")
    subprocess.run(["vdblic_import", flow, "-o", velocities, *options], check=True, stdout=subprocess.DEVNULL)
    render = vdblic.Renderer(size=(640, 360), look="flow")
    encoder = subprocess.Popen(
        ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", "640x360", "-r", "24",
         "-i", "-", "-pix_fmt", "yuv420p", "-c:v", "libx264", film], stdin=subprocess.PIPE)
    for texture in vdblic.advect(velocities, refine=2, substeps=4):
        encoder.stdin.write(vdblic.displayed(render(texture)).tobytes())
    encoder.stdin.close()
    sys.exit(encoder.wait())
