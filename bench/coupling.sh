#!/usr/bin/env bash
# Error against cost of the coupling schemes through the whole pipeline, beside the exact loop in one process, and what
# they do in hard cases (docs/coupling.md):
# ./shakedown bench coupling [--quick] [--shipped] [--scene a|a-cohesion|b|hard|FILE] [--out DIR] [--json FILE] [--plot FILE.png]
#                            [--scheme NAME] [--lock FILE:...] [--set KEY=VALUE]...
# In a network namespace of its own. --quick: in two minutes; --shipped: the last stage of the shipped scenes (or --scene
# NAME), 50 000 steps of it, as each is coupled and by impedance; --out keeps the prepared samples for the next time;
# --lock: holds these files' locks (as flock) while it takes times.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"

read_options '--quick --shipped' '--out --scene --json --plot --scheme --lock --set' --out "$@"
take_out
"$root/tests/in_namespace.sh" "$bin/bench/bench_coupling" --bin "$bin" --scenes "$root/scenes" --out "$out" \
    "${options[@]}"
