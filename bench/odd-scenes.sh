#!/usr/bin/env bash
# Random legal scenes, from nm to km: ./shakedown bench odd-scenes [N] [--seed S] [--out DIR] [--limit-s T] [--sanitize]
# Each must end sound, doubtful with the reason, or refused or stopped with what would help. Exit code 1 if one does not.
# --sanitize: with address and undefined-behaviour sanitizers, in the build folder of bench fuzz (needs clang).
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
    command -v clang >/dev/null || bench_usage "clang is missing; as root: apt-get install clang"
    bin=$root/build-fuzz
    cmake -S "$root" --preset fuzz >/dev/null && cmake --build "$bin" --target sim bench_odd_scenes || exit
    export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
fi
"$bin/bench/bench_odd_scenes" "$bin/sim/sim" "$out" "$count" "${given[--seed]:-1}" "${given[--limit-s]:-30}"
