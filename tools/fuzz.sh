#!/bin/sh
# Fuzzes each target for FUZZ_SECONDS (default 600) with libFuzzer, on top of the kept corpus. New
# inputs go to BUILD/corpus-NAME, crashes to BUILD. Needs clang.
#   tools/fuzz.sh [BUILD]
set -eu
cd "$(dirname "$0")/.."
build=${1:-build-fuzz}
command -v clang >/dev/null 2>&1 || { echo "fuzz: this needs clang (apt-get install clang)" >&2; exit 1; }
[ -f "$build/build.ninja" ] || CC=clang CXX=clang++ meson setup "$build" -Dfuzzers=true \
    --buildtype=debugoptimized -Db_sanitize=address,undefined -Db_lundef=false
targets=$(for corpus in tests/fuzz/corpus/*/; do echo "tests/fuzz/fuzz-$(basename "$corpus")"; done)
ninja -C "$build" penumbra-import $targets
export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp:print_suppressions=0"
export ASAN_OPTIONS="allocator_may_return_null=1"
for corpus in tests/fuzz/corpus/*/; do
    name=$(basename "$corpus")
    [ -x "$build/tests/fuzz/fuzz-$name" ] || continue
    mkdir -p "$build/corpus-$name"
    echo "fuzz: $name"
    "$build/tests/fuzz/fuzz-$name" -max_total_time="${FUZZ_SECONDS:-600}" -timeout=30 \
        -rss_limit_mb=4096 -malloc_limit_mb=16384 -artifact_prefix="$build/crash-$name-" "$build/corpus-$name" "$corpus"
done
