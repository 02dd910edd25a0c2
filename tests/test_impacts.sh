#!/usr/bin/env bash
# The impact tests of Chung & Ooi against closed forms: all within what bench_impacts.c derives, and not any more with a
# time step that is too long for it; its scenes are sound. Usage: test_impacts.sh BENCH SCENES SIM
set -euo pipefail

bench=$1 scenes=$2 sim=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$bench" --scenes "$scenes" --out "$work" >"$work/fine" || { cat "$work/fine" && exit 1; }
checks=$(sed -n 's/^\([0-9]*\) checks, 0 missed.*/\1/p' "$work/fine")
[ "${checks:-0}" -ge 260 ] || { echo "only ${checks:-no} checks" && exit 1; }

# twenty steps a contact: contact times are off by (2 pi/20)^2/24, some 4e-3, where 1e-4 is allowed
code=0
"$bench" --scenes "$scenes" --out "$work" --coarser 50 >"$work/coarse" 2>/dev/null || code=$?
[ "$code" -eq 11 ] || { echo "exit code $code with coarse steps" && exit 1; }
[ "$(grep -c 'contact time .*\*' "$work/coarse")" -eq 4 ] || { echo "coarse steps pass" && cat "$work/coarse" && exit 1; }

for scene in "$scenes"/*.cfg; do
    said=$("$sim" "$scene" --in-process --progress 2>&1) || true
    [[ $said == *'verdict: sound'* ]] || { echo "$scene: $said" && exit 1; }
done
