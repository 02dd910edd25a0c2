#!/usr/bin/env bash
# Microseconds per step of a scene's last stage and of each part, in double and in mixed precision:
# ./shakedown bench scene [SCENE] [--json FILE] [--out FOLDER] [--set KEY=VALUE]...
# --out keeps the prepared sample for the next time.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"

scene=$root/scenes/biaxial.cfg
case ${1:-} in
    '' | -*) ;;
    *)
        scene=$1
        shift
        ;;
esac
read_options '' '--out --json --set' --out "$@"
take_out
"$bin/bench/bench_scene" "$scene" --out "$out" "${options[@]}" --sim "$bin/sim/sim"
