#!/bin/sh
# Builds with Clang what turns velocities into pictures, and compares its files with those of GCC's build, byte by byte.
#
#     tests/clang.sh                            Debian's clang++-14, in build/clang
#     tests/clang.sh clang++-19 [-D...]         another, in build/clang++-19, with options of cmake
set -eu
cd "$(dirname "$0")/.."
compiler=${1:-clang++-14}
folder=build/${1:-clang}
[ $# = 0 ] || shift
targets="tool_synth tool_noise tool_advect tool_render"
cmake --preset release
# shellcheck disable=SC2086
cmake --build --preset release --target $targets
cmake --preset clang -B "$folder" -DCMAKE_CXX_COMPILER="$compiler" "$@"
# shellcheck disable=SC2086
cmake --build "$folder" --target $targets

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
make_files() { # TOOLS FOLDER
    mkdir "$2"
    "$1/vdblic_synth" tornado -o "$2/tornado.%04d.vdb" --size 40 32 24 --frames 1-2 -q
    "$1/vdblic_noise" -o "$2/noise.vdb" --like samples/wake/wake.0001.vdb --refine 2 -q
    while read -r name options; do
        # shellcheck disable=SC2086
        "$1/vdblic_advect" samples/wake/wake.%04d.vdb -o "$2/$name.%04d.vdb" --frames 1-6 --precision float -q $options
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
    "$1/vdblic_render" "$2/auflic.0006.vdb" -o "$2/auflic.exr" --size 240 135 --precision float --aov all -q
    "$1/vdblic_render" "$2/auflic.0006.vdb" -o "$2/auflic.png" --size 240 135 --samples 4 --look vortex --solid domain \
        --ground below --annotate box,colorbar -q
    "$1/vdblic_render" "$2/streaks.0006.vdb" -o "$2/streaks.png" --size 240 135 --samples 4 -q
}
make_files build/release/tools "$out/gcc" >/dev/null
make_files "$folder/tools" "$out/clang" >/dev/null
diff -r "$out/gcc" "$out/clang"
set -- "$out"/clang/*
echo "$# files of $("$compiler" --version | head -n 1) are those of GCC"
