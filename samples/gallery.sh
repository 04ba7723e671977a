#!/usr/bin/env bash
# The pictures of docs/gallery.md: four flows, each in every look, cut open, and with halos; and a strip of frames.
#
#     samples/gallery.sh TOOLS [DATA]
#
# TOOLS is the folder of the built tools. DATA, if given, holds velocity sequences that do not ship:
# era5_west_europe/era5.%04d.vdb and mantaflow_drift/fluid_data_%04d.vdb; without it their pictures stay as they are.
set -euo pipefail
tools=$(cd "$1" && pwd)
data=${2:+$(cd "$2" && pwd)}
cd "$(dirname "$0")/.."
out=out/gallery images=docs/images/gallery
mkdir -p "$out" "$images"

# picture NAME FRAME OPTIONS...
picture() {
    local name=$1 frame=$2
    shift 2
    "$tools/vdblic_render" "$out/${name%%-*}.%04d.vdb" -o "$out/$name.png" --frames "$frame" --size 720 450 --samples 4 -q "$@"
    ffmpeg -loglevel error -y -i "$out/$name.png" -q:v 3 "$images/$name.jpg"
}

# gallery NAME FRAME CUT...
gallery() {
    local name=$1 frame=$2
    shift 2
    for look in flow ink smoke xray; do picture "$name-$look" "$frame" --look "$look"; done
    picture "$name-cut" "$frame" "$@"
    picture "$name-halo" "$frame" --halo 1.5 --depth-cue 0.5
}

"$tools/vdblic_advect" samples/wake/wake.%04d.vdb -o "$out/wake.%04d.vdb" -q >"$out/log.txt"
gallery wake 12 --clip-plane 0 0 0 0 1 0
"$tools/vdblic_synth" tornado -o "$out/v.%04d.vdb" --size 144 73 81 --frames 1-12 -q >>"$out/log.txt"
"$tools/vdblic_advect" "$out/v.%04d.vdb" -o "$out/tornado.%04d.vdb" -q >>"$out/log.txt"
gallery tornado 8 --clip-plane 7.2 3.6 4.5 0 0 -1
if [ -n "$data" ]; then
    "$tools/vdblic_advect" "$data/era5_west_europe/era5.%04d.vdb" -o "$out/era.%04d.vdb" --frames 1-12 -q >>"$out/log.txt"
    gallery era 10 --clip-plane 0 0 5500 0 0 -1
    "$tools/vdblic_advect" "$data/mantaflow_drift/fluid_data_%04d.vdb" -o "$out/manta.%04d.vdb" -q >>"$out/log.txt"
    gallery manta 26 --clip-plane 0 1 0 0 1 0
fi

# Four frames one after the other: features move with the flow.
for frame in 9 10 11 12; do
    "$tools/vdblic_render" "$out/wake.%04d.vdb" -o "$out/strip.%04d.png" --frames "$frame" --size 420 260 -q
done
ffmpeg -loglevel error -y -start_number 9 -i "$out/strip.%04d.png" -frames:v 1 -vf tile=2x2:padding=4 -q:v 3 "$images/strip.jpg"
