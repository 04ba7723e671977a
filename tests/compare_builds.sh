#!/bin/sh
# Makes another build of the tools that turn velocities into pictures, and compares its files with those of GCC's release
# build, byte by byte.
#
#     tests/compare_builds.sh clang [COMPILER [-D...]]       Clang, by default Debian's clang++-14; options of cmake
#     tests/compare_builds.sh arm64                          ARM64 under QEMU, with the unit tests; on Debian 12 as root
#     tests/compare_builds.sh openvdb NAME FOLDER [-D...]    another OpenVDB, with the unit tests. FOLDER holds its sources, which
#                                                            are installed in build/openvdb-NAME, or an installation. Volumes
#                                                            are compared by their values: each build reads both
set -eu
cd "$(dirname "$0")/.."
kind=${1-}
[ $# = 0 ] || shift
targets="tool_synth tool_noise tool_advect tool_render" emulator=
case $kind in
    clang)
        name=${1:-clang++-14} folder=build/${1:-clang}
        [ $# = 0 ] || shift
        set -- --preset clang -DCMAKE_CXX_COMPILER="$name" "$@"
        ;;
    arm64)
        name=ARM64 folder=build/arm64 emulator="qemu-aarch64-static -L build/arm64-root"
        .ci/packages.sh arm64
        targets="$targets vdblic_tests"
        export GTEST_FILTER=-Memory.IsNoMoreThanTheProcessAllowsItself # QEMU does not set limits of memory
        set -- --preset arm64
        ;;
    openvdb)
        name="OpenVDB $1" folder=build/vdblic-$1 prefix=$2
        if [ -f "$prefix/CMakeLists.txt" ]; then
            sources=$prefix prefix=$PWD/build/openvdb-$1
            shift 2
            # Debian's Boost and Imath are older than OpenVDB asks for, and serve.
            cmake -G Ninja -S "$sources" -B "$prefix-build" -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_BUILD_TYPE=Release \
                -DCMAKE_CXX_FLAGS_RELEASE="-O2 -DNDEBUG" -DOPENVDB_BUILD_BINARIES=OFF -DOPENVDB_CORE_STATIC=OFF \
                -DUSE_EXPLICIT_INSTANTIATION=OFF -DDISABLE_DEPENDENCY_VERSION_CHECKS=ON "$@"
            cmake --build "$prefix-build"
            cmake --install "$prefix-build" >/dev/null
            rm -r "$prefix-build"
        fi
        targets="$targets tool_diff vdblic_tests"
        set -- --preset release -DOpenVDB_ROOT="$prefix" -DCMAKE_PREFIX_PATH="$prefix" -DVDBLIC_WARNINGS_AS_ERRORS=ON
        ;;
    *) echo "usage: tests/compare_builds.sh clang|arm64|openvdb ..." >&2 && exit 2 ;;
esac
cmake --preset release
# shellcheck disable=SC2086
cmake --build --preset release --target ${targets% vdblic_tests}
cmake "$@" -B "$folder"
# shellcheck disable=SC2086
cmake --build "$folder" --target $targets
case $targets in *vdblic_tests)
    ctest --test-dir "$folder" -R '^unit' -j "$(nproc)" --timeout 7200 --output-on-failure
    ;;
esac

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
tests/support/make_files.sh "$out/a" build/release/tools >/dev/null
# shellcheck disable=SC2086
tests/support/make_files.sh "$out/b" "$folder/tools" $emulator >/dev/null
count=0
for file in "$out"/a/*; do
    other=$out/b/${file##*/} count=$((count + 1))
    case $kind$file in
        openvdb*.vdb)
            for tools in build/release/tools "$folder/tools"; do
                "$tools/vdblic_diff" "$file" "$other" --inactive --verify -q
            done
            ;;
        *) cmp "$file" "$other" ;;
    esac
done
[ "$count" = "$(ls "$out/b" | wc -l)" ] || { echo "$name: the builds made different numbers of files" >&2 && exit 1; }
echo "$name: $count files are those of GCC's release build"
