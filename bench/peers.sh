#!/usr/bin/env bash
# The same packing stepped by LAMMPS, LIGGGHTS and us, in turn on one core, and the forces compared (docs/peers.md):
# ./shakedown bench peers [--install] [--scene A|B|C] [--reps N] [--out DIR] [--json FILE]
# ./shakedown bench peers --threads N [--count N] [--scene discs|spheres] [...]: N threads beside N ranks of LAMMPS
# --install gets the two from Debian's packages; --out keeps inputs, logs and the prepared samples for the next time.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"

# The packages of the programs that are not there.
find_missing() { # sets `missing`
    local pair
    missing=()
    for pair in lmp:lammps liggghts:liggghts; do
        command -v "${pair%:*}" >/dev/null || missing+=("${pair#*:}")
    done
}

fail() { # WHAT
    echo "bench peers: $1" >&2
    exit 1
}

by_hand() {
    echo "as root: apt-get install ${missing[*]}"
}

install_missing() {
    local as_root=()
    command -v apt-get >/dev/null || fail "no apt-get here: it needs the programs lmp and liggghts in PATH"
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || fail "no sudo; $(by_hand)"
        as_root=(sudo)
    fi
    "${as_root[@]}" apt-get -qq update >&2 || echo "bench peers: going on with the package lists at hand" >&2
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends \
        "${missing[@]}" >&2 || fail "apt-get failed; $(by_hand)"
    find_missing
    [ "${#missing[@]}" -eq 0 ] || fail "installed, and still not in PATH: ${missing[*]}"
}

read_options --install '--out --scene --reps --json --threads --count' '--install --out' "$@"
find_missing
if [ "${#missing[@]}" -gt 0 ]; then
    [ -n "${given[--install]:-}" ] || fail "not installed: ${missing[*]}. Nothing else needs them.
bench peers: ./shakedown bench peers --install, or $(by_hand)"
    install_missing
fi
take_out
"$bin/bench/bench_peers" --bin "$bin" --root "$root" --out "$out" "${options[@]}"
