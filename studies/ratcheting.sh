#!/usr/bin/env bash
# Cycles of stress on the triaxial box (scene B) at several friction coefficients, all from one compressed sample:
# first cycle, accumulation per cycle, shakedown or ratcheting (docs/studies.md).
# shellcheck source=common.sh
. "${BASH_SOURCE[0]%/*}/common.sh"

usage() {
    echo "usage: ./shakedown study ratcheting [--cycles N] [--mu LIST] [--period S] [--seed N] [--out DIR]"
    echo "  defaults: --cycles 10 --mu 0.1,0.5 --period 1 --seed 1; the paper: --cycles 100 --period 10"
    exit "$1"
}

cycles=10 mus=0.1,0.5 period=1 seed=1 out=''
while [ $# -gt 0 ]; do
    case $1 in
        --help) usage 0 ;;
        --cycles | --mu | --period | --seed | --out) [ $# -ge 2 ] || usage 2 ;;
        *) usage 2 ;;
    esac
    case $1 in
        --cycles) cycles=$2 ;;
        --mu) mus=$2 ;;
        --period) period=$2 ;;
        --seed) seed=$2 ;;
        --out) out=$2 ;;
    esac
    shift 2
done
new_folder ratcheting
scene=$root/scenes/triaxial_cyclic.cfg

# The first stage alone, up to one step of the others; it has no friction, so it is the same for every mu.
prepared=$out/prepared/checkpoint-compress.h5
if [ ! -f "$prepared" ]; then
    mkdir -p "$out/prepared" || die "cannot create $out/prepared"
    say "compressing the sample"
    "$bin/sim/sim" "$scene" --seed "$seed" --in-process --progress --checkpoint "$out/prepared/checkpoint.h5" \
        --set stages.1.duration_s=2e-5 --set stages.2.duration_s=2e-5 2>"$out/prepared/log" ||
        die "the preparation failed; see $out/prepared/log"
    [ -f "$prepared" ] || die "no checkpoint; see $out/prepared/log"
fi

duration=$(awk "BEGIN { print $cycles * $period }") || die "--cycles and --period must be numbers"
sampling=$(awk "BEGIN { print $period / 100 }")
runs=()
for mu in ${mus//,/ }; do
    run "mu$mu" "$scene" --seed "$seed" --set "material.mu_s=$mu" --set 'sample.initial="checkpoint"' \
        --set "sample.checkpoint=\"$prepared\"" --set "stages.2.walls.x.period_s=$period" \
        --set "stages.2.duration_s=$duration" --set "stages.2.sample_interval_s=$sampling" \
        --set "stages.2.frame_interval_s=$duration"
    runs+=("$out/mu$mu")
done
finish
exec "$bin/analyzer/analyzer" --no-plots --series material.mu_s --out "$out" "${runs[@]}"
