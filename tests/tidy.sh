#!/bin/sh
# Runs clang-tidy with the checks of .clang-tidy. Fails if anything is found.
#
#     tests/tidy.sh [PATTERN]          every source of the library, the tools and the tests, or those whose path matches the
#                                      regular expression; all take some twenty minutes on two cores
#     tests/tidy.sh --since REVISION   the sources in which most lines changed since then, six at most: some two minutes
#
# Its trees are configured, never built. For all of them several sources are one unit, so that OpenVDB's headers are parsed
# less often. Units that hold one header each are left out: the header is checked where it is included.
set -eu
cd "$(dirname "$0")/.."

configure() {
    tree=$1
    shift
    cmake -S . -B "$tree" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DVDBLIC_CCACHE= "$@" >/dev/null
}
tidy() { run-clang-tidy -quiet -extra-arg=-Wno-unknown-warning-option -extra-arg=-Wno-psabi "$@"; }

if [ "${1-}" != --since ]; then
    configure build/tidy -DCMAKE_UNITY_BUILD=ON
    tidy -p build/tidy -checks=-bugprone-suspicious-include "${1:-^(?!.*_interface_header_sets)}" # a unit includes sources
    exit
fi
# A header stands for the source beside it.
changed=$(git diff --numstat --no-renames --diff-filter=d "$2" -- lib tools tests ':!tests/fuzz' | grep '\.\(cpp\|h\)$' |
    while read -r added _ path; do
        source=${path%.*}.cpp
        [ ! -e "$source" ] || echo "$added $source"
    done | awk '{ lines[$2] += $1 } END { for (path in lines) print lines[path], path }' | sort -k1,1nr -k2 | head -n 6)
[ -n "$changed" ] || exit 0
configure build/tidy-change
echo "$changed" | sed 's/[^ ]* /clang-tidy: /'
tidy -p build/tidy-change $(echo "$changed" | sed 's/[^ ]* \(.*\)/^.*\/\1$/')
