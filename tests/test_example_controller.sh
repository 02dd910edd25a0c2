#!/usr/bin/env bash
# The controller of examples/ runs in place of wallctl: 2000 steps, all recorded. Usage: test_example_controller.sh PROGRAM
set -uo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$root/shakedown" run "$root/scenes/quick.cfg" --out "$work/run" --controller "$1" >"$work/said" 2>&1
# The analyzer may think of such a run what it likes; the record must be whole, and as long as the controller said.
h5dump -y -a /complete "$work/run/run.h5" >"$work/complete"
h5dump -y -w 0 -d /samples/stage/step "$work/run/run.h5" >"$work/steps"
h5dump -a /parameters/controller "$work/run/run.h5" | grep -qF "$1" || { echo "run.h5 does not name $1" && exit 1; }
grep -qF "a controller of the user's own set the targets, not the scene: $1" "$work/run/analysis.json" ||
    { echo "the analyzer does not say whose targets they were" && exit 1; }
# z moves, x rests: not what the scene's first stage is
"$root/shakedown" analyze --stage ring --no-plots "$work/run" 2>&1 | grep -qF 'stage "ring" (1 of 3): oedometer' ||
    { echo "the analyzer did not see what the walls did" && exit 1; }
grep -qE '^ +1$' "$work/complete" && grep -qE '\b2000$' "$work/steps" && exit 0
cat "$work/complete" "$work/said"
tail -n 5 "$work/steps"
exit 1
