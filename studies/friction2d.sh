#!/usr/bin/env bash
# Macroscopic friction against the contacts' mu in the biaxial box, at the peak and in the critical state, for a dense
# and a loose preparation (docs/studies.md).
# shellcheck source=common.sh
. "${BASH_SOURCE[0]%/*}/common.sh"

usage() {
    echo "usage: ./shakedown study friction2d [--mu LIST] [--seed N] [--out DIR]"
    echo "  defaults: --mu 0,0.1,0.2,0.4,1 --seed 1"
    exit "$1"
}

mus=0,0.1,0.2,0.4,1 seed=1 out=''
while [ $# -gt 0 ]; do
    case $1 in
        --help) usage 0 ;;
        --mu | --seed | --out) [ $# -ge 2 ] || usage 2 ;;
        *) usage 2 ;;
    esac
    case $1 in
        --mu) mus=$2 ;;
        --seed) seed=$2 ;;
        --out) out=$2 ;;
    esac
    shift 2
done
new_folder friction2d
scene=$root/scenes/biaxial_friction.cfg

runs=()
for mu in ${mus//,/ }; do
    run "dense-mu$mu" "$scene" --seed "$seed" --set 'name="dense"' --set "material.mu_s=$mu"
    run "loose-mu$mu" "$scene" --seed "$seed" --set 'name="loose"' --set "material.mu_s=$mu" \
        --set "stages.0.material.mu_s=$mu" --set stages.0.material.gamma_b_kg_per_s=0.01
    runs+=("$out/dense-mu$mu" "$out/loose-mu$mu")
done
finish
exec "$bin/analyzer/analyzer" --no-plots --series material.mu_s --out "$out" "${runs[@]}"
