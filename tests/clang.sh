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
tests/support/make_files.sh "$out/gcc" build/release/tools >/dev/null
tests/support/make_files.sh "$out/clang" "$folder/tools" >/dev/null
diff -r "$out/gcc" "$out/clang"
set -- "$out"/clang/*
echo "$# files of $("$compiler" --version | head -n 1) are those of GCC"
