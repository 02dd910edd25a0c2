#!/usr/bin/env bash
# Error against cost of the coupling schemes through the whole pipeline, beside the exact loop in one process, and what
# they do in hard cases (docs/coupling.md):
# ./shakedown bench coupling [--quick] [--scene a|a-cohesion|b|hard|FILE] [--out DIR] [--json FILE] [--plot FILE.png]
#                            [--scheme NAME] [--lock FILE:...] [--set KEY=VALUE]...
# In a network namespace of its own. --quick: in two minutes; --out keeps the prepared samples for the next time;
# --lock: holds these files' locks (as flock) while it takes times.
set -euo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
bin=${SHAKEDOWN_BIN:-$root/build}

out='' options=()
while [ $# -gt 0 ]; do
    case $1 in
        --quick) options+=("$1") ;;
        --out | --scene | --json | --plot | --scheme | --lock | --set)
            [ $# -ge 2 ] || { echo "bench coupling: $1 needs a value" >&2 && exit 2; }
            if [ "$1" = --out ]; then out=$2; else options+=("$1" "$2"); fi
            shift
            ;;
        *)
            echo "bench coupling: unknown option $1; see the head of $0" >&2
            exit 2
            ;;
    esac
    shift
done
if [ -z "$out" ]; then
    out=$(mktemp -d)
    trap 'rm -rf "$out"' EXIT
fi
"$root/tests/in_namespace.sh" "$bin/bench/bench_coupling" --bin "$bin" --scenes "$root/scenes" --out "$out" \
    "${options[@]}"
