#!/usr/bin/env bash
# Scenes that look sound and are not: each ends with the exit code and the words that are right for it.
# Usage: test_verdict.sh SIM FOLDER
set -uo pipefail

sim=$1 folder=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0 cases=0

fail() {
    failures=$((failures + 1))
    printf 'FAILED: %s\n%s\n' "$1" "$said"
}

# Runs a scene; its exit code is CODE, and it says all that stands in `texts`.
texts=()
run() { # NAME CODE SCENE ARGUMENT...
    local name=$1 code=$2 scene=$3 got text
    shift 3
    said=$("$sim" "$folder/$scene.cfg" --in-process --progress "$@" 2>&1)
    got=$?
    cases=$((cases + 1))
    [ "$got" -eq "$code" ] || fail "$name: exit code $got, wanted $code"
    for text in "${texts[@]}"; do
        [[ $said == *"$text"* ]] || fail "$name: does not say '$text'"
    done
}

# The number behind the last WORDS in what was said, within [LOW, HIGH].
number_within() { # WORDS LOW HIGH
    local found
    found=$(sed -n "s/.*$1 \(-\{0,1\}[0-9.e+-]*[0-9]\).*/\1/p" <<<"$said" | tail -n 1)
    [ -n "$found" ] && awk -v x="$found" -v lo="$2" -v hi="$3" 'BEGIN { exit !(x >= lo && x <= hi) }' ||
        fail "'$1 $found' is not within $2 and $3"
}

# m = 1.07e-6 kg for the lightest of 200 (radius 0.503 mm), 1.05e-5 kg the mean, radii 0.503 and 1 mm, k = 1e5 N/m,
# gamma = 0.1 kg/s: 1.5 (1/m + 1/<m>) = 1.55e6 /kg, so omega^2 = 1.55e11 /s^2, lambda = 1.55e5 /s, and
# 2/(lambda + sqrt(lambda^2 + omega^2)) = 3.5e-6 s.
coarse=(--set stages.0.dt_s=4e-6 --set stages.1.dt_s=4e-6)
texts=('dt_s = 4e-06 s is too long for the normal contacts of the smallest particles' 'stage "confine"')
run coarse 3 damped-biaxial "${coarse[@]}"
number_within 'bear up to' 3.4e-6 3.6e-6
run 'coarse check' 3 damped-biaxial "${coarse[@]}" --check
texts=('dt_s = 0.01 s is too long')
run 'ten milliseconds' 3 damped-biaxial --set stages.0.dt_s=0.01 --check
# gamma/m of the smallest is 4.6e6 /s: the dashpot decides, about m/gamma = 2.2e-7 s.
texts=('stage "iso"')
run polydisperse 3 very-polydisperse
number_within 'bear up to' 2.1e-7 2.3e-7
texts=()
run 'polydisperse at what it needs' 0 very-polydisperse --set stages.0.dt_s=2e-7 --set stages.0.duration_s=4e-4
number_within 'ledger residual' -1e-3 1e-3

texts=('the energy ledger does not close: residual' 'verdict: doubtful')
run 'open ledger' 12 damped-biaxial --set limits.overlap_ratio=1.0 --set stages.0.dt_s=3e-6 --set stages.1.dt_s=3e-6
texts=('the energy ledger does not close: residual' 'verdict: doubtful' 'test: ended')
run 'open ledger of a short stage' 12 damped-biaxial --set limits.overlap_ratio=1.0 --set stages.0.dt_s=2e-6 --set stages.1.dt_s=3e-6 \
    --set stages.1.duration_s=3e-4 --set stages.1.cut_path=true
# One step, in which walls do work against each other: 3e-10 J are two thirds of what passed and 3e-7 of what is held.
texts=('verdict: sound')
run 'hardly anything passes' 0 hardly-anything-passes
number_within 'ledger residual' -1 -0.1
number_within 'passed,' -1e-6 1e-6
texts=('verdict: sound' 'ended by its length')
run sound 0 damped-biaxial
number_within 'ledger residual' -1e-2 1e-2

# 15 contacts of 0.1 kg/s on 1e-6 kg: 4 lambda dt = 6 > 4. The loop is exact in every step, and no residual says so.
light=(--set stages.1.walls.x.mass_kg=1e-6 --set stages.1.walls.x.damping_kg_per_s=0.01)
texts=('too long for the wall in x once a whole layer' 'wall in x is not stable' 'turns round in every step' 'walls.x.mass_kg')
run 'light wall' 10 damped-biaxial "${light[@]}" --set coupling.scheme=hold --set coupling.interval_steps=1
run 'light wall, sim closes the loop' 10 damped-biaxial "${light[@]}" --set coupling.scheme=impedance --set coupling.interval_steps=64
texts=('verdict: sound')
run 'a wall that is heavy enough' 0 damped-biaxial "${light[@]}" --set stages.1.walls.x.mass_kg=3e-6 --set coupling.scheme=hold \
    --set coupling.interval_steps=1

texts=('of the smaller radius: the contacts are too soft' 'limits.overlap_ratio')
run crushed 10 damped-biaxial --set stages.1.walls.z.strain=0.95
number_within 'overlap by' 30 60
run soft 10 damped-biaxial --set material.k1_n_per_m=1.0 --set material.k2_n_per_m=1.0 --set material.kc_n_per_m=1.0 \
    --set material.kt_n_per_m=1.0
run 'too soft' 10 too-soft
p=1e5
run 'too soft at 1e5' 10 too-soft --set walls.x.pressure_pa=$p --set walls.y.pressure_pa=$p --set walls.z.pressure_pa=$p
texts=()
run 'soft but allowed' 0 damped-biaxial --set limits.overlap_ratio=2.0 --set stages.1.walls.z.strain=0.1

