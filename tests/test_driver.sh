#!/usr/bin/env bash
# Tests of the driver script: test_driver.sh CASE. The cases fake_* put fake_process.sh in place of the processes, the
# others run the real ones (SHAKEDOWN_BIN) on scenes/quick.cfg. Everything happens in a network namespace of its own.
set -uo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
unset LCM_DEFAULT_URL

[ -n "${TEST_NAMESPACE:-}" ] || TEST_NAMESPACE=1 exec "$root/tests/in_namespace.sh" "$BASH" "${BASH_SOURCE[0]}" "$@"

work=$(mktemp -d)
cd "$work" || exit 1
trap 'end_drivers; rm -rf "$work"' EXIT

# --- Tools -----------------------------------------------------------------------------------------------------------

fail() {
    echo "FAILED at line ${BASH_LINENO[1]}: $*"
    tail -n 40 ./*.out 2>/dev/null
    exit 1
}

expect_code() { # EXPECTED ACTUAL
    [ "$1" -eq "$2" ] || fail "exit code $2 instead of $1"
}

expect_text() { # FILE PATTERN
    grep -q -- "$2" "$1" || fail "no '$2' in $1"
}

expect_no_file() { # PATH
    [ ! -e "$1" ] || fail "$1 exists"
}

# Polls, as another process' files give no signal; bounded.
wait_for() { # COMMAND...
    local k
    for ((k = 0; k < 400; k++)); do
        "$@" >/dev/null 2>&1 && return
        sleep 0.05
    done
    fail "waited in vain for: $*"
}

# The fakes' bus, a new one for each run. Held open here, so that a message neither blocks nor gets lost.
make_pipe() {
    FAKE_PIPE=$(mktemp -u "$work/pipe.XXXXXX")
    export FAKE_PIPE
    mkfifo "$FAKE_PIPE" "$FAKE_PIPE.walls" "$FAKE_PIPE.ack" "$FAKE_PIPE.silence"
    # shellcheck disable=SC2034 # only held open
    exec {pipe}<>"$FAKE_PIPE" {pipe}<>"$FAKE_PIPE.walls" {pipe}<>"$FAKE_PIPE.ack"
}

shakedown() { # ARGUMENTS...: output into last.out
    make_pipe
    "$root/shakedown" "$@" >last.out 2>&1 </dev/null
}

drivers=()

# In a process group of its own, with SIGINT as it is in a terminal.
start_driver() { # NAME ARGUMENTS...: output into NAME.out; sets `driver`
    local name=$1
    shift
    make_pipe
    set -m
    "$root/shakedown" "$@" >"$name.out" 2>&1 </dev/null &
    driver=$!
    set +m
    drivers+=("$driver")
}

end_drivers() {
    local pid
    for pid in "${drivers[@]}"; do
        kill -KILL -- "-$pid" 2>/dev/null
    done
}

pid_of() { # DIR NAME
    sed -n "s/^$2 //p" "$1/log/pids" | tail -n 1
}

is_running() { # DIR NAME
    [ -n "$(pid_of "$1" "$2")" ] && [ -d "/proc/$(pid_of "$1" "$2")" ]
}

# A process that has ended stays visible until the shell that attends to it has taken note.
expect_all_gone() { # DIR
    local name pid
    while read -r name pid; do
        wait_for [ ! -d "/proc/$pid" ]
    done <"$1/log/pids"
}

use_fakes() {
    local program
    for program in sim wallctl recorder analyzer; do
        mkdir -p "bin/$program"
        ln -s "$root/tests/fake_process.sh" "bin/$program/$program"
    done
    mkdir -p bin/common/watch
    ln -s /bin/true bin/common/watch/shakedown-watch
    mkdir bin/launcher
    ln -s "$LAUNCHER" bin/launcher/launcher
    export SHAKEDOWN_BIN=$work/bin
    echo 'name = "fake";' >good.cfg
}

fakes_are_ready() { # DIR
    grep -q namespace "$1/log/sim.log" && grep -q namespace "$1/log/recorder.log" && [ -s "$1/run.h5" ] &&
        grep -q namespace "$1/log/wallctl.log"
}

# --- Cases with fakes ------------------------------------------------------------------------------------------------

case_fake_usage() {
    use_fakes
    shakedown help
    expect_code 0 $?
    expect_text last.out '^usage: ./shakedown COMMAND'
    local arguments
    for arguments in 'fly' 'run' 'run --fast good.cfg' 'run good.cfg other.cfg' 'run good.cfg --set' 'run good.cfg --out' \
        'run --resume' 'run good.cfg --resume .' \
        'analyze' 'replay' 'watch' 'bench' 'bench nothing' 'study nothing'; do
        # shellcheck disable=SC2086 # words on purpose
        shakedown $arguments
        expect_code 2 $?
        expect_text last.out 'see ./shakedown help'
    done
    expect_no_file runs
}

case_fake_run() {
    use_fakes
    shakedown run good.cfg --set sample.count=10 --seed 7
    expect_code 0 $?
    local dir
    dir=$(sed -n 's/^results: //p' last.out)
    [ "$(tail -n 1 last.out)" = "results: $dir" ] || fail "the last line is not the results' path"
    expect_text last.out "a table of $dir"
    case $dir in "$work"/runs/good-*) ;; *) fail "results in $dir" ;; esac
    cmp good.cfg "$dir/scene.cfg" || fail "the scene was not copied"
    expect_text "$dir/log/sim.log" "^sim $dir/scene.cfg --set sample.count=10 --seed 7 --run-id $(<"$dir/run-id") --lcm"
    expect_text "$dir/log/wallctl.log" "^wallctl $dir/scene.cfg --set sample.count=10 --seed 7 --run-id $(<"$dir/run-id") --lcm"
    expect_text "$dir/log/recorder.log" "^recorder --run-id $(<"$dir/run-id") --out $dir --lcm $(<"$dir/lcm-url")"
    expect_all_gone "$dir"
    shakedown run good.cfg --out "$dir"
    expect_code 2 $?
    expect_text last.out 'holds a run already'
}

case_fake_broken_scene() {
    use_fakes
    printf 'name = "x";\nbroken = 1;\n' >bad.cfg
    shakedown run bad.cfg --out out
    expect_code 3 $?
    expect_text last.out 'bad.cfg:2: broken: unknown key'
    expect_no_file out
    shakedown run bad.cfg
    expect_code 3 $?
    expect_no_file runs
}

case_fake_ports() {
    use_fakes
    export FAKE_SIM=wait
    start_driver a run good.cfg --open --out a
    local first=$driver second code
    wait_for fakes_are_ready a
    start_driver b run good.cfg --open --out b
    second=$driver
    wait_for fakes_are_ready b
    [ "$(<a/lcm-url)" != "$(<b/lcm-url)" ] || fail "both on $(<a/lcm-url)"
    [ "$(<a/run-id)" != "$(<b/run-id)" ] || fail "both have run id $(<a/run-id)"
    kill -INT "$first" "$second"
    for driver in "$first" "$second"; do
        wait "$driver"
        code=$?
        expect_code 130 "$code"
    done
}

case_fake_interrupt() {
    use_fakes
    export FAKE_SIM=wait
    local signal
    for signal in INT TERM; do
        start_driver "$signal" run good.cfg --out "$signal"
        wait_for fakes_are_ready "$signal"
        kill "-$signal" -- "-$driver"
        wait "$driver"
        expect_code 130 $?
        expect_text "$signal.out" "interrupted"
        expect_text "$signal.out" "recorded so far: $work/$signal/run.h5"
        ! grep -q 'ended' "$signal.out" || fail "reports a process"
        expect_all_gone "$signal"
    done
}

case_fake_hang() {
    use_fakes
    export FAKE_SIM=hang SHAKEDOWN_STOP_WAIT_S=1
    start_driver hang run good.cfg --out hang
    wait_for fakes_are_ready hang
    kill -INT -- "-$driver"
    wait "$driver"
    expect_code 130 $?
    expect_text hang.out 'killed, as it did not end: sim'
    expect_all_gone hang
}

case_fake_failure() {
    use_fakes
    export FAKE_SIM=wait
    local name variable
    for name in sim wallctl recorder; do
        variable=FAKE_${name^^}
        start_driver "$name" run good.cfg --out "$name" --restarts 0
        wait_for fakes_are_ready "$name"
        kill -KILL "$(pid_of "$name" "$name")"
        wait "$driver"
        expect_code 137 $?
        expect_text "$name.out" "shakedown: $name was ended by signal KILL"
        expect_text "$name.out" "recorded so far"
        expect_all_gone "$name"
        (
            export "$variable=fail"
            shakedown run good.cfg --out "$name-fail"
        )
        expect_code 10 $?
        expect_text last.out "shakedown: $name ended with exit code 10"
        expect_text last.out "    $name: error: it was told to"
        expect_all_gone "$name-fail"
    done
}

# A controller or recorder that is killed is started again, a simulator if that is asked for; not for ever.
case_fake_restart() {
    use_fakes
    export FAKE_SIM=wait
    local name before
    for name in wallctl recorder sim; do
        start_driver "$name" run good.cfg --out "$name" --keep-going --restarts 2
        wait_for fakes_are_ready "$name"
        for before in 1 2; do
            before=$(pid_of "$name" "$name")
            kill -KILL "$before"
            wait_for is_another "$name" "$before"
        done
        kill -KILL "$(pid_of "$name" "$name")"
        wait "$driver"
        expect_code 137 $?
        expect_text "$name.out" "$name was ended by signal KILL; .*(2 of at most 2 restarts an hour)"
        expect_text "$name.out" "shakedown: $name was ended by signal KILL$"
        [ "$(tail -n 1 "$name.out")" = "go on with: ./shakedown run --resume $work/$name" ] || fail "no way to go on"
        expect_all_gone "$name"
    done
}

is_another() { # NAME PID: whether the process is there under another id, and ready
    [ "$(pid_of "$1" "$1")" != "$2" ] && [ "$(grep -c namespace "$1/log/$1.log")" -eq "$(grep -c "^$1 " "$1/log/pids")" ]
}

# A signal to one process, or to all at once as batch systems send it, is a wish that concerns the run.
case_fake_signals() {
    use_fakes
    export FAKE_SIM=wait
    local signal receiver pids
    for signal in TERM HUP INT; do
        for receiver in sim wallctl recorder launcher all; do
            start_driver "$signal-$receiver" run good.cfg --out "$signal-$receiver"
            wait_for fakes_are_ready "$signal-$receiver"
            case $receiver in
                launcher) pids=("$driver") ;;
                all) mapfile -t pids < <(echo "$driver" && cut -d' ' -f2 "$signal-all/log/pids") ;;
                *) pids=("$(pid_of "$signal-$receiver" "$receiver")") ;;
            esac
            kill "-$signal" "${pids[@]}"
            wait "$driver"
            expect_code 130 $?
            expect_text "$signal-$receiver.out" '^go on with: ./shakedown run --resume'
            ! grep -q 'killed, as' "$signal-$receiver.out" || fail "a process had to be killed"
            expect_all_gone "$signal-$receiver"
        done
    done
}

# Processes of a launcher that is killed do not stay.
case_fake_orphans() {
    use_fakes
    export FAKE_SIM=wait
    start_driver out run good.cfg --out out
    wait_for fakes_are_ready out
    kill -KILL "$driver"
    wait "$driver"
    expect_all_gone out
}

# A program of the user's own in place of wallctl.
case_fake_controller() {
    use_fakes
    ln -s "$root/tests/fake_process.sh" 'my wallctl'
    shakedown run good.cfg --out out --controller "'./my wallctl' --flag \"\$HOME x\"" --set a=b
    expect_code 0 $?
    expect_text out/log/controller.log "^wallctl --flag \$HOME x $work/out/scene.cfg --set a=b --run-id"
    expect_no_file out/log/wallctl.log
    shakedown run good.cfg --out two --controller x --in-process
    expect_code 2 $?
}

case_fake_url() {
    use_fakes
    local url='udpm://239.255.76.67:7999?ttl=0'
    LCM_DEFAULT_URL=$url shakedown run good.cfg --out out
    expect_code 0 $?
    [ "$(<out/lcm-url)" = "$url" ] || fail "runs on $(<out/lcm-url)"
    expect_text out/log/sim.log "--lcm $url"
}

case_fake_private() {
    use_fakes
    local here
    here="namespace $(readlink /proc/self/ns/net)"
    shakedown run good.cfg --out open --open
    expect_code 0 $?
    grep -qF "$here" open/log/sim.log || fail "private in spite of --open"
    shakedown run good.cfg --out default
    expect_code 0 $?
    ! grep -qF "$here" default/log/sim.log || fail "not private by default"
    [ -f open/key ] || fail "no key where others hear the run"
    expect_no_file default/key
    shakedown run good.cfg --out private --private
    expect_code 0 $?
    ! grep -qF "$here" private/log/sim.log || fail "not private"
    ip route del 224.0.0.0/4 dev lo
    shakedown run good.cfg --out forced --open
    expect_code 0 $?
    expect_text last.out 'no multicast route'
    ! grep -qF "$here" forced/log/sim.log || fail "not private"
}

# --- Cases with the real processes -----------------------------------------------------------------------------------

readonly quick=$root/scenes/quick.cfg

expect_attribute() { # FILE NAME VALUE
    h5dump -a "/$2" "$1" | grep -q "(0): \"\?$3" || fail "$2 is not $3 in $1"
}

case_run() {
    shakedown run "$quick" --out out
    expect_code 0 $?
    expect_attribute out/run.h5 complete 1
    expect_attribute out/run.h5 status 0
    [ "$(tail -n 1 last.out)" = "results: $work/out" ] || fail "the last line is not the results' path"
    expect_text last.out '^done: '
    expect_all_gone out
}

# The loop in one process and the loop over the bus come to the same bits.
case_in_process() {
    shakedown run "$quick" --out one --in-process
    expect_code 0 $?
    shakedown run "$quick" --out many
    expect_code 0 $?
    local name
    for name in one many; do
        expect_attribute "$name/run.h5" complete 1
        h5dump -a /state_hash "$name/run.h5" | tail -n +2 >"$name.hash"
    done
    cmp one.hash many.hash || fail "the states differ"
}

case_broken_scene() {
    printf 'dimension = 2;\nsample = { cuont = 10; };\n' >bad.cfg
    shakedown run bad.cfg --out out
    expect_code 3 $?
    expect_text last.out 'bad.cfg:2: .*cuont'
    expect_no_file out
    expect_no_file runs
}

case_two_runs() {
    start_driver a run "$quick" --open --out a
    local first=$driver
    start_driver b run "$quick" --open --out b
    wait "$first"
    expect_code 0 $?
    wait "$driver"
    expect_code 0 $?
    [ "$(<a/lcm-url)" != "$(<b/lcm-url)" ] || fail "both on $(<a/lcm-url)"
    [ "$(stat -c '%a %s' a/key)" = '600 33' ] || fail "no key of its own"
    ! cmp -s a/key b/key || fail "the same key"
    expect_attribute a/run.h5 complete 1
    expect_attribute b/run.h5 complete 1
}

# A scene without an end, for what is to be stopped on the way.
start_endless() { # NAME
    start_driver "$1" run "$quick" --out "$1" --set "stages.0.duration_s=1e4"
    wait_for env HDF5_USE_FILE_LOCKING=FALSE h5dump -n "$1/run.h5"
}

case_interrupt() {
    start_endless out
    kill -INT -- "-$driver"
    wait "$driver"
    expect_code 130 $?
    expect_text out.out "recorded so far: $work/out/run.h5"
    expect_attribute out/run.h5 complete 1
    expect_attribute out/run.h5 reason interrupted
    ! grep -q 'killed' out.out || fail "a process had to be killed"
    expect_all_gone out
}

case_kill_sim() {
    start_endless out
    kill -KILL "$(pid_of out sim)"
    wait "$driver"
    expect_code 137 $?
    expect_text out.out 'shakedown: sim was ended by signal KILL'
    expect_attribute out/run.h5 complete 0
    ! grep -q 'killed, as' out.out || fail "a process had to be killed"
    expect_all_gone out
}

# All are killed while the evaluation has its numbers, but no plots yet: it is done again.
case_kill_evaluation() {
    local row
    mkdir -p bin/analyzer
    for row in common launcher recorder sim wallctl; do ln -s "$SHAKEDOWN_BIN/$row" "bin/$row"; done
    printf '#!/bin/sh\necho {} >"$1/analysis.json"\nkill -KILL $PPID\n' >bin/analyzer/analyzer
    chmod +x bin/analyzer/analyzer
    SHAKEDOWN_BIN=$work/bin shakedown run "$quick" --out out
    expect_code 137 $?
    expect_attribute out/run.h5 complete 1
    shakedown run --resume out
    expect_code 0 $?
    [ -s out/stress_strain.svg ] || fail "no plot"
    expect_no_file out/log/evaluating
    shakedown run --resume out
    expect_code 5 $?
    expect_text last.out 'is complete already'
}

case_private() {
    ip route del 224.0.0.0/4 dev lo
    shakedown run "$quick" --out out --private
    expect_code 0 $?
    expect_attribute out/run.h5 complete 1
}

# A name of a folder with all that is odd in names; and a link to a folder.
case_odd_names() {
    local name=$'-a b\'q"o$t`e\nfüß?h&=x#%2;'
    mkdir real
    ln -s -- real "./$name"
    shakedown run "$quick" --out "$name"
    expect_code 0 $?
    expect_attribute real/run.h5 complete 1
    shakedown run "$quick" --out "$name-one" --in-process
    expect_code 0 $?
    expect_attribute "./$name-one/run.h5" complete 1
    [ -f "./$name-one/stress_strain.svg" ] || fail "no plot"
    shakedown run --resume "$name-one"
    expect_code 5 $?
    expect_text last.out 'is complete already'
    for command in 'analyze' 'verify' 'repair' 'export --csv'; do
        # shellcheck disable=SC2086 # words
        shakedown $command "$name-one"
        expect_code 0 $?
    done
    [ -n "$(ls -A "./$name-one/csv")" ] || fail "nothing exported"
}

# What repair says of a log that stops before its run did, and of a folder that kept no log.
case_repair() {
    shakedown run "$root/tests/scenes/gentle.cfg" --in-process --out out
    expect_code 0 $?
    truncate -s -100 out/run.lcm
    shakedown repair out
    expect_code 9 $?
    expect_text last.out 'go on with: ./shakedown run --resume out'
    expect_attribute out/run.h5 complete 0
    rm out/run.lcm
    shakedown repair out
    expect_code 5 $?
    expect_text last.out 'no run.lcm in out'
}

# The copy of a scene can be run again where it lies, with its sample from a checkpoint beside the original.
case_copied_scene() {
    mkdir scenes
    cp "$root/tests/scenes/gentle.cfg" scenes/first.cfg
    shakedown run scenes/first.cfg --in-process --out scenes/first
    expect_code 0 $?
    sed 's|^sample = {|sample = { initial = "checkpoint"; checkpoint = "first/checkpoint-confine.h5";|' scenes/first.cfg \
        >scenes/second.cfg
    shakedown run scenes/second.cfg --in-process --out out
    expect_code 0 $?
    expect_text out/scene.cfg "checkpoint = \"$work/scenes/first/checkpoint-confine.h5\";"
    shakedown run out/scene.cfg --in-process --out again
    expect_code 0 $?
    [ "$(h5dump -a /state_hash out/run.h5 | tail -n +2)" = "$(h5dump -a /state_hash again/run.h5 | tail -n +2)" ] ||
        fail "another run"
    shakedown run scenes/first.cfg --in-process --out third --set sample.initial=checkpoint \
        --set sample.checkpoint=first/checkpoint-confine.h5
    expect_code 0 $?
    expect_text third/overrides "^sample.checkpoint=\"$work/scenes/first/checkpoint-confine.h5\""
    shakedown replay third
    expect_code 0 $?
}

main() {
    declare -F "case_$1" >/dev/null || fail "no case $1"
    "case_$1"
    echo "passed"
}

main "$@"
