#!/bin/sh
# Runs clang-tidy over every source of the library, the tools and the tests, with the checks of .clang-tidy; takes some
# twenty minutes on two cores. Fails if anything is found.
#
#     tests/tidy.sh [PATTERN]     only units whose path matches the regular expression, such as vdblic_io
#
# Its tree is configured, never built. Several sources are one unit, so that OpenVDB's headers are parsed less often.
# Units that hold one header each are left out: the header is checked where it is included.
set -eu
cd "$(dirname "$0")/.."

cmake -S . -B build/tidy -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON \
    -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DVDBLIC_CCACHE= >/dev/null
exec run-clang-tidy -quiet -p build/tidy -extra-arg=-Wno-unknown-warning-option \
    -checks=-bugprone-suspicious-include "${1:-^(?!.*_interface_header_sets)}" # a unit includes sources
