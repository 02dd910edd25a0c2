#!/usr/bin/env bash
# What a bad network costs: ./shakedown bench loss [--scene FILE] [--n N] [--kinds LIST] [--set KEY=VALUE]...
# Runs the scene (default: a short one, tests/scenes/gentle.cfg) N times (default 3) over each of these networks, in turn,
# with bench/fault_shim.c between the processes and the network: quiet, 1, 5 and 20 % of the messages lost to everyone,
# 20 % missed by each receiver for itself, 20 % twice, 20 % overtaken by later ones, each 10 ms late. Prints the median of
# the times of the whole run and of its simulator, both over those of the quiet network, and how much was sent again.
# Exit code 1 if a run was not complete, or ended in another state than the first.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"
read_options '' '--scene --n --kinds --set' '--scene --n --kinds' "$@"
scene=$(readlink -f "${given[--scene]:-$root/tests/scenes/gentle.cfg}")
declare -rA faults=([quiet]='' [loss_1]=loss=0.01 [loss_5]=loss=0.05 [loss_20]=loss=0.2 [deaf_20]=deaf=0.2
    [duplicates]=duplicate=0.2 [reorder]=reorder=0.2 [delay]=delay_s=0.01)
read -ra kinds <<<"${given[--kinds]:-quiet loss_1 loss_5 loss_20 deaf_20 duplicates reorder delay}"
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
unset LCM_DEFAULT_URL
state=''

attribute() { # NAME
    h5dump -a "/$1" "$out/run/run.h5" | sed -n 's/^ *(0): //p'
}

run_once() { # KIND SEED: adds a line of numbers to the kind's file
    local start end now
    rm -rf "$out/run"
    start=${EPOCHREALTIME//[!0-9]/}
    FAULTS_NET=${faults[$1]:+${faults[$1]},seed=$2} LD_PRELOAD=$bin/bench/fault_shim.so \
        "$root/shakedown" run "$scene" "${options[@]}" --out "$out/run" >"$out/said" 2>&1 || {
        code=$? # 12: the result is doubtful, as it would be without faults
        [ "$code" -eq 12 ] || { echo "bench loss: $1: exit code $code" && tail -n 20 "$out/said" && exit 1; }
    }
    end=${EPOCHREALTIME//[!0-9]/}
    now=$(attribute state_hash)
    state=${state:-$now}
    [ "$(attribute complete)" = 1 ] && [ "$now" = "$state" ] || { echo "bench loss: $1: another record" && exit 1; }
    echo "$(((end - start) / 1000)) $(attribute elapsed_s) $(attribute commands_repeated) $(attribute records_repeated)" \
        >>"$out/$1"
}

median() { # KIND COLUMN
    sort -g -k "$2,$2" "$out/$1" | awk -v column="$2" '{ v[NR] = $column } END { print v[int((NR + 1) / 2)] }'
}

for ((i = 1; i <= ${given[--n]:-3}; i++)); do
    for kind in "${kinds[@]}"; do
        [ -n "${faults[$kind]+there}" ] || bench_usage "no network $kind"
        run_once "$kind" "$i"
    done
done
printf '%-12s %8s %6s %8s %6s %10s %10s\n' network 'run s' times 'sim s' times 'commands' 'records'
for kind in "${kinds[@]}"; do
    awk -v kind="$kind" -v run="$(median "$kind" 1)" -v sim="$(median "$kind" 2)" -v run0="$(median "${kinds[0]}" 1)" \
        -v sim0="$(median "${kinds[0]}" 2)" -v commands="$(median "$kind" 3)" -v records="$(median "$kind" 4)" \
        'BEGIN { printf "%-12s %8.2f %6.2f %8.2f %6.2f %10d %10d\n", kind, run / 1000, run / run0, sim, sim / sim0, commands, records }'
done
