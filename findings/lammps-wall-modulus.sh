#!/usr/bin/env bash
# LAMMPS 29 Sep 2021 (Debian 12): fix wall/gran with the Hertz law by material constants, granular hertz/material E e nu,
# takes E/(2 (1 - nu)) for the effective modulus of sphere and wall, not E/(2 (1 - nu^2)), which the pair style takes for
# two spheres of the same material. A sphere that falls on a wall is (1 + nu) times too stiff: with nu = 0.3 its contact
# lasts 0.9004 of Hertz's time.
# Needs: apt-get (to download, nothing is installed), dpkg-deb; libraries of MPI and others that lammps depends on.
# Fails if what it sees changes.
set -euo pipefail
version='20220106.git7586adbb6a+ds1-2+b2'
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get -qq download "lammps=$version" "liblammps0=$version" 2>/dev/null
for package in *.deb; do dpkg-deb -x "$package" root; done
LD_LIBRARY_PATH=$(dirname "$(find "$folder/root" -name 'liblammps.so.0')")
export LD_LIBRARY_PATH OMP_NUM_THREADS=1

# Hertz: t_c = 2.8683 (m^2/(R E*^2 V))^(1/5), with E* = E/(2 (1 - nu^2)) for one material: for a sphere of 0.1 m and a
# wall at V = 0.2 m/s, and for two of these spheres (m/2, R/2) at the same V.
law='hertz/material 1.4e11 0 0.3 damping velocity tangential linear_nohistory 0 0'

contact_time() { # NAME DATA-LINES COMMANDS: of atom 1, by the steps in which it feels a force
    printf '%s\n' "impact" "" "$2" >"$1.data"
    printf '%s\n' 'units si' 'boundary f f f' 'atom_style sphere' 'atom_modify map array' 'newton off' 'comm_modify mode single vel yes' \
        "read_data $1.data" 'pair_style granular' "pair_coeff * * $law" 'neighbor 0.01 bin' "$3" \
        'fix motion all nve/sphere' 'timestep 1e-7' 'variable f equal abs(fx[1])+abs(fz[1])' \
        'variable touches equal v_f>0' 'fix sum all ave/time 1 1 1 v_touches mode scalar file '"$1.touches" \
        'thermo 100000' 'run 12000' >"$1.in"
    root/usr/bin/lmp -in "$1.in" -log none -nocite >"$1.log"
    awk '!/^#/ { n += $2 } END { printf "%.6e", n * 1e-7 }' "$1.touches"
}

box=$'-1 1 xlo xhi\n-1 1 ylo yhi\n0 2 zlo zhi'
one=$(contact_time wall "1 atoms"$'\n'"1 atom types"$'\n'"$box"$'\n\nAtoms\n\n1 1 0.2 2700 0 0 0.1\n\nVelocities\n\n1 0 0 -0.2 0 0 0' \
    "fix floor all wall/gran granular $law zplane 0 NULL")
two=$(contact_time pair "2 atoms"$'\n'"1 atom types"$'\n'"$box"$'\n\nAtoms\n\n1 1 0.2 2700 -0.1 0 1\n2 1 0.2 2700 0.1 0 1\n\nVelocities\n\n1 0.1 0 0 0 0 0\n2 -0.1 0 0 0 0 0' '')

report=$(awk -v one="$one" -v two="$two" 'BEGIN {
    pi = atan2(0, -1); e = 1.4e11 / (2 * (1 - 0.09)); m = 2700 * 4 / 3 * pi * 0.001
    wall = 2.8683 * (m^2 / (0.1 * e^2 * 0.2))^0.2; pair = 2.8683 * (m^2 / 4 / (0.05 * e^2 * 0.2))^0.2
    printf "contact time over that of Hertz: two spheres %.3f, sphere and wall %.3f; (1 + nu)^(-2/5) = %.3f\n",
        two / pair, one / wall, 1.3^-0.4 }')
echo "lammps $version: $report"
[ "$report" = "contact time over that of Hertz: two spheres 1.000, sphere and wall 0.900; (1 + nu)^(-2/5) = 0.900" ] &&
    echo "as described: walls are stiffer by 1 + nu"
