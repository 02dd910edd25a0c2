#!/usr/bin/env bash
# Nanoseconds per contact or particle of every kernel, model, precision and instruction set, and its error:
# ./shakedown bench kernels [--json FILE]
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"
exec "$bin/bench/bench_kernels" "$@"
