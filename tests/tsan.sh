#!/bin/sh
# Looks for races with the thread sanitizer: in tools beside each other, a film, the viewer and a comparison
# (tests/cli/test_threads.py), and in the unit tests.
#
#     tests/tsan.sh [options of vdblic_tests]
#
# The sanitizer must see how TBB hands work from thread to thread, so TBB is built with it, too, from Debian's source:
# that needs a Debian with the network, as root.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
tbb=$root/build/tbb-tsan

library() { find "$tbb/build" -name libtbb.so 2>/dev/null; }
if [ -z "$(library)" ]; then
    mkdir -p "$tbb/source"
    (
        cd "$tbb"
        # The machine's sources, for source packages, in lists of our own: the machine's stay as they are.
        mkdir -p sources lists/partial
        cat /etc/apt/sources.list /etc/apt/sources.list.d/*.list 2>/dev/null |
            sed -n 's/^[[:space:]]*deb[[:space:]]/deb-src /p' >sources/machine.list
        sed -s 's/^Types:.*/Types: deb-src/I; $G' /etc/apt/sources.list.d/*.sources 2>/dev/null >sources/machine.sources || true
        set -- -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts="$tbb/sources" -o Dir::State::Lists="$tbb/lists"
        apt-get update -qq "$@"
        apt-get source -qq --download-only "$@" onetbb
        tar xf onetbb_*.orig.tar.* -C source --strip-components=1
    )
    cmake -S "$tbb/source" -B "$tbb/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread \
        -DTBB_TEST=OFF -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF -DCMAKE_CXX_COMPILER_LAUNCHER=ccache
    cmake --build "$tbb/build"
fi
cmake --preset tsan
cmake --build --preset tsan --target tool_synth tool_advect tool_render tool_film tool_view tool_diff vdblic_tests
export LD_LIBRARY_PATH="$(dirname "$(library)")" TSAN_OPTIONS="suppressions=$root/tests/support/tsan.supp"
VDBLIC_BIN=$root/build/tsan/tools /usr/bin/python3 -B tests/cli/test_threads.py
exec build/tsan/tests/vdblic_tests "$@"
