#!/usr/bin/env bash
# Error of the curve and of the energy ledger against the finest run, and what it costs, as time step, skin, exchange
# interval and precision vary (docs/accuracy.md):
# ./shakedown bench accuracy [--quick] [--scene A|A-cohesive|B|B-fresh] [--out DIR] [--json FILE] [--plot FILE.png]
#                            [--from FILE] [--through COMMAND] [--set KEY=VALUE]...
# --quick: in a minute; --out keeps the prepared samples for the next time; --through: every run is
# started by it; --from: no runs, the results in FILE (of --json) are plotted.
set -euo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
bin=${SHAKEDOWN_BIN:-$root/build}

out='' options=()
while [ $# -gt 0 ]; do
    case $1 in
        --quick) options+=("$1") ;;
        --out | --scene | --json | --plot | --from | --through | --set)
            [ $# -ge 2 ] || { echo "bench accuracy: $1 needs a value" >&2 && exit 2; }
            if [ "$1" = --out ]; then out=$2; else options+=("$1" "$2"); fi
            shift
            ;;
        *)
            echo "bench accuracy: unknown option $1; see the head of $0" >&2
            exit 2
            ;;
    esac
    shift
done
if [ -z "$out" ]; then
    out=$(mktemp -d)
    trap 'rm -rf "$out"' EXIT
fi
"$bin/bench/bench_accuracy" --bin "$bin" --scenes "$root/scenes" --out "$out" "${options[@]}"
