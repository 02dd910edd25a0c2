#!/usr/bin/env bash
# The controller in Java of examples/ runs in place of wallctl: 2000 steps, all recorded, and the stress that it keeps is
# kept. Skipped where Debian's liblcm-java or a compiler of Java is missing.
set -uo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
jar=/usr/share/java/lcm.jar
for needed in javac java lcm-gen; do
    command -v "$needed" >/dev/null || { echo "SKIPPED: $needed is not installed (apt install default-jdk-headless liblcm-bin)" && exit 125; }
done
[ -r "$jar" ] || { echo "SKIPPED: $jar is not installed (apt install liblcm-java)" && exit 125; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
    echo "$*"
    cat "$work/said"
    exit 1
}

# As the head of the example says.
lcm-gen -j --jpath "$work/java" "$root"/lcmtypes/*.lcm || exit 1
javac -Xlint:-options -cp "$jar" -d "$work/java" "$work"/java/shakedown/*.java "$root/examples/Controller.java" || exit 1
"$root/shakedown" run "$root/scenes/quick.cfg" --out "$work/run" --set stages.0.duration_s=0.02 \
    --controller "java -cp $jar:$work/java Controller" >"$work/said" 2>&1
h5dump -a /parameters/controller "$work/run/run.h5" | grep -qF ' Controller' || fail "run.h5 does not name the controller"
h5dump -y -a /complete "$work/run/run.h5" | grep -qE '^ +1$' || fail "the record is not whole"
h5dump -y -w 0 -d /samples/stage/step "$work/run/run.h5" | grep -qE '\b2000$' || fail "it did not last 2000 steps"
# It began with a force on the wall and compressed: positions that are its own say so.
h5dump -y -w 0 -d /samples/box_length_m/value "$work/run/run.h5" | grep -oE '0\.[0-9.e-]+, 0\.[0-9.e-]+' >"$work/lengths"
awk -F', ' 'NR == 1 { x = $1; z = $2 } { last_x = $1; last_z = $2 }
    # z: 2000 steps of 1e-6 s at 0.01 m/s, in the digits that are printed; x: moved by its loop
    END { way = z - last_z; exit !(way > 1.9e-5 && way < 2.1e-5 && last_x != x) }' "$work/lengths" ||
    fail "walls are not where it moved them: $(sed -n '1p;$p' "$work/lengths")"
