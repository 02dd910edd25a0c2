#!/usr/bin/env bash
# The same packing stepped by LAMMPS, LIGGGHTS and us, in turn on one core, and the forces compared (docs/peers.md):
# ./shakedown bench peers [--install] [--scene A|B] [--reps N] [--out DIR] [--json FILE]
# --install gets the two from Debian's packages; --out keeps inputs, logs and the prepared samples for the next time.
set -euo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
bin=${SHAKEDOWN_BIN:-$root/build}

install='' out='' options=()
while [ $# -gt 0 ]; do
    case $1 in
        --install) install=1 ;;
        --out | --scene | --reps | --json)
            [ $# -ge 2 ] || { echo "bench peers: $1 needs a value" >&2 && exit 2; }
            if [ "$1" = --out ]; then out=$2; else options+=("$1" "$2"); fi
            shift
            ;;
        *)
            echo "bench peers: unknown option $1; see the head of $0" >&2
            exit 2
            ;;
    esac
    shift
done

missing=()
for pair in lmp:lammps liggghts:liggghts; do
    command -v "${pair%:*}" >/dev/null || missing+=("${pair#*:}")
done
if [ "${#missing[@]}" -gt 0 ] && [ -n "$install" ]; then
    as_root=()
    [ "$(id -u)" -eq 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get -qq update >&2 || true
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends \
        "${missing[@]}" >&2
elif [ "${#missing[@]}" -gt 0 ]; then
    echo "bench peers: not installed: ${missing[*]}. Nothing else needs them." >&2
    echo "bench peers: ./shakedown bench peers --install, or as root: apt-get install ${missing[*]}" >&2
    exit 1
fi

if [ -z "$out" ]; then
    out=$(mktemp -d)
    trap 'rm -rf "$out"' EXIT
fi
"$bin/bench/bench_peers" --bin "$bin" --scenes "$root/scenes" --out "$out" "${options[@]}"
