#!/bin/sh
# What takes too long for every push, in one command, on Debian 12 as root: all cases of the tests of which .ci/run takes one
# of a kind, every public header by itself, all unit tests under the address and undefined-behaviour sanitizers, tools and
# unit tests under the thread sanitizer, a build with Clang whose files are compared with GCC's, and ten minutes of fuzzing.
# Goes on after a failure; the end tells each part's result and its time, and the status is 1 if one failed.
set -u
cd "$(dirname "$0")/.." || exit
summary=$(mktemp)
trap 'rm -f "$summary"' EXIT
failed=0

part() {
    begun=$(date +%s)
    if "$@"; then result=passed; else result=FAILED failed=1; fi
    echo "$result: $* ($(($(date +%s) - begun)) s)" >>"$summary"
}

part .ci/packages.sh
part tests/peers.sh
part env VDBLIC_NIGHTLY=1 tests/run.sh --timeout 7200
part cmake --build --preset release --target all_verify_interface_header_sets
part tests/asan.sh
part tests/tsan.sh
part tests/compare_builds.sh clang
part tests/fuzz/run.sh 600
cat "$summary"
exit $failed
