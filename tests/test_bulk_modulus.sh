#!/usr/bin/env bash
# K of an isotropic test, by the analyzer and by hand from the record: (p1 - p0)/ln(V0/V1) between the first and the last
# sample of the stage. Both are secants of the same ends, so that 1 % is far more than they may differ by.
set -uo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
settings=()
for axis in x y z; do
    settings+=(--set "stages.2.walls.$axis.pressure_end_pa=2000.0" --set "stages.2.walls.$axis.ramp_s=0.2"
        --set "stages.3.walls.$axis.pressure_pa=2000.0" --set "stages.3.walls.$axis.ramp_s=0.2")
done

numbers() { # DATASET: one number a line
    h5dump -y -w 0 -m %.15g -d "/samples/$1/value" "$work/run/run.h5" | sed -n '/DATA {/,/}/p' | sed '/[{}]/d' |
        tr -s ', ' '\n' | grep .
}

"$root/shakedown" run "$root/scenes/isotropic.cfg" --in-process --out "$work/run" "${settings[@]}" \
    --set 'analysis.stage="load"' >"$work/said" 2>&1 || { cat "$work/said" && exit 1; }
paste -d ' ' <(numbers stage) <(numbers box_length_m | paste -d ' ' - - -) \
    <(numbers stress_wall_pa | paste -d ' ' - - -) >"$work/table"
hand=$(awk '$1 == 2 { v = $2 * $3 * $4; p = ($5 + $6 + $7) / 3; if (!n++) { v0 = v; p0 = p } }
    END { printf "%.6g", (p - p0) / log(v0 / v) }' "$work/table")
analyzed=$(sed -n '/"K_loading_pa"/,/}/s/.*"value": \([0-9.e+-]*\),*$/\1/p' "$work/run/analysis.json")
echo "K by hand $hand Pa, by the analyzer $analyzed Pa"
awk -v a="$hand" -v b="$analyzed" 'BEGIN { exit !(a > 0 && b / a > 0.99 && b / a < 1.01) }'
