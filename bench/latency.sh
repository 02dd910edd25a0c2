#!/usr/bin/env bash
# Where an exchange over the bus spends its time: ./shakedown bench latency [--json FILE] [--rounds N]
# In a network namespace of its own.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"
exec "$root/tests/in_namespace.sh" "$bin/bench/bench_latency" "$@"
