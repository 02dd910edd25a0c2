#!/usr/bin/env bash
# Cost of a particle-step against the number of particles, with shares of the phases and of list builds:
# ./shakedown bench scaling [--dimension 2|3] [--precision double|mixed] [--counts N,N,...] [--threads T,T,...] [--busy] [--bandwidth GB/s] [--cache MB] [--json FILE] [--plot PNG]
# The whole of it takes about ten minutes and 2.5 GB of memory. --plot also takes a table printed before: --table FILE.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"

read_options '--busy' '--dimension --precision --counts --threads --bandwidth --cache --json --plot --table' '--plot --table' "$@"
table=${given[--table]:-}
if [ -z "$table" ]; then
    table=$(mktemp)
    trap 'rm -f "$table"' EXIT
    "$bin/bench/bench_scaling" "${options[@]}" | tee "$table"
fi
[ -z "${given[--plot]:-}" ] || gnuplot -e "table='$table'; picture='${given[--plot]}'" "$root/bench/scaling.gp"
