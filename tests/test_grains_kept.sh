#!/usr/bin/env bash
# A run keeps the table that its grains come from: its folder can be run again, and replayed, when the original is gone.
# Usage: test_grains_kept.sh LAUNCHER SIM
set -euo pipefail

launcher=$1 sim=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/scenes" "$work/scenes/tables" "$work/run"
cat >"$work/scenes/scene.cfg" <<'TEXT'
dimension = 3;
sample = { initial = "file"; file = "tables/two.csv"; density_kg_per_m3 = 2000.0; // "tables/two.csv"
           box_min_m = [0.0, 0.0, 0.0]; box_max_m = [0.01, 0.01, 0.01]; };
material = { kn_n_per_m = 1e5; };
record = { walls = "full"; event_log = true; };
stages = ( { name = "hit"; duration_s = 2e-3; } );
TEXT
printf 'x,y,z,radius,vx\n0.003,0.005,0.005,0.001,1\n0.006,0.005,0.005,0.001,-1\n' >"$work/scenes/tables/two.csv"
printf 'x,y,z,radius,vx\n0.003,0.005,0.005,0.001,2\n0.006,0.005,0.005,0.001,-1\n' >"$work/scenes/tables/other.csv"

hash_of() { # SIM-ARGUMENT...: the hash of the state at the end
    "$sim" "$@" --in-process --progress 2>&1 | sed -n 's/.*, hash \([0-9a-f]*\)$/\1/p'
}

original=$(hash_of "$work/scenes/scene.cfg")
other=$(hash_of "$work/scenes/scene.cfg" --set sample.file=tables/other.csv)
[ -n "$original" ] && [ "$original" != "$other" ] || { echo "no two runs: $original, $other" && exit 1; }

"$launcher" --prepare "$work/scenes/scene.cfg" "$work/run"
"$launcher" --prepare "$work/scenes/scene.cfg" "$work/run" # again: the same
echo x >"$work/scenes/tables/grains.csv"
! "$launcher" --prepare "$work/scenes/scene.cfg" "$work/scenes/tables" 2>/dev/null || { echo "overwritten" && exit 1; }
[ "$(<"$work/scenes/tables/grains.csv")" = x ] || { echo "overwritten" && exit 1; }
mkdir "$work/set"
"$launcher" --prepare "$work/scenes/scene.cfg" "$work/set" --set 'sample.file="tables/other.csv"'
rm -r "$work/scenes"

cd "$work/run"
[ "$(hash_of scene.cfg --lcm file://run.lcm?mode=w --run-id 7)" = "$original" ] || { echo "another run" && exit 1; }
grep -q "file_hash = \"[0-9a-f]\{16\}\"" run.lcm || { echo "the record does not name the table" && exit 1; }
"$sim" --replay run.lcm scene.cfg --run-id 7
mapfile -t words <"$work/set/overrides"
[ "$(hash_of "$work/set/scene.cfg" "${words[@]}")" = "$other" ] || { echo "the table of --set is not kept" && exit 1; }
