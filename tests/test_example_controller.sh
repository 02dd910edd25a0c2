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
grep -qE '^ +1$' "$work/complete" && grep -qE '\b2000$' "$work/steps" && exit 0
cat "$work/complete" "$work/said"
tail -n 5 "$work/steps"
exit 1
