#!/usr/bin/env bash
# test_export.sh SIM RECORDER EXPORT SCENE: particles and contacts of a run as tables, VTK files and LAMMPS dumps, read
# by programs that are not ours. One that is not installed is skipped, and says so. All must find the same: frames,
# particles and contacts of the last frame, the sum of the forces' amounts in it, the highest centre.
set -uo pipefail
sim=$1 recorder=$2 export=$3 scene=$4
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1

fail() {
    echo "FAILED: $*"
    cat said.txt
    exit 1
}

expect() { # STATUS TEXT COMMAND...: ends with that, and says so
    local status=$1 text=$2 ended
    shift 2
    "$@" >said.txt 2>&1
    ended=$?
    [ "$ended" -eq "$status" ] || fail "$* ends with $ended, not $status"
    grep -qF -- "$text" said.txt || fail "$* does not say $text"
}

# Debian's modules are with Debian's Python, whatever else comes first on the path.
python_with() { # MODULE
    local python
    for python in python3 /usr/bin/python3; do
        "$python" -c "import $1" >/dev/null 2>&1 && echo "$python" && return
    done
}

agree() { # READER: what it said of the export against what the tables say
    grep '^found ' said.txt >found.txt || fail "$1 finds nothing"
    diff found.txt expected.txt >said.txt || fail "$1 finds something else than the tables"
    echo "$1: reads the same"
}

"$sim" "$scene" --in-process --lcm "file://$folder/run.lcm?mode=w" >said.txt 2>&1 || fail "sim"
"$recorder" --from run.lcm --out . >said.txt 2>&1 || fail "recorder"

expect 2 'which format' "$export" .
expect 2 'one format at a time' "$export" . --csv --vtk
expect 2 '-o wants a folder' "$export" . --csv -o
expect 5 'No such file' "$export" nowhere --csv
expect 0 'frames of 216 particles' "$export" . --csv
expect 5 'nothing is written over' "$export" . --csv
expect 0 'frames of 216 particles' "$export" . --vtk -o "odd  'folder'"
expect 0 'frames of 216 particles' "$export" . --vtk
expect 0 'frames of 216 particles' "$export" . --lammps-dump

# The tables: the last frame, with awk. The names of the columns say where what stands.
summary='
    function place(name, k) { for (k = 1; k <= NF; k++) if ($k == name) return k; print "no column " name; exit 1 }
    FNR == 1 { file++; if (file == 1 && place("box_lo_z_m") != 7) exit 1; if (file == 2) z = place("position_z_m")
        if (file == 3) { x = place("force_x_n"); y = place("force_y_n"); w = place("force_z_n"); j = place("pair_j")
            sx = place("history_spring_x_m"); sy = place("history_spring_y_m"); sz = place("history_spring_z_m") } next }
    file == 1 { last = $1; frames++; lo = $7 }
    file == 2 && $1 == last { particles++; if ($z > top) top = $z }
    file == 3 && $1 == last { contacts++; walls += $j < 0; sum += sqrt($x ^ 2 + $y ^ 2 + $w ^ 2)
        springs += sqrt($sx ^ 2 + $sy ^ 2 + $sz ^ 2) }
    END { printf "found particles %d contacts %d force %.9e springs %.9e top %.6e\n", particles, contacts, sum, springs, top
          printf "found particles %d top %.4e\n", particles, top - lo >"shifted.txt"; print walls >"walls.txt" }'
LC_ALL=C awk -F, "$summary" csv/frames.csv csv/particles.csv csv/contacts.csv >expected.txt || fail "tables"
grep -q 'particles 216 contacts [1-9]' expected.txt || fail "tables: $(cat expected.txt)"
tried=0

python=$(python_with h5py)
if [ -n "$python" ]; then
    cat >read.py <<'PY'
import h5py
import numpy

run = h5py.File("run.h5")
contacts = run["connectivity/contacts"]
first, end = contacts["offset"][-2:]
force = contacts["normal_force"][first:end][:, None] * contacts["normal"][first:end]
force += contacts["tangential_force"][first:end]
position = run["particles/trajectory/position/value"][-1]
springs = numpy.sqrt((contacts["history/spring"][first:end]**2).sum(axis=1)).sum()
print("found particles %d contacts %d force %.9e springs %.9e top %.6e" %
      (len(position), end - first, numpy.sqrt((force**2).sum(axis=1)).sum(), springs, position[:, 2].max()))
PY
    "$python" read.py >said.txt 2>&1 || fail "h5py"
    agree "h5py, of run.h5 itself"
    tried=$((tried + 1))
else
    echo "SKIPPED: h5py is not installed"
fi

