#!/bin/sh
# Runs the unit tests under the address and undefined-behaviour sanitizers.
set -eu
cd "$(dirname "$0")/.."
cmake --preset asan-ubsan
cmake --build --preset asan-ubsan --target vdblic_tests
export LSAN_OPTIONS=suppressions=tests/support/lsan.supp:print_suppressions=0
# In many parts that take turns on the cores: some tests take a hundred times as long as others.
seq 0 23 | xargs -P "$(nproc)" -I "{}" env GTEST_TOTAL_SHARDS=24 "GTEST_SHARD_INDEX={}" \
    build/asan-ubsan/tests/vdblic_tests --gtest_brief=1
