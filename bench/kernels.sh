#!/usr/bin/env bash
# Nanoseconds per contact or particle of every kernel, model, precision and instruction set, and its error:
# ./shakedown bench kernels [--json FILE]
set -euo pipefail
root=$(dirname "$(readlink -f "$0")")/..
exec "${SHAKEDOWN_BIN:-$root/build}/bench/bench_kernels" "$@"
