#!/bin/sh
# Fuzzes the parsers that are ours, with clang's libFuzzer, under its address and undefined-behaviour sanitizers:
# tests/fuzz/run.sh [SECONDS, 60 by default]. Starts from corpus/; what it finds worth keeping goes to build/fuzz/corpus.
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-60}
out=build/fuzz lib=lib/vdblic
command -v clang++ >/dev/null || { echo "clang++ is missing; not fuzzed" >&2; exit 0; }

sources() {
    case $1 in
        layout) echo $lib/io/vdb_layout.cpp $lib/io/checksum.cpp ;;
        text) echo $lib/core/memory.cpp $lib/core/system_memory.cpp $lib/core/paging.cpp $lib/core/parameters.cpp $lib/io/atomic_file.cpp $lib/io/input_files.cpp tests/fuzz/no_checkpoint.cpp $lib/io/frame_list.cpp \
            $lib/io/path_list.cpp $lib/io/pattern_advice.cpp $lib/io/frame_pattern.cpp $lib/io/input_file.cpp $lib/io/sequence.cpp $lib/io/grid_reference.cpp $lib/look/transfer_params.cpp \
            $lib/image/color_map.cpp $lib/look/scalar_axis.cpp ;;
        json) echo $lib/core/parameters.cpp $lib/camera/*.cpp $lib/io/json_file.cpp $lib/io/input_file.cpp $lib/io/atomic_file.cpp $lib/io/input_files.cpp tests/fuzz/no_checkpoint.cpp \
            $lib/look/transfer_file.cpp $lib/look/transfer_params.cpp $lib/look/scalar_axis.cpp $lib/image/color_map.cpp ;;
    esac
}

compile() {
    mkdir -p "$out/corpus/$1"
    clang++ -std=c++20 -g -O1 -Wno-psabi -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -Ilib -Itools \
        "tests/fuzz/fuzz_$1.cpp" $(sources "$1") -lfmt -o "$out/fuzz_$1"
}

fuzz() {
    "$out/fuzz_$1" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 -artifact_prefix="$out/" \
        -print_final_stats=1 "$out/corpus/$1" "tests/fuzz/corpus/$1"
}

for part in compile fuzz; do
    jobs=
    for name in layout text json; do
        $part "$name" &
        jobs="$jobs $!"
    done
    for job in $jobs; do wait "$job"; done
done
