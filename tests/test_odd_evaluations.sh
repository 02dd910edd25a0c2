#!/usr/bin/env bash
# Small scenes whose evaluation once said nothing, or something wrong: what each test has, with its value. A box of 125
# spheres, first under 1 kPa, then strained in z as each test wants it; and cycles at steps that no period is a multiple of.
set -uo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
box=$root/tests/verdict/box.cfg
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0

run() { # NAME SCENE ARGUMENT...
    name=$1
    "$root/shakedown" run "$2" --in-process --out "$work/$name" "${@:3}" >"$work/$name.said" 2>&1 ||
        { failures=$((failures + 1)) && echo "FAILED: $name" && cat "$work/$name.said"; }
}

# The value of QUANTITY in the last run's analysis is a number within [LOW, HIGH].
within() { # QUANTITY LOW HIGH
    local value
    value=$(sed -n "/^ *\"${1%%.*}\": {/,\$p" "$work/$name/analysis.json" |
        sed -n "/\"${1#*.}\": {/,/}/s/.*\"value\": \([0-9.e+-]*\),*\$/\1/p" | head -n 1)
    [ -n "$value" ] && awk -v x="$value" -v lo="$2" -v hi="$3" 'BEGIN { exit !(x >= lo && x <= hi) }' && return
    failures=$((failures + 1))
    echo "FAILED: $name: $1 is '$value', not within $2 and $3"
}

says() { # TEXT
    grep -q "$1" "$work/$name.said" && return
    failures=$((failures + 1))
    echo "FAILED: $name does not say '$1'" && cat "$work/$name.said"
}

says_not() { # TEXT
    ! grep -q "$1" "$work/$name.said" && return
    failures=$((failures + 1))
    echo "FAILED: $name says '$1'"
}

# A result that is doubtful is there, says so, and why; and so does the exit code.
name=doubtful
"$root/shakedown" run "$root/tests/verdict/damped-biaxial.cfg" --in-process --out "$work/$name" --set stages.0.dt_s=3e-6 \
    --set stages.1.dt_s=3e-6 --set limits.overlap_ratio=1.0 >"$work/$name.said" 2>&1
[ $? -eq 12 ] && grep -q '"verdict": "doubtful"' "$work/$name/analysis.json" || { failures=$((failures + 1)) && echo 'FAILED: doubtful'; }
says 'verdict: doubtful'
says "results: $work/$name"
says_not 'evaluation failed'

# Lateral walls rest: a test with K0 and Cc, without a dilatancy angle. K0 is between that of a gas (1) and of no
# lateral stress, Cc that of a compression (above 0).
run oedometer "$box" --set stages.1.walls.x.mode=fixed --set stages.1.walls.y.mode=fixed --set stages.1.walls.z.strain=0.02
says 'stage "test" (2 of 2): oedometer'
within oedometer.K0_loading 0.3 1
within compression.Cc 0.01 1
within oedometer.M_loading_pa 1e4 1e6
says_not dilatancy_angle

# The volume is kept by the walls, and drawn: gnuplot has nothing to say to a line without a range.
run volume "$box" --set 'stages.1.walls.x.mode="coupled"' --set 'stages.1.walls.y.mode="coupled"'
says 'at constant volume'
says_not Warning

# The axial stress is the small one: the stress ratio that counts is lateral over axial, above 1 and within what grains
# of mu = 0.4 reach; q is negative.
run extension "$box" --set stages.1.walls.z.strain=-0.05
says 'drained triaxial extension'
within E_initial_pa 1e4 1e7
within peak.stress_ratio 1.5 5
within peak.friction_angle_deg 10 45
within critical.q_over_p -1.5 -0.1

# Strains of 5 % in z and 1 - 1/sqrt(0.95) in x and y, on one course: V is that of the start at both ends, and half way
# (1 - 0.025) (1 + 0.012989176)^2 = 1 + 4.934e-4.
run constant-volume "$box" --set stages.1.walls.z.strain=0.05 --set stages.1.walls.x.strain=-0.025978352 \
    --set stages.1.walls.y.strain=-0.025978352 --set stages.1.walls.x.mode=strain --set stages.1.walls.y.mode=strain \
    --set stages.1.walls.x.frequency_hz=2.0 --set stages.1.walls.y.frequency_hz=2.0
within undrained.volume_change_max 4.92e-4 4.94e-4
within undrained.p0_pa 900 1100
says 'the volume is kept'

# 8 cycles of 0.2 s at steps of 30 and 70 us: the last is not lost to rounding.
for step in 3e-5 7e-5; do
    run "cycles-$step" "$root/scenes/triaxial_quick.cfg" --set stages.0.dt_s=$step --set stages.1.dt_s=$step \
        --set stages.2.dt_s=$step
    says '8 cycles'
    says 'verdict: sound'
done
[ "$failures" -eq 0 ] || { echo "$failures failures" && exit 1; }
