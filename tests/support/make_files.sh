#!/bin/sh
# Writes textures of all methods and pictures of them, from samples/wake, so that builds can be compared byte by byte.
#
#     tests/support/make_files.sh FOLDER TOOLS [COMMAND...]    in FOLDER, by the tools in TOOLS, which COMMAND runs
set -eu
out=$1 tools=$2
shift 2
mkdir "$out"
"$@" "$tools/vdblic_synth" tornado -o "$out/tornado.%04d.vdb" --size 40 32 24 --frames 1-2 -q
"$@" "$tools/vdblic_noise" -o "$out/noise.vdb" --like samples/wake/wake.0001.vdb --refine 2 -q
while read -r name options; do
    # shellcheck disable=SC2086
    "$@" "$tools/vdblic_advect" samples/wake/wake.%04d.vdb -o "$out/$name.%04d.vdb" --frames 1-6 --precision float -q $options
done <<'LIST'
auflic --with vorticity,q,velocity
auflic-2004 --method auflic-2004
uflic --method uflic
lic --method lic
ibfv --method ibfv
lea --method lea
ufac --method ufac
streaks --method streaks --spacing 2 --refine 4 --with q
refined --refine 2
substeps --substeps 2
LIST
"$@" "$tools/vdblic_render" "$out/auflic.0006.vdb" -o "$out/auflic.exr" --size 240 135 --precision float --aov all -q
"$@" "$tools/vdblic_render" "$out/auflic.0006.vdb" -o "$out/auflic.png" --size 240 135 --samples 4 --look vortex \
    --solid domain --ground below --annotate box,colorbar -q
"$@" "$tools/vdblic_render" "$out/streaks.0006.vdb" -o "$out/streaks.png" --size 240 135 --samples 4 -q
