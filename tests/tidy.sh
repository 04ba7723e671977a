#!/bin/sh
# Runs clang-tidy over every source of the library, the tools and the tests, with the checks of .clang-tidy; takes half an
# hour on two cores. Fails if anything is found.
#
#     tests/tidy.sh [PATTERN]     only sources whose path matches the regular expression, such as lib/vdblic/io
set -eu
cd "$(dirname "$0")/.."

# Not the release preset: there several sources are compiled as one unit.
cmake --preset debug -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DVDBLIC_CCACHE= >/dev/null
exec run-clang-tidy -quiet -p build/debug -extra-arg=-Wno-unknown-warning-option "${1:-(lib|tools|tests)/}"
