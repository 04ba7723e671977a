#!/bin/sh
# Names what the last run of ctest in build/release did not run, and why.
#
#     tests/skipped.sh           all of it
#     tests/skipped.sh --fail    what lacks something that .ci/packages.sh installs; fails if there is any
set -eu
cd "$(dirname "$0")/.."
# What a test may lack where .ci/packages.sh has run: packages of PyPI (tests/peers.sh), the time of a night, large data
# sets, a right to mount or to see what the kernel tells of a process.
peers='usd-core|bpy|pyvista|NumPy 2|Matplotlib|mypy|nbclient'
may_lack="$peers|tests/nightly.sh|VDBLIC_DATA|mount|this system"

did_not_run() {
    awk '/^[0-9]+\/[0-9]+ Testing: / { test = $3 }
        sub(/^skipped: /, "") {
            name = sub(/^[A-Za-z0-9_]+\.test_[a-z0-9_]+: /, "") ? " in part" : ""
            count[test name ": " $0]++
        }
        END { for (what in count) printf "    %s%s\n", what, (count[what] > 1 ? " (" count[what] " tests)" : "") }' \
        build/release/Testing/Temporary/LastTest.log | sort
}

if [ "${1-}" = --fail ]; then
    lacking=$(did_not_run | grep -Ev ": .*($may_lack)" || true)
    [ -z "$lacking" ] && exit 0
    echo "did not run, though .ci/packages.sh has what is missing:"
    echo "$lacking"
    exit 1
fi
skipped=$(did_not_run)
[ -z "$skipped" ] || printf 'did not run:\n%s\n' "$skipped"
