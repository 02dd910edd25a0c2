#!/usr/bin/env bash
# Time of a step with threads = 0, 1 and 2 for samples of a few sizes in 2D and 3D: whole runs of the
# discs of scene A and the spheres of scene B while walls compress them, in turns; the least of each.
# ./shakedown bench threads [--counts N,N,...] [--turns N] [--seconds S]
# --seconds: about how long a run takes.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"
read_options '' '--counts --turns --seconds' '--counts --turns --seconds' "$@"
counts=${given[--counts]:-1e3,3e3,1e4} turns=${given[--turns]:-3} seconds=${given[--seconds]:-1}

scene=$(mktemp)
trap 'rm -f "$scene"' EXIT

# The discs of scene A, or the spheres of scene B, while walls compress them.
scene_of() { # DIMENSION
    local wall
    case $1 in
        2) wall='{ mode = "stress"; pressure_pa = 500.0; mass_kg = 1e-2; damping_kg_per_s = 2.0; }'
            echo "name = \"discs\"; dimension = 2; precision = \"mixed\";
            sample = { radius_min_m = 0.5e-3; radius_max_m = 1.5e-3; density_kg_per_m3 = 2000.0; speed_m_per_s = 20.0; };
            material = { law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; kc_n_per_m = 0.0;
                gamma_n_kg_per_s = 0.02; };
            stages = ({ name = \"compress\"; dt_s = 1e-6; limits = { overlap_ratio = 1.5; }; walls = { x = $wall; z = $wall; }; });" ;;
        3) wall='{ mode = "stress"; pressure_pa = 1000.0; mass_kg = 2.0; damping_kg_per_s = 200.0; }'
            echo "name = \"spheres\"; dimension = 3; precision = \"mixed\";
            sample = { radius_min_m = 3e-3; radius_max_m = 7e-3; density_kg_per_m3 = 2000.0; speed_m_per_s = 0.1; };
            material = { kn_n_per_m = 5000.0; gamma_n_kg_per_s = 0.05; mu_s = 0.1; kt_n_per_m = 1000.0;
                gamma_t_kg_per_s = 0.01; gamma_b_kg_per_s = 0.2; gamma_br_kg_per_s = 0.05; };
            stages = ({ name = \"compress\"; dt_s = 2e-5; limits = { overlap_ratio = 1.5; }; walls = { x = $wall; y = $wall; z = $wall; }; });" ;;
    esac
}

# Microseconds per step.
step_us() { # COUNT THREADS DURATION
    local said
    said=$("$bin/sim/sim" "$scene" --in-process --progress --set "sample.count=$1" --set "threads=$2" \
        --set "stages.0.duration_s=$3" 2>&1) || { echo "$said" >&2; return 1; }
    grep -oE '[0-9.]+ us per step' <<<"$said" | cut -d' ' -f1
}

echo '| | threads = 0, us | 1 | 2 | 0 over the best of 1 and 2 |'
echo '|---|---|---|---|---|'
for dimension in 2 3; do
    case $dimension in
        2) step=1e-6 us=0.006 ;;
        3) step=2e-5 us=0.03 ;;
    esac
    scene_of "$dimension" >"$scene"
    for count in ${counts//,/ }; do
        n=$(printf '%.0f' "$count")
        duration=$(awk "BEGIN { print $step * int($seconds * 1e6 / ($us * $n)) }")
        least=()
        for ((turn = 0; turn < turns; turn++)); do
            for threads in 0 1 2; do
                us_now=$(step_us "$n" "$threads" "$duration")
                least[threads]=$(awk "BEGIN { a = ${least[threads]:-1e9}; b = $us_now; print b < a ? b : a }")
            done
        done
        awk -v n="$n" -v d="$dimension" -v a="${least[0]}" -v b="${least[1]}" -v c="${least[2]}" \
            'BEGIN { best = b < c ? b : c; printf "| %d %s | %.4g | %.4g | %.4g | %.2f |\n", n, d == 2 ? "discs" : "spheres", a, b, c, a / best }'
    done
done
