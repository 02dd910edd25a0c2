#!/usr/bin/env bash
# ./shakedown bench peers without the peers: it says what to do and fails; it refuses what it does not know.
set -uo pipefail
script=$(readlink -f "${BASH_SOURCE[0]%/*}/../bench/peers.sh")
empty=$(mktemp -d)
trap 'rm -rf "$empty"' EXIT
for program in bash readlink; do
    ln -s "$(command -v "$program")" "$empty/$program"
done
failures=0

expect() { # CODE TEXT COMMAND...
    local code=$1 text=$2 said got
    shift 2
    said=$("$@" 2>&1)
    got=$?
    if [ "$got" -ne "$code" ] || ! grep -q -- "$text" <<<"$said"; then
        echo "$*: exit code $got instead of $code, or no \"$text\" in: $said"
        failures=$((failures + 1))
    fi
}

expect 1 'not installed: lammps liggghts' env PATH="$empty" bash "$script"
expect 1 'bench peers --install' env PATH="$empty" bash "$script" --reps 1
ln -s "$(type -P true)" "$empty/lmp"
expect 1 'not installed: liggghts' env PATH="$empty" bash "$script"
expect 2 'unknown option --nonsense' bash "$script" --nonsense
expect 2 'needs a value' bash "$script" --scene
[ "$failures" -eq 0 ]
