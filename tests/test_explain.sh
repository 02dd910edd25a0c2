#!/usr/bin/env bash
# What explain says of stiffness, rates and prepared stages, against numbers by hand. Usage: test_explain.sh SIM SCENES
set -euo pipefail

sim=$1 scenes=$2

says() { # SCENE TEXT
    "$sim" --explain "$scenes/$1" | grep -qF -- "$2" || { echo "$1: does not say: $2" && exit 1; }
}

# E/(2 (1 - nu^2))/p = 1e9/(2 0.96)/1e5
says own_material.cfg 'E*/p = 5.21e+03'
# as dt_s = "auto", which is what this scene takes: the number chosen and the one recommended
"$sim" --explain "$scenes/own_material.cfg" | sed -n 's/.* dt \([0-9.e-]*\) s (recommended, dt_s = "auto": \([0-9.e-]*\) s).*/\1 \2/p' |
    awk '$1 == $2 { n++ } END { exit !(n >= 1) }' || { echo 'own_material.cfg: dt_s = auto is not what is recommended' && exit 1; }
# t_c/20 = pi sqrt(m/(2 k))/20, m of the mean cube of 4 to 6 mm, k = 1e4 N/m; or what its dashpots allow, which is shorter here
says own_material.cfg 'name = "prepare-settle";'
says own_material.cfg 'cost: at most '
# k/p = 1e5/200; the largest rate pi f strain = 0.7854/s
says biaxial_friction.cfg 'k/p = 500 (below 1000: soft)'
says biaxial_friction.cfg 'largest rate here 0.785 1/s'
# k/(p d) of 1e4 N/m, 1 kPa and 10 mm within the 1 % that 343 radii scatter
kappa=$("$sim" --explain "$scenes/triaxial_compression.cfg" | sed -n 's/.*stage 2 .*k\/(p d) = \([0-9.e+]*\).*/\1/p')
awk -v k="$kappa" 'BEGIN { exit !(k > 980 && k < 1020) }' || { echo "k/(p d) = $kappa, wanted 1000" && exit 1; }
