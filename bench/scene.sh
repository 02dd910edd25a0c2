#!/usr/bin/env bash
# Microseconds per step of a scene and of each part: ./shakedown bench scene [SCENE] [--json FILE] [--set KEY=VALUE]...
set -euo pipefail
root=$(dirname "$(readlink -f "$0")")/..
case ${1:-} in
    '' | -*) set -- "$root/scenes/biaxial.cfg" "$@" ;;
esac
exec "${SHAKEDOWN_BIN:-$root/build}/bench/bench_scene" "$@"
