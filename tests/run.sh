#!/bin/sh
# Builds everything and runs every test. Ends with ctest's summary, and below it what did not run, and why. Takes ctest's
# options: tests/run.sh -R render
set -eu
cd "$(dirname "$0")/.."

.ci/packages.sh || echo "continuing with the installed packages" >&2
cmake --preset release
cmake --build --preset release
status=0
ctest --preset release -j "$(nproc)" "$@" || status=$?
tests/skipped.sh
exit $status
