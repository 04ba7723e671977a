#!/usr/bin/env bash
# Makes the pictures of docs/render.md: four flows, each as vortex, flow, ink, xray and annotated; and two films.
#
#     samples/gallery.sh TOOLS [DATA]
#
# TOOLS is the folder of the built tools. DATA holds velocity sequences that are not in the repository:
# era5_west_europe/era5.%04d.vdb and wake/wake.%04d.vdb, the uncut flow of samples/wake. Without DATA their pictures stay
# unchanged. Blender simulates the smoke in some minutes.
set -euo pipefail
tools=$(cd "$1" && pwd)
data=${2:+$(cd "$2" && pwd)}
cd "$(dirname "$0")/.."
out=out/gallery images=docs/images/gallery
mkdir -p "$out" "$images"

# texture NAME VELOCITY OPTIONS...
texture() { "$tools/vdblic_advect" "$2" -o "$out/$1.%04d.vdb" -q --restart --with vorticity,q "${@:3}" >>"$out/log.txt"; }

# gallery NAME TITLE OPTIONS...: OPTIONS as in docs/render.md.
gallery() {
    local name=$1 title=$2
    local -a options=("${@:3}")
    picture() {
        "$tools/vdblic_render" "$out/$name.%04d.vdb" -o "$out/$name-$1.%04d.png" -q --size 1280 800 \
            "${options[@]}" "${@:2}" >"$out/picture.txt"
        ffmpeg -loglevel error -y -i "$(cat "$out/picture.txt")" -q:v 2 "$images/$name-$1.jpg"
    }
    picture vortex --look vortex --ground below
    picture annotated --look vortex --ground below --annotate "box,axes,colorbar,time,title=$title"
    picture flow --look flow --by vorticity
    picture ink --look ink --by vorticity
    picture xray --look xray --by vorticity
}

# streaks NAME VELOCITY FRAMES SPACING OPTIONS...: a picture of the last of FRAMES.
streaks() {
    texture "$1-streaks" "$2" --method streaks --draw lines --frames "$3" --spacing $4
    "$tools/vdblic_render" "$out/$1-streaks.%04d.vdb" -o "$out/$1-streaks.%04d.png" -q --size 1280 800 \
        --frames "${3#*-}" "${@:5}" >"$out/picture.txt"
    ffmpeg -loglevel error -y -i "$(cat "$out/picture.txt")" -q:v 2 "$images/$1-streaks.jpg"
}

# The tutorial's pictures, by its own commands.
mkdir -p "$out/tutorial"
ln -sfn "$PWD/samples" "$out/tutorial/samples"
grep -E '^vdblic_(advect|render) ' docs/tutorial.md >"$out/tutorial/commands"
(cd "$out/tutorial" && PATH="$tools:$PATH" bash -e commands) >>"$out/log.txt" 2>&1
for picture in still vortex cut fine; do
    ffmpeg -loglevel error -y -i "$out/tutorial/$picture.png" -q:v 2 "docs/images/tutorial/$picture.jpg"
done
ffmpeg -loglevel error -y -i "$out/tutorial/wake.mp4" -vf "select=not(mod(n\\,20)),scale=480:300,tile=3x1" -frames:v 1 \
    -q:v 2 docs/images/tutorial/film.jpg

texture wake samples/wake/wake.%04d.vdb --refine 3
gallery wake "Wake of a square prism" --frames 12 --solid domain
"$tools/vdblic_render" "$out/wake.%04d.vdb" -o "$out/wake-paper.%04d.png" -q --size 1280 800 --frames 12 \
    --look paper --opacity-by q --solid domain --ground below --annotate box,axes,colorbar >>"$out/log.txt"
ffmpeg -loglevel error -y -i "$out/wake-paper.0012.png" -q:v 2 "$images/wake-paper.jpg"
streaks wake samples/wake/wake.%04d.vdb 1-12 1.5 --opacity-by q --solid domain --ground below
"$tools/vdblic_render" "$out/wake.%04d.vdb" --lines "$out/wake-streaks.%04d.vdb" -o "$out/wake-both.%04d.png" -q --size 1280 800 \
    --frames 12 --roi-box -1 -1 0 1 1 0.004 --opacity 0:1,1:1 --modulate 0.5 --solid domain --ground below \
    --annotate colorbar >>"$out/log.txt"
ffmpeg -loglevel error -y -i "$out/wake-both.0012.png" -q:v 2 "$images/wake-both.jpg"

# Where the air of two parts of the inflow goes.
/usr/bin/python3 - samples/wake/wake.0001.vdb "$out/inlets.vdb" <<'END'
import sys
import pyopenvdb as vdb
velocity, grids = vdb.read(sys.argv[1], "velocity"), []
for name, low, high in ("floor", (10, 8, 0), (14, 41, 4)), ("prism", (10, 21, 5), (14, 28, 35)):
    grids.append(vdb.BoolGrid())
    grids[-1].name, grids[-1].transform = name, velocity.transform
    grids[-1].fill(low, high, True)
vdb.write(sys.argv[2], grids)
END
texture wake-sources samples/wake/wake.%04d.vdb --method streaks --draw lines --frames 1-16 --spacing 1.5 \
    --source "near the floor=$out/inlets.vdb:floor" --source "at the prism=$out/inlets.vdb:prism"
"$tools/vdblic_render" "$out/wake-sources.0016.vdb" -o "$out/wake-sources.png" -q --size 1280 800 \
    --color-by source --annotate colorbar --solid domain --ground below >>"$out/log.txt"
ffmpeg -loglevel error -y -i "$out/wake-sources.png" -q:v 2 "$images/wake-sources.jpg"

"$tools/vdblic_synth" ring -o "$out/v.%04d.vdb" --size 96 64 64 --frames 1-12 -q >>"$out/log.txt"
texture ring "$out/v.%04d.vdb" --refine 2
gallery ring "Vortex ring" --frames 10
streaks ring "$out/v.%04d.vdb" 1-10 2 --opacity-by q --ground below

"$tools/vdblic_synth" rossby -o "$out/wave.%04d.vdb" --frames 1-12 --voxel-size 0.1 -q >>"$out/log.txt"
"$tools/vdblic_film" "$out/wave.%04d.vdb" -o "$out/rossby.png" -q --size 1000 1000 --view-from -30 30 >>"$out/log.txt"
ffmpeg -loglevel error -y -i "$out/rossby.png" -q:v 4 "$images/rossby.jpg"

if [ ! -d "$out/smoke/data" ]; then
    blender -b --factory-startup --python-exit-code 9 --python tests/cli/blender/bake_smoke.py -- "$out/smoke" 96 38 \
        >"$out/blender.log" 2>&1
fi
texture smoke "$out/smoke/data/fluid_data_%04d.vdb" --frames 30-38 --refine 2
gallery smoke "Rising smoke" --frames 38

if [ -n "$data" ]; then
    texture era "$data/era5_west_europe/era5.%04d.vdb" --frames 1-12 --refine 4 4 2
    gallery era "Winds over western Europe" --frames 10 --stretch 1 1 30 --solid domain
    streaks era "$data/era5_west_europe/era5.%04d.vdb" 1-10 "1.6 1.6 5" --stretch 1 1 30 --solid domain

    film() { "$tools/vdblic_film" "$data/wake/wake.%04d.vdb" -o "$images/$1" -q --size 960 540 --orbit 0.12 "${@:2}"; }
    film wake.mp4 >>"$out/log.txt"
    film wake-dense.mp4 --method dense >>"$out/log.txt"
fi
