#!/usr/bin/env bash
# The shipped scenes: what each is to keep and how well it does, inertial number, time, verdict (docs/control.md):
# ./shakedown bench element-tests [--quick] [--bus] [--exact] [--out DIR] [--seed N] [--set KEY=VALUE]... [SCENE]...
# --quick: short forms of the tests; --bus: through sim, wallctl and recorder instead of in one process; --exact: short
# forms of few grains both ways, at an exchange in every step, and whether they come to the same bits. Exit code 1 if a scene does not keep to a bound.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"

names=()
arguments=()
while [ $# -gt 0 ]; do
    case $1 in
        --out | --seed | --set) arguments+=("$1" "${@:2:1}") && shift $(($# > 1 ? 2 : 1)) ;;
        -*) arguments+=("$1") && shift ;;
        *) names+=("$1") && shift ;;
    esac
done
read_options '--quick --bus --exact' '--out --seed --set' --out "${arguments[@]}"
take_out
"$root/tests/in_namespace.sh" "$bin/bench/bench_element_tests" --bin "$bin" --scenes "$root/scenes" --out "$out" \
    "${options[@]}" "${names[@]}"
