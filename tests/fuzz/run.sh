#!/bin/sh
# Fuzzes the parsers that are ours, with clang's libFuzzer, under its address and undefined-behaviour sanitizers:
# tests/fuzz/run.sh [SECONDS, 60 by default]. Starts from corpus/; what it finds worth keeping goes to build/fuzz/corpus.
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-60}
out=build/fuzz
command -v clang++ >/dev/null || { echo "clang++ is missing; not fuzzed" >&2; exit 0; }

compile() {
    target=$1
    shift
    clang++ -std=c++20 -g -O1 -Wno-psabi -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -Ilib \
        "tests/fuzz/$target.cpp" "$@" -lfmt -o "$out/$target"
}

mkdir -p "$out/corpus/layout" "$out/corpus/text"
io=lib/vdblic/io look=lib/vdblic/look
compile fuzz_layout $io/vdb_layout.cpp $io/checksum.cpp &
compile fuzz_text lib/vdblic/core/memory.cpp $io/atomic_file.cpp $io/frame_list.cpp $io/path_list.cpp \
    $io/pattern_advice.cpp $io/sequence.cpp $io/grid_reference.cpp $look/transfer_params.cpp lib/vdblic/image/color_map.cpp \
    $look/scalar_axis.cpp
wait $!
fuzz() {
    "$out/fuzz_$1" -max_total_time=$((seconds / 2)) -timeout=10 -rss_limit_mb=1024 -artifact_prefix="$out/" \
        -print_final_stats=1 "$out/corpus/$1" "tests/fuzz/corpus/$1"
}
fuzz layout &
fuzz text
wait $!
