#!/usr/bin/env bash
# Cost of a particle-step against the number of particles, with shares of the phases and of list builds:
# ./shakedown bench scaling [--dimension 2|3] [--counts N,N,...] [--threads T,T,...] [--json FILE] [--plot PNG]
# The whole of it takes about ten minutes and 2.5 GB of memory. --plot also takes a table printed before: --table FILE.
set -euo pipefail
root=$(dirname "$(readlink -f "$0")")/..
plot='' table='' arguments=()
while [ $# -gt 0 ]; do
    case $1 in
        --plot | --table)
            [ $# -gt 1 ] || {
                echo "scaling: error: $1 needs a file" >&2
                exit 2
            }
            declare "${1#--}=$2"
            shift
            ;;
        *) arguments+=("$1") ;;
    esac
    shift
done

if [ -z "$table" ]; then
    table=$(mktemp)
    trap 'rm -f "$table"' EXIT
    "${SHAKEDOWN_BIN:-$root/build}/bench/bench_scaling" "${arguments[@]}" | tee "$table"
fi
[ -z "$plot" ] || gnuplot -e "table='$table'; picture='$plot'" "$root/bench/scaling.gp"
