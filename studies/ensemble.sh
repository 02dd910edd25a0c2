#!/usr/bin/env bash
# One scene with several seeds, and the mean and spread of every parameter (docs/verification.md).
# Runs in process: the same bits as over LCM with an interval of 1.
# shellcheck source=common.sh
. "${BASH_SOURCE[0]%/*}/common.sh"

usage() {
    echo "usage: ./shakedown study ensemble [SCENE] [--seeds N] [--out DIR] [--set KEY=VALUE]..."
    echo "  defaults: scenes/biaxial.cfg, --seeds 5"
    exit "$1"
}

scene='' seeds=5 out='' options=()
while [ $# -gt 0 ]; do
    case $1 in
        --help) usage 0 ;;
        --seeds | --out | --set) [ $# -ge 2 ] || usage 2 ;;
        -*) usage 2 ;;
        *)
            [ -z "$scene" ] || usage 2
            scene=$1
            shift
            continue
            ;;
    esac
    case $1 in
        --seeds) seeds=$2 ;;
        --out) out=$2 ;;
        --set) options+=(--set "$2") ;;
    esac
    shift 2
done
scene=${scene:-$root/scenes/biaxial.cfg}
new_folder ensemble
runs=()
for ((seed = 1; seed <= seeds; seed++)); do
    run "seed$seed" "$scene" --seed "$seed" "${options[@]}"
    runs+=("$out/seed$seed")
done
finish
exec "$bin/analyzer/analyzer" --no-plots --out "$out" "${runs[@]}"
