#!/usr/bin/env bash
# LAMMPS 29 Sep 2021 (Debian 12): pair_style granular with hertz/material E e nu and damping tsuji takes e, by its manual
# the coefficient of restitution, and two equal spheres rebound with more than that: e = 0.5 gives 0.62, e = 0.3 gives
# 0.44. The polynomial is 0.71 of sqrt(5) beta, the factor for the reduced mass with which it is multiplied (1/sqrt(2):
# it fits the mass of one of two equal spheres).
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

printf '%s\n' impact '' '2 atoms' '1 atom types' '-1 1 xlo xhi' '-1 1 ylo yhi' '-1 1 zlo zhi' '' Atoms '' \
    '1 1 0.2 2700 -0.1 0 0' '2 1 0.2 2700 0.1 0 0' '' Velocities '' '1 0.1 0 0 0 0 0' '2 -0.1 0 0 0 0 0' >pair.data

# Velocity of departure over that of approach of two spheres of 0.1 m that touch and meet with 0.2 m/s.
rebound() { # E
    printf '%s\n' 'units si' 'boundary f f f' 'atom_style sphere' 'atom_modify map array' 'newton off' 'comm_modify vel yes' \
        'read_data pair.data' 'pair_style granular' \
        "pair_coeff * * hertz/material 1.4e11 $1 0.3 damping tsuji tangential linear_nohistory 0 0" \
        'neighbor 0.01 bin' 'fix motion all nve/sphere' 'timestep 1e-7' 'variable v equal vx[2]-vx[1]' \
        'thermo_style custom step v_v' 'thermo 12000' 'run 12000' >pair.in
    root/usr/bin/lmp -in pair.in -log none -nocite | awk '$1 == 12000 { printf "%.2f", $2 / 0.2 }'
}

report=$(for e in 0.9 0.5 0.3; do echo "e = $e asked, $(rebound $e) seen"; done)
echo "lammps $version:"
echo "$report"
[ "$report" = "e = 0.9 asked, 0.93 seen
e = 0.5 asked, 0.62 seen
e = 0.3 asked, 0.44 seen" ] && echo 'as described: contacts lose less than e asks for'
