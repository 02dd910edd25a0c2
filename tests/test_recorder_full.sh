#!/usr/bin/env bash
# test_recorder_full.sh SIM WALLCTL RECORDER SCENE: a real run onto a disk that is full before it ends. The recorder says
# so, the simulator waits; when there is room again the run goes on and becomes complete. To be run in a network
# namespace of its own. 125: no small disk can be mounted here.
set -uo pipefail

if [ -z "${SHAKEDOWN_TEST_MOUNTS:-}" ]; then
    mine=(unshare --mount)
    "${mine[@]}" true 2>/dev/null || mine=(unshare --map-root-user --mount)
    "${mine[@]}" true 2>/dev/null || { echo "no mount namespace here (unshare --mount)"; exit 125; }
    SHAKEDOWN_TEST_MOUNTS=1 exec "${mine[@]}" "$BASH" "$0" "$@"
fi
sim=$1 wallctl=$2 recorder=$3 scene=$4
disk=$(mktemp -d)
words=$(mktemp)
pids=()
trap 'kill "${pids[@]}" 2>/dev/null; umount "$disk"; rmdir "$disk"; rm -f "$words"' EXIT
mount -t tmpfs -o size=4m tmpfs "$disk" || exit 125

fail() {
    echo "FAILED: $*"
    cat "$words"
    exit 1
}

# Room for RUN_INFO and some samples, not for the run.
head -c 3300000 /dev/zero >"$disk/filler"
"$recorder" --run-id 5 --out "$disk/out" >"$words" 2>&1 &
pids=($!)
"$wallctl" "$scene" --run-id 5 >/dev/null 2>&1 &
pids+=($!)
"$sim" "$scene" --run-id 5 >/dev/null 2>&1 &
pids+=($!)
for ((k = 0; k < 600; k++)); do
    grep -q 'waiting for room' "$words" && break
    read -rt 0.1 <> <(:)
done
grep -q 'waiting for room' "$words" || fail "the recorder never waited"
rm "$disk/filler"
for pid in "${pids[@]}"; do
    wait "$pid" || fail "process $pid ended with $?"
done
grep -q 'there is room again' "$words" || fail "the recorder does not say that it goes on"
h5dump -a /complete "$disk/out/run.h5" | grep -q '(0): 1' || fail "run.h5 is not complete"
h5dump -a /status "$disk/out/run.h5" | grep -q '(0): 0' || fail "the run did not end well"
