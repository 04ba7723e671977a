#!/bin/sh
# Builds everything and runs every test; the last lines are ctest's summary. Takes ctest's options: tests/run.sh -R render
set -eu
cd "$(dirname "$0")/.."

.ci/packages.sh || echo "continuing with the installed packages" >&2
cmake --preset release
cmake --build --preset release
ctest --preset release -j "$(nproc)" "$@"
