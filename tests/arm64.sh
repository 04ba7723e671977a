#!/bin/sh
# Builds for ARM64 what turns velocities into pictures, runs the unit tests under QEMU and compares the files with those of
# x86-64, byte by byte. On Debian 12 as root; .ci/packages.sh says what it installs.
#
#     tests/arm64.sh
set -eu
cd "$(dirname "$0")/.."
.ci/packages.sh arm64
targets="tool_synth tool_noise tool_advect tool_render"
cmake --preset release
# shellcheck disable=SC2086
cmake --build --preset release --target $targets
cmake --preset arm64
# shellcheck disable=SC2086
cmake --build --preset arm64 --target $targets vdblic_tests

# Left out: QEMU does not set limits of memory.
left_out=Memory.IsNoMoreThanTheProcessAllowsItself
GTEST_FILTER=-$left_out ctest --test-dir build/arm64 -R '^unit' -j "$(nproc)" --timeout 7200 --output-on-failure

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
tests/support/make_files.sh "$out/x86-64" build/release/tools >/dev/null
tests/support/make_files.sh "$out/arm64" build/arm64/tools qemu-aarch64-static -L build/arm64-root >/dev/null
diff -r "$out/x86-64" "$out/arm64"
set -- "$out"/arm64/*
echo "$# files of ARM64 are those of x86-64"
