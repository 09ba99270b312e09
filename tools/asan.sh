#!/bin/sh
# Builds and tests with the address and undefined-behaviour sanitizers.
#   tools/asan.sh [BUILD]
set -eu
cd "$(dirname "$0")/.."
build=${1:-build-asan}
[ -f "$build/build.ninja" ] || meson setup "$build" --buildtype=debugoptimized \
    -Db_sanitize=address,undefined -Db_lundef=false
ninja -C "$build"
# Leaks of libraries that we only call are theirs.
export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0"
export ASAN_OPTIONS="detect_leaks=1:allocator_may_return_null=1:detect_stack_use_after_return=0"
export UBSAN_OPTIONS="print_stacktrace=1:halt_on_error=1"
export PNB_SANITIZED=1
exec tools/test.sh "$build" --timeout-multiplier 4
