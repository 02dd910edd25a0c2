#!/usr/bin/env bash
# Strength of a lattice against its closed form. Equal spheres, face-centred cubic, compressed along a cube axis (z), walls
# along its (110) planes. While it fails, grains of a layer of (001) come apart, and each is held by its four neighbours in the
# layers above and below, at 45 degrees, where it slides: with the normal force N and the friction T = mu N of such a contact
# f_z = (N + T)/sqrt 2, and of its horizontal component (N - T)/sqrt 2 half the square counts in x: f_x = (N - T)/2. A layer of
# area A = c d^2 has c grains and 4 c contacts with the next, d/sqrt 2 away: sigma_z = 4 f_z/d^2, sigma_x = 4 f_x/(sqrt 2 d^2), so
#     sigma_z/sigma_x = 2 (1 + mu)/(1 - mu)                           (Thornton 1979, Geotechnique 29, 441)
# The layers are of n x n grains and, at both ends and between, of (n - 1) x (n - 1): so no grain at an edge is held by one side
# only, and the same forces are an equilibrium of the finite box. Its walls lie a radius outside of the centres: with m large
# layers the stresses on the box are in a ratio that is smaller by f = (sqrt 2 m/(n - 1))/((sqrt 2 m + 1)/n), 1.0013 for n = 8, m = 5.
# Asked: within 0.5 % (the measured ratio times f). What is left: waves add 0.4 % at mu = 0.1 (0.1 % at five eighths of the rate),
# and at mu = 0.5 grains that begin to roll take 0.4 % before all contacts slide. The rate of the scene, 4e-3 1/s, was chosen so that
# both stay below 0.5 %: at 2.5e-3 1/s it is +0.14, -0.06 and -0.58 %, at 1e-2 1/s +1.07 % at mu = 0.1.
set -uo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
n=8 m=5

cp "$root/tests/scenes/fcc.cfg" "$work/fcc.cfg"
awk -v n="$n" -v m="$m" -v d=2e-3 'BEGIN {
    print "x,y,z,radius"
    for (k = 0; k <= 2 * m; k++) {
        small = k % 2 == 0
        for (i = 0; i < n - small; i++)
            for (j = 0; j < n - small; j++)
                printf "%.17g,%.17g,%.17g,%.17g\n", (i + small / 2) * d, (j + small / 2) * d, k * d / sqrt(2), d / 2
    }
}' >"$work/fcc.csv"

failed=0
for mu in 0.1 0.3 0.5; do
    "$root/shakedown" run "$work/fcc.cfg" --in-process --set "material.mu_s=$mu" --out "$work/$mu" >"$work/said" 2>&1 ||
        { cat "$work/said" && exit 1; }
    awk -F, -v mu="$mu" -v n="$n" -v m="$m" '
        NR == 1 { for (k = 1; k <= NF; k++) if ($k == "stress_ratio") c = k; next }
        $c > top { top = $c }
        END {
            h = sqrt(2) * m; got = top * (h / (n - 1)) / ((h + 1) / n); right = 2 * (1 + mu) / (1 - mu)
            printf "mu %g: %.4f, closed form %.4f: %+.2f %%\n", mu, got, right, 100 * (got / right - 1)
            exit !(got > 0.995 * right && got < 1.005 * right)
        }' "$work/$mu/curves.csv" || failed=1
done
exit "$failed"
