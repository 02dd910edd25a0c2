#!/usr/bin/env bash
# One scene with several seeds, two runs at a time, and the mean and spread of every parameter:
#   ./shakedown study ensemble SCENE [--seeds N] [--out DIR] [--set KEY=VALUE]...
# Runs in process: the same bits as over LCM with an interval of 1.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/.." && pwd)
scene='' seeds=5 out='' overrides=()
while [ $# -gt 0 ]; do
    case $1 in
        --seeds) seeds=$2 && shift 2 ;;
        --out) out=$2 && shift 2 ;;
        --set) overrides+=(--set "$2") && shift 2 ;;
        -*) echo "ensemble: unknown option $1" >&2 && exit 2 ;;
        *) scene=$1 && shift ;;
    esac
done
scene=${scene:-$root/scenes/biaxial.cfg}
out=${out:-$root/runs/ensemble-$(basename "$scene" .cfg)-$(date +%Y%m%d-%H%M%S)}
mkdir -p "$out"

one() { # SEED
    "$root/shakedown" run "$scene" --in-process --seed "$1" --out "$out/seed-$1" "${overrides[@]}" \
        >"$out/seed-$1.log" 2>&1 && echo "seed $1 done" >&2 || { echo "seed $1 failed: $out/seed-$1.log" >&2 && return 1; }
}

failed=0
for ((seed = 1; seed <= seeds; seed += 2)); do
    one "$seed" &
    first=$!
    if ((seed + 1 <= seeds)); then one $((seed + 1)) || failed=1; fi
    wait "$first" || failed=1
done
dirs=()
for ((seed = 1; seed <= seeds; seed++)); do [ -f "$out/seed-$seed/run.h5" ] && dirs+=("$out/seed-$seed"); done
"${SHAKEDOWN_BIN:-$root/build}/analyzer/analyzer" --no-plots --out "$out" "${dirs[@]}" | sed -n '/ensemble/,$p'
echo "results: $out"
exit "$failed"
