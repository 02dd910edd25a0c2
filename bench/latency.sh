#!/usr/bin/env bash
# Where an exchange over the bus spends its time: ./shakedown bench latency [--json FILE] [--rounds N]
# In a network namespace of its own.
set -euo pipefail
root=$(dirname "$(readlink -f "$0")")/..
exec "$root/tests/in_namespace.sh" "${SHAKEDOWN_BIN:-$root/build}/bench/bench_latency" "$@"
