#!/usr/bin/env bash
# Random legal scenes, from nm to km: ./shakedown bench odd-scenes [N] [--seed S] [--out DIR] [--limit-s T]
# Each must end sound, doubtful with the reason, or refused or stopped with what would help. Exit code 1 if one does not.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"
count=200
if [[ ${1:-} =~ ^[0-9]+$ ]]; then
    count=$1
    shift
fi
read_options "" "--seed --out --limit-s" "--seed --out --limit-s" "$@"
take_out
exec "$bin/bench/bench_odd_scenes" "$bin/sim/sim" "$out" "$count" "${given[--seed]:-1}" "${given[--limit-s]:-30}"
