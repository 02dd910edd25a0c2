#!/usr/bin/env bash
# The eight impact tests of Chung & Ooi (2011) beside closed forms, and beside LAMMPS where it is installed
# (docs/benchmarks.md): ./shakedown bench impacts [--no-lammps] [--tangential STYLE] [--out DIR] [--set KEY=VALUE]
# [--coarser FACTOR]: of the time step.
# Exit code 11 if a value is not what it should be. --out keeps what LAMMPS was told and said.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"
read_options "--no-lammps" "--out --set --tangential --coarser" "--no-lammps --out" "$@"
take_out
if [ -z "${given[--no-lammps]:-}" ] && command -v lmp >/dev/null; then
    options+=(--lammps)
else
    echo "without LAMMPS (the program lmp)"
fi
"$bin/bench/bench_impacts" --scenes "$root/scenes/benchmarks" --out "$out" "${options[@]}"
