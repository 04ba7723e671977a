#!/usr/bin/env bash
# Makes the pictures of docs/gallery.md: four flows, each in every look, cut open, and with halos; and an animation.
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

# render INPUT OUTPUT OPTIONS...
render() { "$tools/vdblic_render" "$out/$1" -o "$out/$2" -q "${@:3}" >>"$out/log.txt"; }

# gallery NAME INPUT CUT OPTIONS...: CUT and OPTIONS as in docs/gallery.md.
gallery() {
    local name=$1 input=$2 look cut
    local -a options=("${@:4}")
    read -ra cut <<<"$3"
    picture() {
        render "$input" "$name-$1.png" --samples 4 "${options[@]}" "${@:2}"
        ffmpeg -loglevel error -y -i "$out/$name-$1.png" -q:v 3 "$images/$name-$1.jpg"
    }
    for look in flow ink smoke xray; do picture "$look" --look "$look"; done
    picture cut "${cut[@]}"
    picture halo --halo 1.5 --depth-cue 0.5
}

# texture NAME VELOCITY OPTIONS...
texture() { "$tools/vdblic_advect" "$2" -o "$out/$1.%04d.vdb" -q --restart "${@:3}" >>"$out/log.txt"; }

texture wake samples/wake/wake.%04d.vdb
gallery wake wake.%04d.vdb "--clip-plane 0 0 0 0 1 0" --frames 12 --size 720 450

"$tools/vdblic_synth" tornado -o "$out/v.%04d.vdb" --size 144 73 81 --frames 1-12 -q >>"$out/log.txt"
texture tornado "$out/v.%04d.vdb"
gallery tornado tornado.%04d.vdb "--clip-plane 7.2 3.6 4.5 0 0 -1" --frames 8 --size 720 450

if [ ! -d "$out/smoke/data" ]; then
    blender -b --factory-startup --python-exit-code 9 --python tests/cli/blender/bake_smoke.py -- "$out/smoke" 96 38 \
        >"$out/blender.log" 2>&1
fi
texture smoke "$out/smoke/data/fluid_data_%04d.vdb" --frames 30-38
gallery smoke smoke.0038.vdb "--clip-plane 1 0 0 0 1 0" --size 480 560

if [ -n "$data" ]; then
    texture era "$data/era5_west_europe/era5.%04d.vdb" --frames 1-12
    gallery era era.%04d.vdb "--clip-plane 0 0 5500 0 0 -1" --frames 10 --size 720 450 --stretch 1 1 30

    # An animation, and six of its frames in one picture.
    texture film "$data/wake/wake.%04d.vdb"
    render film.%04d.vdb film.%04d.png --size 640 400 --samples 3
    ffmpeg -loglevel error -y -framerate 8 -i "$out/film.%04d.png" -c:v libx264 -crf 24 -preset slow -pix_fmt yuv420p \
        "$images/wake.mp4"
    ffmpeg -loglevel error -y -start_number 9 -i "$out/film.%04d.png" -frames:v 1 -vf "scale=480:-1,tile=2x3:padding=4" \
        -q:v 3 "$images/strip.jpg"
fi