if command -v pvpython >/dev/null; then
    cat >read.py <<'PY'
from paraview.simple import PVDReader, servermanager
from paraview.vtk.numpy_interface import dataset_adapter
import numpy
import os

def last(name):
    reader = PVDReader(FileName=os.path.abspath("vtk/%s.pvd" % name))
    reader.UpdatePipelineInformation()
    times = list(reader.TimestepValues)
    reader.UpdatePipeline(times[-1])
    data = servermanager.Fetch(reader)
    if data.IsA("vtkMultiBlockDataSet"):
        data = data.GetBlock(0)
    return len(times), dataset_adapter.WrapDataObject(data)

frames, particles = last("particles")
_, contacts = last("contacts")
pair, points = contacts.CellData["pair"], contacts.Points
inner = [k for k in range(len(pair)) if pair[k][1] >= 0]
for k in inner:
    assert (points[2 * k] == particles.Points[int(pair[k][0])]).all()
    assert (points[2 * k + 1] == particles.Points[int(pair[k][1])]).all()
for k in set(range(len(pair))) - set(inner):  # the point on a wall is as far as the radius less the overlap
    length = numpy.linalg.norm(points[2 * k + 1] - points[2 * k])
    reach = particles.PointData["radius"][int(pair[k][0])] - contacts.CellData["overlap"][k]
    assert abs(length - reach) < 1e-12 * reach
assert contacts.VTKObject.GetNumberOfLines() == len(pair)
assert (particles.PointData["id"] == numpy.arange(len(particles.Points))).all()
force = numpy.array(contacts.CellData["force"])
print("frames", frames)
springs = numpy.sqrt((numpy.array(contacts.CellData["history_spring"])**2).sum(axis=1)).sum()
print("found particles %d contacts %d force %.9e springs %.9e top %.6e" %
      (len(particles.Points), len(pair), numpy.sqrt((force**2).sum(axis=1)).sum(), springs, particles.Points[:, 2].max()))
PY
    pvpython read.py >said.txt 2>&1 || fail "ParaView"
    agree ParaView
    tried=$((tried + 1))
else
    echo "SKIPPED: ParaView is not installed"
fi

python=$(python_with MDAnalysis)
if [ -n "$python" ]; then
    cat >read.py <<'PY'
import MDAnalysis
import warnings

warnings.simplefilter("ignore")
file = "lammps-dump/particles.dump"
universe = MDAnalysis.Universe(file, format="LAMMPSDUMP", topology_format="LAMMPSDUMP", convert_units=False)
last = universe.trajectory[-1]
print("found particles %d top %.4e" % (len(universe.atoms), universe.atoms.positions[:, 2].max()))
PY
    "$python" read.py >said.txt 2>&1 || fail "MDAnalysis"
    # it moves the corner of the box to 0, and keeps positions in single precision: 6e-8 of 0.06 m
    grep -qxFf shifted.txt said.txt || fail "MDAnalysis: not $(cat shifted.txt)"
    echo "MDAnalysis: reads the same of the dump"
    tried=$((tried + 1))
else
    echo "SKIPPED: MDAnalysis is not installed"
fi

lammps=$(command -v lmp || command -v lmp_serial)
if [ -n "$lammps" ]; then
    cat >in.lmp <<'LMP'
units si
atom_style sphere
boundary f f f
region box block 0 1 0 1 0 1
create_box 1 box
read_dump lammps-dump/particles.dump ${step} x y z vx vy vz box yes replace no add yes
variable n equal count(all)
variable top equal bound(all,zmax)
print "found particles $n top $(v_top:%.6e)"
LMP
    "$lammps" -in in.lmp -log none -var step "$(tail -n 1 csv/frames.csv | cut -d, -f2)" >said.txt 2>&1 || fail "LAMMPS"
    grep -qF "$(sed 's/contacts.*top/top/' expected.txt)" said.txt || fail "LAMMPS: not $(cat expected.txt)"
    echo "LAMMPS: reads the same of the dump"
    tried=$((tried + 1))
else
    echo "SKIPPED: LAMMPS is not installed"
fi

grep -q '^ITEM: ENTRIES .* history_spring\[1\] history_spring\[2\] history_spring\[3\]' lammps-dump/contacts.dump ||
    fail "contacts.dump has no springs"

# Contacts between particles and with walls stand in files of their own.
entries=$(awk '/NUMBER OF ENTRIES/ { getline; last = $1 } END { print last }' lammps-dump/wall_contacts.dump)
[ "$entries" = "$(cat walls.txt)" ] || fail "wall_contacts.dump has $entries entries in its last frame, not $(cat walls.txt)"
[ "$tried" -gt 0 ] || exit 125
