#!/usr/bin/env bash
# Runs that are disturbed must come to the same record:
#   ./shakedown bench faults [--n N] [--seed N] [--kinds LIST] [--stop SECONDS] [--kills N]
#   ./shakedown bench faults --signals [--kinds PATTERNS]       each signal to each process: faults_signals.sh
# Each kind of fault below is tried N times (default 10) at random moments of a run of a second (tests/scenes/gentle.cfg);
# kills_many and kills_at_calls are runs with up to KILLS kills each (default 12), which are counted one by one.
# What the driver does not mend by itself is gone on with by `./shakedown run --resume`. Prints how often each was tried
# and what came out. Exit code 1 if a run was lost, hung, or differs from the undisturbed one.
set -uo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"

readonly kinds_of_processes=(sim wallctl recorder)
readonly hang_after_s=60 settle_after_s=15

# Memory as a disk that can be filled: a mount of its own, which ends with this script.
if [ -z "${FAULTS_MOUNTS:-}" ]; then
    user=()
    [ "$(id -u)" -eq 0 ] || user=(--map-root-user)
    if ! unshare "${user[@]}" --mount -- true; then
        echo "faults: this system allows no mounts of one's own (unshare --mount, as root or with -r)" >&2
        exit 125
    fi
    FAULTS_MOUNTS=1 exec unshare "${user[@]}" --mount -- "$BASH" "${BASH_SOURCE[0]}" "$@"
fi

read_options --signals '--n --seed --kinds --stop --kills' '--signals --n --seed --kinds --stop --kills' "$@"
n=${given[--n]:-10}
RANDOM=${given[--seed]:-1}
readonly stop_s=${given[--stop]:-3} # how long a process is stopped
readonly kills_per_run=${given[--kills]:-12}
out=$(mktemp -d) || exit 5
trap 'end_driver; cd /; umount "$out" 2>/dev/null; rm -rf "$out"' EXIT
mount -t tmpfs -o size=200m faults "$out" || exit 5
cd "$out" || exit 5
unset LCM_DEFAULT_URL
exec 3>&2 2>bash.err # where bash tells of every process that was killed

readonly scene=$root/tests/scenes/gentle.cfg
readonly settings=(--set checkpoint_interval_s=0.05 --set stages.0.duration_s=0.03 --set record.walls=sampled)
# Over a bad network: all exchanges recorded, and few of them, as each costs round trips. Its undisturbed run is another.
readonly net_settings=(--set stages.0.duration_s=0.03 --set coupling.scheme=impedance --set coupling.interval_steps=64)
readonly shim=$bin/bench/fault_shim.so
declare -A kills=([sim]=0 [wallctl]=0 [recorder]=0 [launcher]=0)
declare -A tried=() mended=() resumed=() refused=() bad=() longest_ms=()
driver=''

