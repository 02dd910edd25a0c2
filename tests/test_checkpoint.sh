#!/usr/bin/env bash
# Runs that are killed and go on: test_checkpoint.sh CASE. Real processes (SHAKEDOWN_BIN) on tests/scenes/gentle.cfg, in a
# network namespace of its own. What goes on must be the same, bit for bit, as a run that was never stopped.
set -uo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
unset LCM_DEFAULT_URL

[ -n "${TEST_NAMESPACE:-}" ] || TEST_NAMESPACE=1 exec "$root/tests/in_namespace.sh" "$BASH" "${BASH_SOURCE[0]}" "$@"

work=$(mktemp -d)
cd "$work" || exit 1
driver=''
trap '[ -z "$driver" ] || kill -KILL -- "-$driver" 2>/dev/null; rm -rf "$work"' EXIT

readonly scene=$root/tests/scenes/gentle.cfg
# Long enough to be caught, with many checkpoints.
readonly settings=(--set checkpoint_interval_s=0.01 --set stages.0.duration_s=0.03)

fail() {
    echo "FAILED at line ${BASH_LINENO[1]}: $*"
    tail -n 40 ./*.out */log/*.log 2>/dev/null
    exit 1
}

shakedown() { # ARGUMENTS...: output into last.out
    "$root/shakedown" "$@" >last.out 2>&1 </dev/null
}

expect_code() { # EXPECTED ACTUAL
    [ "$1" -eq "$2" ] || fail "exit code $2 instead of $1"
}

expect_text() { # FILE PATTERN
    grep -q -- "$2" "$1" || fail "no '$2' in $1"
}

# Polls, as another process' files give no signal; bounded.
wait_for() { # COMMAND...
    local k
    for ((k = 0; k < 6000; k++)); do
        "$@" && return
        sleep 0.01
    done
    fail "waited in vain for: $*"
}

attribute() { # FILE NAME
    h5dump -a "$2" "$1" | sed -n 's/^ *(0): //p'
}

same_data() { # FILE FILE GROUP
    "$root/tests/same_data.sh" "$@"
}

expect_same_run() { # DIR DIR
    local group
    [ "$(attribute "$1/run.h5" complete)" = 1 ] && [ "$(attribute "$2/run.h5" complete)" = 1 ] || fail "not complete"
    [ "$(attribute "$1/run.h5" state_hash)" = "$(attribute "$2/run.h5" state_hash)" ] || fail "other hashes"
    for group in samples notes observables particles connectivity frames walls; do
        same_data "$1/run.h5" "$2/run.h5" "/$group" || fail "$group differs"
    done
    cmp "$1/run.xdmf" "$2/run.xdmf" || fail "run.xdmf differs"
}

# The run stops itself at a stated point (bench/fault_shim.c), however fast or slow it is: what is done to it then does
# not come too late.
start_until() { # NAME:CALL:N ARGUMENTS...
    local point=$1
    shift
    rm -f struck.0 # once: the launcher may start another sim
    FAULTS_AT=$point:STOP FAULTS_ONCE=$work/struck LD_PRELOAD=$SHAKEDOWN_BIN/bench/fault_shim.so \
        ASAN_OPTIONS=${ASAN_OPTIONS:-}:verify_asan_link_order=0 start_driver "$@"
    wait_for sim_is_stopped
}

sim_is_stopped() {
    grep -q '^State:.T' "/proc/$(pid_of sim)/status" 2>/dev/null
}

start_driver() { # ARGUMENTS...
    set -m
    "$root/shakedown" run "$scene" "${settings[@]}" --out cut "$@" >cut.out 2>&1 </dev/null &
    driver=$!
    set +m
}

pid_of() { # NAME
    sed -n "s/^$1 //p" cut/log/pids
}

# The second one, or the first if that is the end of a stage: its copy is a second file. At least a stage is to come.
readonly checkpoint=sim:rename:2

driver_ended() {
    [ ! -d "/proc/$driver" ] || grep -q '^State:.*Z' "/proc/$driver/status" 2>/dev/null
}

# --- Cases -----------------------------------------------------------------------------------------------------------

case_kill_sim() {
    shakedown run "$scene" "${settings[@]}" --out whole
    expect_code 0 $?
    start_until "$checkpoint"
    kill -KILL "$(pid_of sim)"
    wait_for driver_ended
    [ "$(attribute cut/run.h5 complete)" = 0 ] || fail "complete after a kill"
    shakedown run --resume cut
    expect_code 0 $?
    expect_same_run whole cut
    # the event log is that of one run, too
    "$SHAKEDOWN_BIN/recorder/recorder" --from cut/run.lcm --out again >last.out 2>&1 || fail "the log is not whole"
    expect_same_run whole again
}

# The recorder, too, dies without a word, so its file holds what it has said to be on disk. The last rows of the walls'
# compressed tables may be lost, so these are left out here. Whose death the launcher sees first is not said: after the
# recorder's the run goes on by itself, after that of sim by --resume.
case_kill_all() {
    settings_more=(--set record.walls=sampled --set record.event_log=false)
    shakedown run "$scene" "${settings[@]}" "${settings_more[@]}" --out whole
    expect_code 0 $?
    start_until "$checkpoint" "${settings_more[@]}"
    kill -KILL "$(pid_of sim)" "$(pid_of recorder)" "$(pid_of wallctl)"
    wait_for driver_ended
    if [ "$(attribute cut/run.h5 complete)" = 0 ]; then
        shakedown run --resume cut
        expect_code 0 $?
    else
        grep -q 'goes on from the checkpoint' cut.out || fail "complete without a restart"
    fi
    [ "$(attribute whole/run.h5 state_hash)" = "$(attribute cut/run.h5 state_hash)" ] || fail "other hashes"
    for group in samples notes observables particles connectivity frames; do
        same_data whole/run.h5 cut/run.h5 "/$group" || fail "$group differs"
    done
}

# END closes the record of an interrupted run; it is opened again.
case_interrupt() {
    shakedown run "$scene" "${settings[@]}" --out whole
    expect_code 0 $?
    start_until "$checkpoint"
    kill -INT "$driver"
    wait_for driver_ended
    [ "$(attribute cut/run.h5 complete)" = 1 ] || fail "the interrupted record is not closed"
    shakedown run --resume cut
    expect_code 0 $?
    expect_same_run whole cut
}

has_record() {
    [ -s cut/run.h5 ]
}

# In the first stage of 15000 exchanges: datagrams sent, or blocks of the log written.
declare -rA early=([over-the-bus]=sim:send:3000 [in-process]=sim:write:5)

# A first stage without a checkpoint is not lost either: one is written when the run is told to stop.
case_first_stage() {
    local long=(--set stages.0.duration_s=0.03) how
    for how in over-the-bus in-process; do
        rm -rf whole cut
        [ "$how" = over-the-bus ] || long+=(--in-process)
        shakedown run "$scene" "${long[@]}" --out whole
        expect_code 0 $?
        start_until "${early[$how]}" "${long[@]}" --set checkpoint_interval_s=0
        kill -TERM "$driver"
        wait_for driver_ended
        [ "$(tail -n 1 cut.out)" = "go on with: ./shakedown run --resume $work/cut" ] || fail "no way to go on"
        [ -f cut/checkpoint.h5 ] || fail "no checkpoint"
        [ ! -f cut/checkpoint-confine.h5 ] || fail "the first stage was over"
        [ "$(attribute cut/run.h5 complete)" = 1 ] || fail "the interrupted record is not closed"
        shakedown run --resume cut
        expect_code 0 $?
        expect_same_run whole cut
    done
}

# Killed before its first checkpoint, a run starts again; what it recorded is kept.
case_no_checkpoint() {
    shakedown run "$scene" --set stages.0.duration_s=0.03 --out whole
    expect_code 0 $?
    start_until "${early[over-the-bus]}" --set stages.0.duration_s=0.03 --set checkpoint_interval_s=0
    wait_for has_record
    kill -KILL "$(pid_of sim)"
    wait_for driver_ended
    shakedown run --out cut "$scene"
    expect_code 2 $?
    expect_text last.out 'holds a run already'
    shakedown run --resume cut
    expect_code 0 $?
    expect_text last.out 'starts from the beginning'
    [ -f cut/run.h5.before ] || fail "what was recorded is gone"
    expect_same_run whole cut
}

# A run in one process and the same one killed and resumed.
same_in_process() { # ARGUMENTS...
    shakedown run "$scene" "${settings[@]}" --out whole --in-process "$@"
    expect_code 0 $?
    start_until "$checkpoint" --in-process "$@"
    kill -KILL "$(pid_of sim)"
    wait_for driver_ended
    shakedown run --resume cut
    expect_code 0 $?
    expect_same_run whole cut
}

case_in_process() {
    same_in_process
    expect_text last.out 'going on from'
}

# What a scheme keeps between exchanges is in the checkpoint: the command in hand, the errors of the last intervals, the
# step of an impedance.
case_schemes() {
    local scheme
    for scheme in pipelined adaptive impedance compensated; do
        rm -rf whole cut
        same_in_process --set "coupling.scheme=$scheme" --set coupling.interval_steps=7
    done
    rm -rf whole cut
    same_in_process --set coupling.scheme=compensated --set coupling.interval_steps=7 --set coupling.ahead_steps=3
}

# A kill between END in the log and run.h5 in its place: only run.h5 is to be made, and nothing is computed again. The log
# of a run over the bus is brought to disk at its two checkpoints, at the ends of the stages, and at END.
case_kill_after_end() {
    local how more=(--set checkpoint_interval_s=0)
    shakedown run "$scene" "${settings[@]}" "${more[@]}" --out whole
    expect_code 0 $?
    FAULTS_AT=recorder:log:3:KILL FAULTS_ONCE=$work/struck LD_PRELOAD=$SHAKEDOWN_BIN/bench/fault_shim.so \
        ASAN_OPTIONS=${ASAN_OPTIONS:-}:verify_asan_link_order=0 start_driver "${more[@]}"
    wait_for driver_ended
    wait "$driver"
    expect_code 0 $?
    expect_text cut.out 'was ended by signal KILL, when it had recorded all of the run'
    expect_text cut.out 'the log is complete: run.h5 is made from it'
    expect_same_run whole cut
    more=()
    for how in over-the-bus in-process; do # what is left if the launcher is killed too
        [ "$how" = over-the-bus ] || more=(--in-process)
        rm -rf whole cut
        shakedown run "$scene" "${more[@]}" --out whole
        expect_code 0 $?
        cp -r whole cut
        rm cut/run.h5 cut/run.xdmf cut/analysis.json
        shakedown run --resume cut
        expect_code 0 $?
        expect_text last.out 'the log is complete: run.h5 is made from it'
        [ -f cut/analysis.json ] || fail "not evaluated"
        expect_same_run whole cut
        cmp whole/run.lcm cut/run.lcm || fail "the log was touched"
        shakedown run --resume cut
        expect_code 5 $?
        expect_text last.out 'is complete already'
    done
}

# Two scenes share one preparation.
case_series() {
    shakedown run "$scene" --out first --in-process
    expect_code 0 $?
    [ -s first/checkpoint-confine.h5 ] || fail "no checkpoint of the stage"
    local kc
    for kc in 1e4 9e4; do
        shakedown run "$scene" --in-process --out "kc-$kc" --set sample.initial=checkpoint \
            --set "sample.checkpoint=\"$work/first/checkpoint-confine.h5\"" --set "material.kc_n_per_m=$kc"
        expect_code 0 $?
    done
    h5diff -q kc-1e4/run.h5 kc-9e4/run.h5 /particles/trajectory/radius || fail "other particles"
    [ "$(attribute kc-1e4/run.h5 state_hash)" != "$(attribute kc-9e4/run.h5 state_hash)" ] || fail "the same run"
}

case_refused() {
    shakedown run "$scene" --out 'done' --in-process
    expect_code 0 $?
    shakedown run "$scene" --out over_bus
    expect_code 0 $?
    local before
    before=$(cksum <over_bus/run.h5)
    shakedown run --resume over_bus --set material.mu_s=0.25
    expect_code 3 $?
    shakedown run --resume over_bus # there is nothing to go on with
    expect_code 5 $?
    expect_text last.out 'is complete already'
    [ "$(cksum <over_bus/run.h5)" = "$before" ] || fail "a complete record was touched"
    before=$(cksum <done/run.h5)
    shakedown run --resume 'done' --set material.mu_s=0.25
    expect_code 3 $?
    expect_text last.out 'belongs to another scene: material.mu_s was'
    [ "$(cksum <done/run.h5)" = "$before" ] || fail "a complete record was touched"
    mkdir empty
    shakedown run --resume empty
    expect_code 5 $?
    expect_text last.out 'no checkpoint in empty'
    shakedown run "$scene" --resume 'done'
    expect_code 2 $?
    head -c 1000 done/checkpoint.h5 >short
    mv short done/checkpoint.h5
    shakedown run --resume 'done'
    expect_code 6 $?
    expect_text last.out 'the checkpoint is damaged'
}

"case_$1"
