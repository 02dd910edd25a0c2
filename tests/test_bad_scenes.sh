#!/usr/bin/env bash
# Broken scene files: each must be refused with the text that its first line expects ("@" stands for the file's name),
# and exit code 3. Usage: test_bad_scenes.sh SIM FOLDER GOOD_SCENE
set -uo pipefail

sim=$1 folder=$2 good=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0 cases=0

expect() { # CODE TEXT ARGUMENT...
    local code=$1 text=$2 said got
    shift 2
    said=$("$sim" --check "$@" 2>&1)
    got=$?
    cases=$((cases + 1))
    [ "$got" -eq "$code" ] && [[ $said == *"$text"* ]] && return
    failures=$((failures + 1))
    printf 'FAILED: sim --check %s\n  exit code %s, wanted %s\n  said   %s\n  wanted %s\n' "$*" "$got" "$code" "$said" "$text"
}

for scene in "$folder"/*.cfg; do
    read -r first <"$scene"
    text=${first#// expect: }
    expect 3 "${text//@/$scene}" "$scene"
done

printf 'dimension = 2;\0\1\2' >"$work/binary.cfg"
expect 3 "$work/binary.cfg: not a text file" "$work/binary.cfg"
{ cat "$good" && yes '// much more' | head -n 3000; } >"$work/big.cfg"
expect 3 "$work/big.cfg: larger than 24576 bytes" "$work/big.cfg"
: >"$work/empty.cfg"
expect 3 "$work/empty.cfg:" "$work/empty.cfg"
expect 5 "$work/missing.cfg: No such file or directory" "$work/missing.cfg"
expect 5 "$work: " "$work"
sed '/speed_m_per_s/d; s/count = 60;/initial = "file"; file = "grains.csv";/' "$good" >"$work/no_grains.cfg"
expect 5 "$work/grains.csv: No such file or directory" "$work/no_grains.cfg"

expect 0 '' "$good"
expect 0 '' "$good" --set stages.1.dt_s=2e-6 --set 'stages.1.frame_strains=[0.0, 0.005]' --set material.law=hysteretic
expect 3 '--set: material.stiffness: unknown key; allowed here: law' "$good" --set material.stiffness=1e5
expect 3 "there is no 'stages.7' in the scene" "$good" --set stages.7.dt_s=1e-6
expect 3 '--set: seed: must be an integer' "$good" --set seed=many
expect 0 '' "$good" --set seed=3000000000
expect 3 '--set: seed: 9.1e+15 is out of range; allowed: 0 to 9e+15' "$good" --set seed=9100000000000000
expect 3 '--set: 1e999 is too large for a number' "$good" --set material.gamma_n_kg_per_s=1e999
expect 3 '--set: -9223372036854775809 is too large for an integer' "$good" --set seed=-9223372036854775809
expect 0 '' "$good" --set 'stages.1.frame_strains=[0, 0.005]'
expect 0 '' "$good" --seed 3000000000
expect 2 "'}' is not a value in libconfig syntax" "$good" --set 'material.mu_s=}'
expect 3 '--set: 1e is not a number' "$good" --set 'material.mu_s=1e'
expect 2 "'2; dimension = 3' is not a value in libconfig syntax" "$good" --set 'seed=2; dimension = 3'
expect 3 "the list has no member '2' of this kind" "$good" --set stages.1.frame_strains.2=0.02
expect 3 "the list has no member '0' of this kind" "$good" --set stages.1.frame_strains.0=first
expect 0 '' "$good" --set stages.1.frame_strains.0=0.005
expect 2 '--set wants path=value, not "material.mu_s"' "$good" --set material.mu_s
expect 2 'exactly one scene file is needed' "$good" "$good"

[ "$cases" -ge 60 ] || { echo "only $cases cases: is $folder right?" && exit 1; }
[ "$failures" -eq 0 ] || { echo "$failures of $cases cases failed" && exit 1; }
echo "$cases cases"
