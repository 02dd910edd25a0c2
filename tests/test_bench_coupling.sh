#!/usr/bin/env bash
# ./shakedown bench coupling on a scene of a second: what it reports, how it survives runs that fail, what it leaves.
# test_bench_coupling.sh CASE; SHAKEDOWN_BIN: the build folder.
set -uo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
scene=$root/tests/scenes/small.cfg
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/tmp"
export TMPDIR=$work/tmp

fail() {
    echo "$*"
    exit 1
}

bench() { # OPTIONS...
    "$root/bench/coupling.sh" "$@" >"$work/table" 2>"$work/progress"
}

nothing_left() {
    [ -z "$(ls -A "$TMPDIR")" ] || fail "left behind: $(ls "$TMPDIR")"
}

case_report() {
    bench --quick --scene "$scene" --json "$work/report.json" --plot "$work/plot.png" --lock "$work/lock" ||
        fail "exit code $?: $(tail -n 5 "$work/progress")"
    "$SHAKEDOWN_BIN/tests/test_bench_coupling" "$work/report.json" || fail "report: see above"
    [ "$(head -c 4 "$work/plot.png" | tail -c 3)" = PNG ] || fail "no picture"
    grep -q 'impedance 64 .* s left' "$work/progress" || fail "no progress: $(cat "$work/progress")"
    grep -q 'hold 256 .*unstable: step' "$work/table" || fail "no word of the unstable run: $(cat "$work/table")"
    nothing_left
}

# A line of the table of shipped scenes: as it is coupled, and impedance beside.
case_shipped() {
    bench --shipped --scene relaxation --set sample.count=64 --set stages.0.duration_s=0.2 --set stages.1.duration_s=0.05 ||
        fail "exit code $?: $(tail -n 5 "$work/progress")"
    grep -Eq '^relaxation +[0-9.]+ +[0-9]+ +[0-9]+ +[0-9.]+ +[0-9.e-]+ +[0-9.]+ +[0-9.e-]+ ' "$work/table" || fail "$(cat "$work/table")"
    bench --shipped --scene nothing
    [ $? -eq 2 ] || fail "a scene that is none is taken"
    nothing_left
}

# Makes a folder of programs, of which one fails in every run over the bus, with a reason.
one_that_fails() { # PROGRAM OPTION-OF-THE-OTHER-WAY
    local row
    rm -rf "${work:?}/bin"
    mkdir -p "$work/bin/$1"
    for row in bench recorder sim wallctl; do [ "$row" = "$1" ] || ln -s "$SHAKEDOWN_BIN/$row" "$work/bin/$row"; done
    cat >"$work/bin/$1/$1" <<PROGRAM
#!/bin/sh
case " \$* " in *" $2 "*) exec "$SHAKEDOWN_BIN/$1/$1" "\$@" ;; esac
echo "$1: error: told to fail" >&2
exit 8
PROGRAM
    chmod +x "$work/bin/$1/$1"
}

# A sim that fails in every run over the bus: the bench says so of each, and ends well. So it does if another process
# fails, for which sim by itself would wait for minutes.
case_failing_runs() {
    one_that_fails sim --in-process
    SHAKEDOWN_BIN=$work/bin bench --quick --scene "$scene" --json "$work/report.json" ||
        fail "exit code $?: $(tail -n 5 "$work/progress")"
    [ "$(grep -c 'failed: told to fail' "$work/table")" -eq 30 ] || fail "$(cat "$work/table")"
    nothing_left
    for program in recorder wallctl; do
        one_that_fails "$program" --from
        SHAKEDOWN_BIN=$work/bin bench --quick --scene "$scene" --scheme adaptive ||
            fail "exit code $?: $(tail -n 5 "$work/progress")"
        [ "$(grep -c "failed: $program ended with exit code 8: told to fail" "$work/table")" -eq 3 ] || fail "$(cat "$work/table")"
        grep -q "failed: $program ended with exit code 8" "$work/progress" || fail "$(cat "$work/progress")"
        nothing_left
    done
}

case_usage() {
    bench --nonsense
    [ $? -eq 2 ] && grep -q 'unknown option --nonsense' "$work/progress" || fail "an unknown option"
    bench --scene
    [ $? -eq 2 ] && grep -q 'needs a value' "$work/progress" || fail "an option without its value"
    bench --scene "$work/nothing.cfg"
    [ $? -eq 2 ] && grep -q 'nothing.cfg' "$work/progress" || fail "no such scene: $(cat "$work/progress")"
    nothing_left
}

"case_$1"