# The box is known when the test begins: 0.95 of it away leaves no room, and nothing gives way.
texts=('stage "test": walls.z.strain = 0.95 would make the box smaller than the particles bear' 'damped-biaxial.cfg:')
run 'no room' 3 damped-biaxial --set stages.1.walls.x.mode=fixed --set stages.1.walls.z.strain=0.95
texts=('stage "confine": walls.z.strain = 0.95 would make')
run 'no room, check' 3 damped-biaxial --set stages.0.walls.x.mode=fixed --set stages.0.walls.z.mode=strain \
    --set stages.0.walls.z.strain=0.95 --set stages.0.walls.z.frequency_hz=50.0 --check
texts=('stage "test": walls.z: the path takes 0.05 s, but the stage ends at duration_s = 0.01')
run 'half a path' 3 damped-biaxial --set stages.1.walls.z.frequency_hz=10.0
texts=()
run 'half a path, wanted' 0 damped-biaxial --set stages.1.walls.z.frequency_hz=10.0 --set stages.1.cut_path=true

# What is recorded, and how long a stage may last, changes neither the end of a stage nor a bit of the state.
texts=('confine: ended by rest after 0.0028')
first=''
for how in duration_s=2e-2 duration_s=8e-2 duration_s=1.0 sample_interval_s=1e-5 sample_interval_s=1e-3; do
    run "rest, $how" 0 damped-biaxial --set stages.0.until_energy_ratio=1e-2 --set "stages.0.$how" \
        --lcm "file://$work/$how.lcm?mode=w"
    hash=$(sed -n 's/.* hash //p' <<<"$said")
    [[ ${#hash} -eq 16 && ($hash == "${first:-$hash}") ]] || fail "rest, $how: another end, $hash"
    first=$hash
done

# 1.07e-6 kg at 300 m/s against its like: 2 v sqrt(m/2k)/a = 2.8 radii.
texts=('particles so fast that a contact would overlap by' 'verdict: doubtful')
run fast 12 free-flight --set sample.speed_m_per_s=1000.0 --set stages.0.duration_s=2e-5
# 200 of them with 1/2.8 as much, whose contacts are over in 20 steps: the overlap is seen all the same; and where it is
# allowed they go through each other.
dense=(--set sample.count=200 --set sample.gap_ratio=0.2 --set stages.0.duration_s=2e-4)
texts=('of the smaller radius: the contacts are too soft')
run 'fast ones of many' 10 free-flight "${dense[@]}" --set sample.speed_m_per_s=100.0
texts=('passed through each other' 'verdict: doubtful')
run 'through each other' 12 free-flight "${dense[@]}" --set stages.0.duration_s=1e-5 --set sample.speed_m_per_s=250.0 --set limits.overlap_ratio=2.0
texts=('the walls in z touch nothing any more')
texts+=('the sample has come apart: its contacts hold')
run 'led away' 0 pulled-apart --set stages.1.walls.x.mode=strain --set stages.1.walls.x.strain=-0.3 \
    --set stages.1.walls.x.frequency_hz=20.0 --set stages.1.walls.z.mode=strain --set stages.1.walls.z.strain=-0.3 \
    --set stages.1.walls.z.frequency_hz=20.0

texts=('the walls in x pull (pressure_pa is negative)')
run 'pulled apart' 10 pulled-apart
number_within 'the box is' 1 2.1
texts=('until_stress_error is a fraction of the target, which is 0 in walls.x')
run 'zero target' 3 zero-target
texts=('unload: ended by its limit in time, with no condition met')
run 'limit in time' 0 zero-target --set stages.1.walls.x.pressure_pa=400.0 --set stages.1.until_energy_ratio=1e-40

texts=('test: starts NOT at rest')
run 'not at rest' 0 not-at-rest
number_within 'unbalanced force' 0.1 1
number_within 'E_kin\/E_el' 0.1 2
texts=()
run 'friction switched on' 0 friction-switched-on
number_within 'ledger residual' -1e-2 1e-2
run 'friction switched on, damped' 0 friction-switched-on --set stages.1.material.gamma_t_kg_per_s=0.02
number_within 'ledger residual' -1e-2 1e-2

texts=('precision "mixed" holds steps of at most the skin of the lists' 'neighbor.skin_ratio')
run skin 11 damped-biaxial --set precision=mixed --set neighbor.skin_ratio=1e-9
run 'free flight' 11 free-flight --set precision=mixed --set neighbor.skin_ratio=1e-4
texts=('verdict: sound')
run 'free flight, tuned' 0 free-flight --set precision=mixed
texts=('gaussian radii: only 0 of them lie between')
run 'one size' 3 gaussian-of-one-size

# A grid as fine as the particles would have 1e13 cells.
(ulimit -v 1500000 && exec "$sim" "$folder/free-flight.cfg" --check --set sample.count=20 --set sample.initial=random \
    --set sample.solid_fraction=1e-6 --set dimension=3 --set sample.radius_min_m=1e-5 --set stages.0.dt_s=1e-8) ||
    { said='' && fail 'sparse: more memory than 1.5 GB, or refused'; }

# The state in which a run stopped is kept beside its checkpoints.
said=$("$sim" "$folder/pulled-apart.cfg" --in-process --checkpoint "$work/checkpoint.h5" --lcm "file://$work/run.lcm?mode=w" \
    --run-id 1 2>&1)
[ -s "$work/checkpoint-failed.h5" ] || fail 'no checkpoint-failed.h5'

echo "$cases cases, $failures failures"
[ "$failures" -eq 0 ]
