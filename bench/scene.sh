#!/usr/bin/env bash
# Microseconds per step of a scene's last stage and of each part, in double and in mixed precision:
# ./shakedown bench scene [SCENE] [--json FILE] [--out FOLDER] [--set KEY=VALUE]...
# --out keeps the prepared sample for the next time.
set -euo pipefail
root=$(dirname "$(readlink -f "$0")")/..
bin=${SHAKEDOWN_BIN:-$root/build}
case ${1:-} in
    '' | -*) set -- "$root/scenes/biaxial.cfg" "$@" ;;
esac
out=''
case " $* " in
    *' --out '*) ;;
    *)
        out=$(mktemp -d)
        trap 'rm -rf "$out"' EXIT
        set -- "$@" --out "$out"
        ;;
esac
"$bin/bench/bench_scene" "$@" --sim "$bin/sim/sim"
