#!/usr/bin/env bash
# Random legal scenes, from nm to km: ./shakedown bench odd-scenes [N] [--seed S] [--out DIR] [--limit-s T] [--sanitize]
# Each must end sound, doubtful with the reason, or refused or stopped with what would help. Exit code 1 if one does not.
# --sanitize: with address and undefined-behaviour sanitizers, built beside in build-sanitize (several minutes).
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"
count=200
if [[ ${1:-} =~ ^[0-9]+$ ]]; then
    count=$1
    shift
fi
read_options "--sanitize" "--seed --out --limit-s" "--sanitize --seed --out --limit-s" "$@"
take_out
if [ -n "${given[--sanitize]:-}" ]; then
    (cd "$root" && cmake --preset sanitize >/dev/null &&
        cmake --build build-sanitize --target sim bench_odd_scenes) || exit
    bin=$root/build-sanitize
    export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
fi
exec "$bin/bench/bench_odd_scenes" "$bin/sim/sim" "$out" "$count" "${given[--seed]:-1}" "${given[--limit-s]:-30}"
