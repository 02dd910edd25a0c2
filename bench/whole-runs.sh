#!/usr/bin/env bash
# Whole runs of scenes A and B, all stages at the papers' time steps and at dt_s = "auto": CPU time of the process and
# energy ledger.
# ./shakedown bench whole-runs [--beside FOLDER] [--scene A|B] [--set KEY=VALUE]...
# --beside: of a tree that is built, another version, with its own scenes; it runs at the papers' steps too.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"
read_options '' '--beside --scene --set' '--beside --scene' "$@"

TIMEFORMAT='cpu %U %S'

# Three stages each.
steps() { # STEP
    printf -- '--set\nstages.%s.dt_s=%s\n' 0 "$1" 1 "$1" 2 "$1"
}

# Prints a row: seconds, steps, the ledger residuals of the last stage and of the worst (a version that says none: -), the verdict.
row() { # NAME SIM SCENE STEP
    local name=$1 sim=$2 scene=$3 step=$4 said set
    mapfile -t set < <(steps "$step")
    said=$({ time "$sim" "$scene" --in-process --progress "${set[@]}" "${options[@]}"; } 2>&1) || true
    awk -v name="$name" -v step="$step" '
        /ledger residual/ { sub(/.*ledger residual /, ""); r = $1 < 0 ? -$1 : $1; if (r > worst) worst = r; last = r; seen = 1 }
        /^cpu / { cpu = $2 + $3 }
        / steps, / { for (k = 2; k <= NF; k++) if ($k == "steps,") n = $(k - 1) }
        /verdict:/ { sub(/.*verdict: /, ""); verdict = $1 }
        END { printf "| %s | %s | %.2f | %d | %s | %s |\n", name, step, cpu, n, seen ? sprintf("%.1e | %.1e", last, worst) : "- | -", verdict }' \
        <<<"$said"
}

echo '| run | dt_s | CPU, s | steps | ledger residual, last stage | largest | verdict |'
echo '|---|---|---|---|---|---|---|'
for scene in A B; do
    [[ ${given[--scene]:-$scene} == "$scene" ]] || continue
    case $scene in
        A) file=scenes/biaxial.cfg step=5e-7 ;;
        B) file=scenes/triaxial_cyclic.cfg step=2e-5 ;;
    esac
    if [ -n "${given[--beside]:-}" ]; then
        row "scene $scene, the other version" "${given[--beside]}/build/sim/sim" "${given[--beside]}/$file" "$step"
    fi
    row "scene $scene" "$bin/sim/sim" "$root/$file" "$step"
    row "scene $scene" "$bin/sim/sim" "$root/$file" '"auto"'
done
