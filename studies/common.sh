# shellcheck shell=bash
# What the studies share; sourced, not run. Runs go in one process each, where the exact loop costs
# nothing, two at a time.
set -uo pipefail

root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
# shellcheck disable=SC2034 # the studies use it
bin=${SHAKEDOWN_BIN:?start it with ./shakedown study}
at_once=2
failures=0

say() {
    printf '%(%H:%M:%S)T study: %s\n' -1 "$*" >&2
}

die() {
    say "error: $*"
    exit 1
}

# The run's folder is $out/NAME; its messages go to $out/NAME.log. A run that is there already is kept.
run() { # NAME SCENE OPTIONS...
    local name=$1
    shift
    if [ -f "$out/$name/analysis.json" ]; then
        say "$name: there already"
        return
    fi
    if [ "$(jobs -pr | wc -l)" -ge "$at_once" ]; then
        wait -n || failures=$((failures + 1))
    fi
    (
        SECONDS=0
        say "$name: started"
        "$root/shakedown" run --set coupling.interval_steps=1 "$@" --in-process --out "$out/$name" >"$out/$name.log" 2>&1
        code=$?
        say "$name: ended with exit code $code after $SECONDS s"
        exit "$code"
    ) &
}

# Waits for all; ends the study if one has failed.
finish() {
    while [ "$(jobs -p | wc -l)" -gt 0 ]; do
        wait -n || failures=$((failures + 1))
    done
    [ "$failures" -eq 0 ] || die "$failures runs failed; see $out/*.log"
}

new_folder() { # NAME: sets `out`, unless it is set, and makes it
    [ -n "$out" ] || printf -v out 'runs/%s-%(%Y%m%d-%H%M%S)T' "$1" -1
    mkdir -p "$out" || die "cannot create $out"
    out=$(readlink -f "$out")
}
