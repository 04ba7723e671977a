#!/bin/sh
# Builds VDBLIC with another OpenVDB, runs the unit tests, and compares its files with those of the release build: volumes
# by their values, pictures byte by byte. Each build also reads what the other wrote.
#
#     tests/openvdb.sh NAME FOLDER [-D...]    OpenVDB's sources in FOLDER, with options of cmake, or where it is installed;
#                                             OpenVDB is installed in build/openvdb-NAME, VDBLIC built in build/vdblic-NAME
set -eu
cd "$(dirname "$0")/.."
name=$1 sources=$2
shift 2
prefix=$sources folder=build/vdblic-$name
if [ -f "$sources/CMakeLists.txt" ]; then
    prefix=$PWD/build/openvdb-$name
    # Debian's Boost and Imath are older than OpenVDB asks for, and serve.
    cmake -G Ninja -S "$sources" -B "$prefix-build" -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_CXX_FLAGS_RELEASE="-O2 -DNDEBUG" -DOPENVDB_BUILD_BINARIES=OFF -DOPENVDB_CORE_STATIC=OFF \
        -DUSE_EXPLICIT_INSTANTIATION=OFF -DDISABLE_DEPENDENCY_VERSION_CHECKS=ON "$@"
    cmake --build "$prefix-build"
    cmake --install "$prefix-build" >/dev/null
    rm -r "$prefix-build"
fi
targets="tool_synth tool_noise tool_advect tool_render tool_diff"
# shellcheck disable=SC2086
cmake --preset release && cmake --build --preset release --target $targets
cmake --preset release -B "$folder" -DOpenVDB_ROOT="$prefix" -DCMAKE_PREFIX_PATH="$prefix" -DVDBLIC_WARNINGS_AS_ERRORS=ON
# shellcheck disable=SC2086
cmake --build "$folder" --target $targets vdblic_tests
"$folder/tests/vdblic_tests" --gtest_brief=1

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
tests/support/make_files.sh "$out/a" build/release/tools >/dev/null
tests/support/make_files.sh "$out/b" "$folder/tools" >/dev/null
volumes=0 pictures=0
for file in "$out"/a/*; do
    other=$out/b/${file##*/}
    case $file in
    *.vdb)
        for tools in build/release/tools "$folder/tools"; do
            "$tools/vdblic_diff" "$file" "$other" --inactive --verify -q
        done
        volumes=$((volumes + 1))
        ;;
    *)
        cmp "$file" "$other"
        pictures=$((pictures + 1))
        ;;
    esac
done
echo "OpenVDB $name: $volumes volumes have the values of the release build's, $pictures pictures its bytes"
