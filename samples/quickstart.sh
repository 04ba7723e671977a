#!/usr/bin/env bash
# From a fresh clone to pictures: installs missing packages, builds, computes flow textures of samples/wake, renders
# the textures, and joins the pictures into an animation. A second run builds only what changed.
set -euo pipefail
cd "$(dirname "$0")/.."

.ci/packages.sh main || echo "continuing with the installed packages" >&2
cmake --preset release
cmake --build --preset release --target tool_advect tool_render

tools=build/release/tools
out=out/quickstart
mkdir -p "$out"
# The stages overlap: the renderer reads each texture as soon as it is finished.
look=(--look vortex --solid domain --ground below --size 960 540)
"$tools/vdblic_advect" samples/wake/wake.%04d.vdb -o "$out/lic.%04d.vdb" --refine 3 --with vorticity,q --restart |
    "$tools/vdblic_render" - -o "$out/wake.%04d.exr" "${look[@]}" >"$out/images.txt"
"$tools/vdblic_render" "$out/lic.%04d.vdb" -o "$out/wake.%04d.png" "${look[@]}" >>"$out/images.txt"
# The same flow as streaks, which show its direction: one picture, frame 12.
"$tools/vdblic_advect" samples/wake/wake.%04d.vdb -o "$out/streaks.%04d.vdb" --method streaks --draw lines \
    --spacing 1.5 --tail 3 --with q --frames 1-12 --restart >"$out/streaks.txt"
"$tools/vdblic_render" "$out/streaks.0012.vdb" -o "$out/streaks.%04d.png" --opacity-by q --solid domain --ground below \
    --size 960 540 >>"$out/images.txt"

echo
echo "flow textures: $out/lic.0001.vdb ... (density, magnitude, vorticity, q; open them in Blender or Houdini)"
echo "streaks:       $out/streaks.0001.vdb ... (lines, magnitude, q)"
echo "images:        $out/wake.0001.exr ..., $out/wake.0001.png ... and $out/streaks.0012.png"
if command -v ffmpeg >/dev/null 2>&1; then
    ffmpeg -loglevel error -y -framerate 12 -i "$out/wake.%04d.png" -vf format=yuv420p -c:v libx264 -crf 18 "$out/wake.mp4"
    echo "animation:     $out/wake.mp4"
else
    echo "animation:     none, ffmpeg is missing"
fi
