#!/bin/sh
# Runs the tests of a build folder and counts them one by one.
#   tools/test.sh [BUILD [meson test argument...]]
# The last line is "N passed, N failed, N skipped". Fails if a test failed. With CI set, a test that
# was skipped counts as failed, unless it cannot run here: one named after a processor's instructions
# that are missing, any where the shared meshes are absent, and any under the sanitizers (they forbid
# limits of memory; the plain run owes those tests).
set -eu
cd "$(dirname "$0")/.."
build=${1:-build}
[ $# -eq 0 ] || shift
models=${PNB_MODELS:-../shared/models}
strict=no
if [ -n "${CI:-}" ] && [ -d "$models" ] && [ -z "${PNB_SANITIZED:-}" ]; then
    strict=yes
fi
flags=$(sed -n 's/^flags[^:]*: / /p' /proc/cpuinfo 2>/dev/null | head -n 1 || true)

log=$build/meson-logs/testlog.txt
rm -f "$log"
status=0
CMOCKA_MESSAGE_OUTPUT=TAP meson test -C "$build" --no-rebuild --print-errorlogs "$@" || status=$?
[ -f "$log" ] || { echo "the tests did not run"; exit 1; }

# Programs speak TAP: "1..N", "ok I - NAME", "not ok I - NAME", "... # SKIP NAME".
awk -v status="$status" -v strict="$strict" -v flags=" $flags " '
    function lacks(name, word, flag) { return index(name, word) && !index(flags, " " flag " ") }
    function finish() {
        if (program == "")
            return
        missing = planned - ok - bad - skip
        lost = missing > 0 ? missing : 0
        if (result != "exit status 0" && !(result == "exit status 77" && bad == 0)) {
            if (bad + lost == 0)
                lost = 1
            if (lost > 0)
                print "FAILED " program ": " result
        } else if (result == "exit status 77" && ok + skip == 0) {
            skip = 1
            owed += strict == "yes"
            print "SKIPPED " program
        } else if (ok + bad + skip == 0) {
            ok = 1
        }
        passed += ok; failed += bad + lost; skipped += skip
        program = ""
    }
    /^test: /   { finish(); sub(/^test: */, ""); program = $0; result = ""; planned = ok = bad = skip = 0; next }
    /^result: / { sub(/^result: */, ""); result = $0; next }
    program == "" { next }
    /^1\.\.[0-9]+$/ { planned += substr($0, 4); next }
    /^(not )?ok [0-9]+.*# SKIP/ {
        skip++
        may = lacks($0, "avx512", "avx512f") || lacks($0, "avx2", "avx2")
        if (strict == "yes" && !may)
            owed++
        print "SKIPPED " program ": " $NF
        next
    }
    /^not ok [0-9]+/ { bad++; print "FAILED " program ": " $NF; next }
    /^ok [0-9]+/ { ok++; next }
    END {
        finish()
        if (owed > 0) {
            print owed " skipped that should run here"
            failed += owed; skipped -= owed
        }
        if (failed == 0 && status != 0)
            failed = 1
        printf "%d passed, %d failed, %d skipped\n", passed, failed, skipped
        exit failed > 0
    }' "$log"
