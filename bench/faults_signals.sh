# shellcheck shell=bash disable=SC2154
# Each signal to each process and to all at once, at three moments of a run: `./shakedown bench faults --signals`. Part of
# faults.sh, which sources it; --kinds takes patterns SIGNAL:RECEIVER:MOMENT, e.g. --kinds "TERM:*:mid KILL:all:*".
# The driver must end within settle_after_s seconds with the right code, and say how to go on as its last line; after
# anything but a kill there must be a closed record and a checkpoint; gone on with, the run must come to the record of one
# that nobody disturbed.

readonly signal_names=(INT TERM HUP KILL)
# in_one: of a run in one process
readonly signal_receivers=(driver sim wallctl recorder all driver_in_one sim_in_one all_in_one)
readonly signal_moments=(start mid last_flush)

# One checkpoint at the end of each of the two stages, so that the points below are the same in every run: the first
# datagram or block of the log; the first checkpoint; the log brought to disk at END (after its two checkpoints).
readonly signal_settings=(--set checkpoint_interval_s=0 --set stages.0.duration_s=0.03 --set record.walls=sampled)
declare -rA signal_points=([start]=sim:send:1 [mid]=sim:rename:2 [last_flush]=recorder:log:3
    [start_in_one]=sim:write:1 [mid_in_one]=sim:rename:2 [last_flush_in_one]=sim:log:3)

is_stopped() { # PID
    grep -q '^State:.T' "/proc/$1/status" 2>/dev/null
}

# Waits until a process of that name has stopped itself; sets `stopped`.
await_stop() { # NAME
    local k
    for ((k = 0; k < settle_after_s * 100; k++)); do
        stopped=$(process "$1")
        [ -z "$stopped" ] || ! is_stopped "$stopped" || return 0
        driver_is_there || return
        sleep 0.01
    done
    return 1
}

# Sets `receivers` to process ids. A process that has not become its program yet is waited for; at the last flush the
# controller may have ended.
find_receivers() { # RECEIVER MOMENT
    local name names=() k pid tries=500
    [ "$2" != last_flush ] || tries=1
    receivers=()
    case $1 in
        driver*) ;;
        sim*) names=(sim) ;;
        all_in_one) names=(sim) ;;
        all) names=("${kinds_of_processes[@]}") ;;
        *) names=("$1") ;;
    esac
    case $1 in driver* | all*) receivers=("$driver") ;; esac
    for name in "${names[@]}"; do
        for ((k = 0; k < tries; k++)); do
            pid=$(process "$name")
            [ -z "$pid" ] || break
            sleep 0.01
        done
        [ -z "$pid" ] || receivers+=("$pid")
    done
    [ "${#receivers[@]}" -gt 0 ]
}

right_codes() { # SIGNAL RECEIVER MOMENT: prints the exit codes that may be. At the last flush the run may be over as well.
    case $1:$2 in
        KILL:wallctl | KILL:recorder) echo 0 ;; # started again
        KILL:*) echo 137 ;;
        *) [ "$3" = last_flush ] && echo 130 0 || echo 130 ;;
    esac
}

is_closed() {
    h5dump -a complete run/run.h5 2>/dev/null | grep -q '(0): 1'
}

# Sets `wrong` to what is not as it must be.
look_at_end() { # SIGNAL RECEIVER MOMENT
    local codes
    wrong=''
    codes=$(right_codes "$@")
    [[ " $codes " == *" $code "* ]] || wrong="exit code $code instead of $codes"
    [ "$ended_ms" -le "${settle_after_s}000" ] || wrong="took $ended_ms ms to end"
    # nobody can say it who was killed
    [[ $code = 0 || $1:$2 == KILL:driver* || $1:$2 == KILL:all* ]] ||
        [ "$(tail -n 1 last.out)" = "go on with: ./shakedown run --resume $out/run" ] || wrong='does not say how to go on'
    [ "$1" = KILL ] || [ "$3" = start ] || is_closed || wrong='the record is not closed'
    [ "$1" = KILL ] || [ "$3" = start ] || [ -e run/checkpoint.h5 ] || wrong='no checkpoint'
}

go_on_and_compare() { # FINGERPRINT
    local k
    for ((k = 0; code != 0 && k < 2; k++)); do
        start_driver --resume run
        await_driver
    done
    [ "$code" -eq 0 ] || wrong="cannot be gone on with: exit code $code"
    [ "$code" -ne 0 ] || [ "$(fingerprint run)" = "$1" ] || wrong='another record'
}

# Sets `cell`: the exit code and how long the end took.
trial_signal() { # SIGNAL RECEIVER MOMENT
    local point=${signal_points[$3]} more=() stopped receivers wrong='' start
    [[ $2 != *_in_one ]] || { point=${signal_points[$3_in_one]} && more=(--in-process); }
    rm -rf run struck.*
    FAULTS_AT=$point:STOP FAULTS_ONCE=$out/struck LD_PRELOAD=$shim \
        start_driver "$scene" "${signal_settings[@]}" "${more[@]}" --out run
    if ! await_stop "${point%%:*}"; then
        kill -KILL "$driver"
        await_driver
        flock -w "$settle_after_s" run/log true
        wrong='the moment never came'
    elif ! find_receivers "$2" "$3"; then
        kill -CONT "$stopped"
        await_driver
        cell='has ended'
        [ "$3:$code" = last_flush:0 ] || wrong='nobody to signal'
    else
        start=$(now_ms)
        kill "-$1" "${receivers[@]}"
        kill -CONT "$stopped" 2>/dev/null
        await_driver
        flock -w "$settle_after_s" run/log true # those who outlive a killed driver
        ended_ms=$(($(now_ms) - start))
        cell="$code, $((ended_ms / 1000)).$((ended_ms % 1000 / 100)) s"
        look_at_end "$@"
        cp last.out struck.out
        [ -n "$wrong" ] || go_on_and_compare "$whole_signals"
    fi
    [ -n "$wrong" ] || return 0
    cell+=' BAD'
    echo "faults: $*: $wrong" >&3
    tail -n 20 struck.out last.out >&3
    return 1
}

wanted_signal() { # SIGNAL:RECEIVER:MOMENT
    local pattern patterns
    read -ra patterns <<<"${given[--kinds]:-*}"
    for pattern in "${patterns[@]}"; do
        # shellcheck disable=SC2053 # a pattern is meant
        [[ $1 != $pattern ]] || return 0
    done
    return 1
}

signals_table() {
    local signal receiver moment cell row failures=0 tried=0
    start_driver "$scene" "${signal_settings[@]}" --out whole
    await_driver
    [ "$code" -eq 0 ] || { cat last.out && return 1; }
    whole_signals=$(fingerprint whole)
    printf '%-22s %14s %14s %14s\n' 'signal to' "${signal_moments[@]}"
    for signal in "${signal_names[@]}"; do
        for receiver in "${signal_receivers[@]}"; do
            row=()
            for moment in "${signal_moments[@]}"; do
                cell=-
                if wanted_signal "$signal:$receiver:$moment"; then
                    tried=$((tried + 1))
                    trial_signal "$signal" "$receiver" "$moment" || failures=$((failures + 1))
                fi
                row+=("$cell")
            done
            [ "${row[*]}" = '- - -' ] || printf '%-22s %14s %14s %14s\n' "$signal $receiver" "${row[@]}"
        done
    done
    echo "$tried tried, $failures bad"
    [ "$failures" -eq 0 ] && [ "$tried" -gt 0 ]
}
