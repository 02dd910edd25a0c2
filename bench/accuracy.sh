#!/usr/bin/env bash
# Error of the curve and of the energy ledger against the finest run, and what it costs, as time step, skin, exchange
# interval and precision vary (docs/accuracy.md):
# ./shakedown bench accuracy [--quick] [--scene A|A-cohesive|B|B-fresh] [--out DIR] [--json FILE] [--plot FILE.png]
#                            [--from FILE] [--through COMMAND] [--set KEY=VALUE]...
# --quick: in a minute; --out keeps the prepared samples for the next time; --through: every run is
# started by it; --from: no runs, the results in FILE (of --json) are plotted.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"

read_options --quick '--out --scene --json --plot --from --through --set' --out "$@"
take_out
"$bin/bench/bench_accuracy" --bin "$bin" --scenes "$root/scenes" --out "$out" "${options[@]}"