now_ms() {
    echo $((${EPOCHREALTIME//[!0-9]/} / 1000))
}

end_driver() {
    [ -z "$driver" ] || kill -KILL "$driver" 2>/dev/null
}

start_driver() { # ARGUMENTS...: output to last.out; sets driver
    "$root/shakedown" run "$@" >last.out 2>&1 </dev/null &
    driver=$!
}

# Sets `code` and `ended_ms`; a driver that does not end is killed and counts as code 124.
await_driver() {
    local start k
    start=$(now_ms)
    for ((k = 0; k < hang_after_s * 50; k++)); do
        [ -d "/proc/$driver" ] && ! grep -q '^State:.Z' "/proc/$driver/status" 2>/dev/null || break
        sleep 0.02
    done
    [ "$k" -lt $((hang_after_s * 50)) ] || kill -KILL "$driver"
    wait "$driver" 2>/dev/null
    code=$?
    [ "$k" -lt $((hang_after_s * 50)) ] || code=124
    ended_ms=$(($(now_ms) - start))
    driver=''
}

# Our own process of that name, as ids that were noted may be another's by now. Before there is a run id nothing has
# begun that could be gone on with.
process() { # NAME: prints its id
    local pid
    [ -e run/run-id ] || return
    for pid in $(cat "/proc/$driver/task/$driver/children" 2>/dev/null); do
        [ "$(cat "/proc/$pid/comm" 2>/dev/null)" != "$1" ] || echo "$pid"
    done
}

# At a random moment of a run, whose length is whole_ms.
wait_a_while() {
    sleep "$(printf '0.%03d' $((RANDOM * whole_ms / 32768)))"
}

at_work() { # prints the command lines of those who have the run's folder locked
    local fd
    for fd in /proc/[0-9]*/fd/*; do
        [ ! "$fd" -ef run/log ] || tr '\0' ' ' <"${fd%/fd/*}/cmdline"
    done
}

fingerprint() { # DIR: what two equal runs have in common
    local group
    h5dump -a complete "$1/run.h5" | grep -q '(0): 1' || return
    h5dump -a state_hash "$1/run.h5" | tail -n +2
    {
        h5dump -d /notes "$1/run.h5" | tail -n +2
        for group in samples observables particles connectivity frames; do
            h5dump -g "/$group" "$1/run.h5" | tail -n +2
        done
    } | cksum
}

count() { # KIND WHAT
    local -n counter=$2
    counter[$1]=$((${counter[$1]:-0} + 1))
}

note_bad() { # KIND WHY
    count "$1" bad
    echo "faults: $1: $2" >&3
    tail -n 20 last.out >&3
}

# Goes on until the run is whole, and compares.
judge() { # KIND [FINGERPRINT]
    local k wanted=${2:-$whole}
    [ "${longest_ms[$1]:-0}" -ge "$ended_ms" ] || longest_ms[$1]=$ended_ms
    [ "$code" -ne 124 ] || { note_bad "$1" "the driver hung" && return; }
    [ "$ended_ms" -le "${settle_after_s}000" ] || note_bad "$1" "the driver took $ended_ms ms to end"
    [ "$code" -eq 0 ] || count "$1" resumed
    for ((k = 0; code != 0 && k < 3; k++)); do
        flock -w "$settle_after_s" run/log true || { note_bad "$1" "processes stay: $(at_work)" && return; }
        start_driver --resume run
        await_driver
    done
    if [ "$code" -eq 5 ] && [ -e run/analysis.json ] && grep -q 'is complete already' last.out; then
        code=0 # it was over: only the driver's own end was left to strike
    fi
    if [ "$code" -ne 0 ]; then
        note_bad "$1" "cannot be gone on with: exit code $code"
    elif [ "$(fingerprint run)" != "$wanted" ]; then
        note_bad "$1" "another record"
    elif [ "$k" -eq 0 ]; then
        count "$1" mended
    fi
}

# A fault that found nothing to hit is tried again.
hit() { # SIGNAL PID...
    local signal=$1
    shift
    [ $# -gt 0 ] && kill "-$signal" "$@" 2>/dev/null
}

# --- Kinds of faults. Each returns 1 if the run was over before it could strike. -------------------------------------

kill_one() { # NAME
    local pid
    pid=$(process "$1")
    hit KILL ${pid:+"$pid"}
}

fault_kill_sim() { kill_one sim; }
fault_kill_wallctl() { kill_one wallctl; }
fault_kill_recorder() { kill_one recorder; }
fault_kill_launcher() { [ -e run/run-id ] && hit KILL "$driver"; } # before, nothing has begun

fault_kill_all() {
    local pids
    mapfile -t pids < <(for name in "${kinds_of_processes[@]}"; do process "$name"; done)
    [ "${#pids[@]}" -gt 0 ] && hit KILL "$driver" "${pids[@]}"
}

fault_term_all() {
    local pids
    mapfile -t pids < <(for name in "${kinds_of_processes[@]}"; do process "$name"; done)
    [ "${#pids[@]}" -gt 0 ] && hit TERM "$driver" "${pids[@]}"
}

fault_signal_any() {
    local receivers=(sim wallctl recorder launcher) signals=(INT TERM HUP) pid
    local receiver=${receivers[RANDOM % 4]} signal=${signals[RANDOM % 3]}
    pid=$driver
    [ -e run/run-id ] || return # before, nothing has begun
    [ "$receiver" = launcher ] || pid=$(process "$receiver")
    hit "$signal" ${pid:+"$pid"}
}

stop_one() { # NAME
    local pid
    pid=$(process "$1")
    hit STOP ${pid:+"$pid"} || return
    sleep "$stop_s"
    hit CONT "$pid"
    return 0
}

fault_stop_any() { stop_one "${kinds_of_processes[RANDOM % 3]}"; }
fault_stop_sim() { stop_one sim; }
fault_stop_wallctl() { stop_one wallctl; }
fault_stop_recorder() { stop_one recorder; }

fault_full_disk() {
    [ -e run/run-id ] || return
    fallocate -l 100G filler 2>/dev/null || cat /dev/zero >filler 2>/dev/null
    sleep 0.5
    rm -f filler
}

trial() { # KIND
    local k
    for ((k = 0; k < 20; k++)); do
        rm -rf run
        start_driver "$scene" "${settings[@]}" --keep-going --out run
        wait_a_while
        if "fault_$1"; then
            await_driver
            count "$1" tried
            judge "$1"
            return
        fi
        await_driver
    done
    note_bad "$1" "never struck"
}

# --- Many kills in one run ---------------------------------------------------------------------------------------------

more_restarts=(--keep-going --restarts 100)

driver_is_there() {
    [ -d "/proc/$driver" ] && ! grep -q '^State:.Z' "/proc/$driver/status" 2>/dev/null
}

# One of the processes, taken at random, about every tenth of a second, until the run is over.
trial_kills_many() {
    local k names=("${kinds_of_processes[@]}" launcher) name
    rm -rf run
    start_driver "$scene" "${settings[@]}" "${more_restarts[@]}" --out run
    for ((k = 0; k < kills_per_run; k++)); do
        sleep "$(printf '0.%03d' $((RANDOM % 250)))"
        if ! driver_is_there; then
            await_driver
            [ "$code" -ne 0 ] || break
            flock -w "$settle_after_s" run/log true
            start_driver --resume run "${more_restarts[@]}"
            continue
        fi
        name=${names[RANDOM % 4]}
        "fault_kill_$name" || continue
        count kills_many tried
        kills[$name]=$((kills[$name] + 1))
    done
    [ -z "$driver" ] || await_driver
    judge kills_many
}

# Sets `strikes`: NAME:CALL:N:KILL, of which any may strike, once. Renames and fsyncs are few, the other calls many.
random_strikes() {
    local k name call n
    local points=(sim:rename sim:fsync sim:write sim:send recorder:rename recorder:fsync recorder:write recorder:send
        wallctl:send wallctl:send launcher:write launcher:write)
    strikes=()
    for ((k = 0; k < kills_per_run; k++)); do
        IFS=: read -r name call <<<"${points[RANDOM % ${#points[@]}]}"
        n=$((1 + RANDOM % 6))
        [ "$call" = rename ] || [ "$call" = fsync ] || n=$((1 + RANDOM % (1 << (RANDOM % 12))))
        strikes+=("$name:$call:$n:KILL")
    done
}

# Right after a call that matters: a rename, an fsync, a block written, a message sent.
trial_kills_at_calls() {
    local k strikes
    random_strikes
    rm -rf run struck.*
    printf -v FAULTS_AT '%s,' "${strikes[@]}"
    export FAULTS_AT=${FAULTS_AT%,} FAULTS_ONCE=$out/struck LD_PRELOAD=$shim
    start_driver "$scene" "${settings[@]}" "${more_restarts[@]}" --out run
    await_driver
    for ((k = 0; code != 0 && code != 124 && k < kills_per_run; k++)); do
        flock -w "$settle_after_s" run/log true
        if [ -e run/run-id ]; then
            start_driver --resume run "${more_restarts[@]}"
        else # killed before anything had begun
            start_driver "$scene" "${settings[@]}" "${more_restarts[@]}" --out run
        fi
        await_driver
    done
    unset FAULTS_AT FAULTS_ONCE LD_PRELOAD
    for k in "${!strikes[@]}"; do
        [ -e "struck.$k" ] || continue
        count kills_at_calls tried
        kills[${strikes[k]%%:*}]=$((kills[${strikes[k]%%:*}] + 1))
    done
    judge kills_at_calls
}

# --- A bad network, a wrong clock --------------------------------------------------------------------------------------

disturbed() { # KIND FINGERPRINT ARGUMENTS-OF-RUN...: with the shim's settings in the environment
    rm -rf run
    LD_PRELOAD=$shim start_driver "$scene" "${@:3}" --out run
    await_driver
    count "$1" tried
    judge "$1" "$2"
}

net() { # KIND FAULTS
    FAULTS_NET=$2,seed=$RANDOM disturbed "$1" "$whole_net" "${net_settings[@]}"
}

trial_loss_1() { net loss_1 loss=0.01; }
trial_loss_5() { net loss_5 loss=0.05; }
trial_loss_20() { net loss_20 loss=0.2; }
trial_deaf_20() { net deaf_20 deaf=0.2; }
trial_duplicates() { net duplicates duplicate=0.2; }
trial_reorder() { net reorder reorder=0.2; }
trial_delay() { net delay delay_s=0.01; }
trial_all_of_it() { net all_of_it loss=0.05,duplicate=0.05,reorder=0.05,delay_s=0.001; }

# An hour back, in all processes, at a random moment.
trial_clock_back() {
    FAULTS_CLOCK=$(printf '0.%03d:-3600' $((RANDOM % 1000))) disturbed clock_back "$whole" "${settings[@]}"
}

# --- Faults at the start: the run is refused with a reason, and nothing is left behind. -------------------------------

refuse() { # KIND PATTERN
    count "$1" tried
    await_driver
    if [ "$code" -eq 5 ] && grep -q -- "$2" last.out; then
        count "$1" refused
    else
        note_bad "$1" "exit code $code, without the reason '$2'"
    fi
}

trial_read_only() {
    rm -rf run && mkdir run && mount --bind run run && mount -o remount,ro,bind run
    start_driver "$scene" "${settings[@]}" --out run/deeper
    refuse read_only 'Read-only file system'
    umount run
}

# The folder of a run vanishes: no hang, no success.
trial_folder_removed() {
    rm -rf run
    start_driver "$scene" "${settings[@]}" --out run
    wait_a_while
    [ -d run/log ] && rm -rf run
    await_driver
    count folder_removed tried
    if [ -d run/log ] && [ "$code" -eq 0 ]; then
        count folder_removed mended # it was over, or not there yet
    elif [ "$code" -ne 0 ] && [ "$code" -ne 124 ]; then
        count folder_removed refused
    else
        note_bad folder_removed "exit code $code"
    fi
}

if [ -n "${given[--signals]:-}" ]; then
    # shellcheck source=faults_signals.sh
    . "$root/bench/faults_signals.sh"
    signals_table
    exit
fi

# --- The table -------------------------------------------------------------------------------------------------------

read -ra kinds <<<"${given[--kinds]:-kill_sim kill_wallctl kill_recorder kill_launcher kill_all term_all signal_any \
stop_any full_disk read_only folder_removed kills_many kills_at_calls loss_1 loss_5 loss_20 deaf_20 duplicates reorder \
delay all_of_it clock_back}"

start_driver "$scene" "${settings[@]}" --out whole
await_driver
[ "$code" -eq 0 ] || { cat last.out && exit 1; }
whole=$(fingerprint whole)
whole_ms=$((ended_ms < 1000 ? ended_ms : 999))
start_driver "$scene" "${net_settings[@]}" --out whole_net
await_driver
[ "$code" -eq 0 ] || { cat last.out && exit 1; }
whole_net=$(fingerprint whole_net)

for kind in "${kinds[@]}"; do
    declare -F "fault_$kind" "trial_$kind" >/dev/null || declare -F "fault_$kind" >/dev/null ||
        declare -F "trial_$kind" >/dev/null || bench_usage "no kind $kind" 2>&3
    for ((i = 0; i < n; i++)); do
        if declare -F "trial_$kind" >/dev/null; then
            "trial_$kind"
        else
            trial "$kind"
        fi
    done
done

printf '%-16s %6s %8s %10s %8s %5s %12s\n' fault tried 'by itself' 'gone on with' refused bad 'longest end'
failures=0
for kind in "${kinds[@]}"; do
    printf '%-16s %6d %8d %10d %8d %5d %10d ms\n' "$kind" "${tried[$kind]:-0}" "${mended[$kind]:-0}" \
        "${resumed[$kind]:-0}" "${refused[$kind]:-0}" "${bad[$kind]:-0}" "${longest_ms[$kind]:-0}"
    failures=$((failures + ${bad[$kind]:-0}))
done
echo "kills of kills_many and kills_at_calls: sim ${kills[sim]}, wallctl ${kills[wallctl]}, recorder ${kills[recorder]}," \
    "launcher ${kills[launcher]}"
[ "$failures" -eq 0 ]
