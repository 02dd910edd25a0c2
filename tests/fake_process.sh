#!/usr/bin/env bash
# Stands for every process of a run in the tests of the driver. What it does is said by FAKE_SIM, FAKE_WALLCTL,
# FAKE_RECORDER: ok (default), fail (exit code 10 and a message), wait (until SIGINT), hang (no signal changes anything).
# The pipe FAKE_PIPE stands for the bus: its one message is sim's END, for the recorder, which acknowledges it in
# FAKE_PIPE.ack. FAKE_PIPE.walls: wallctl's answer.
trap 'exit 130' INT HUP # at once: bash loses one that comes during a command
name=${0##* } # "my wallctl" is a controller of the user's own
name=${name##*/}
arguments=("$@")

argument_after() { # OPTION
    local k
    for k in "${!arguments[@]}"; do
        [ "${arguments[k]}" != "$1" ] || echo "${arguments[k + 1]}"
    done
}

# Until SIGINT or a line in the pipe; bounded, so that a failed test leaves nothing behind. In short pieces: bash hears a
# signal that comes just before `read` waits only after it.
stay() { # PIPE
    local k
    exec {pipe}<>"$1"
    for ((k = 0; k < 240; k++)); do
        read -r -t 0.25 -u "$pipe" _ && return
    done
}

say_end() {
    echo end >"$FAKE_PIPE"
}

check_scene() {
    grep -n broken "$1" >/dev/null || exit 0
    echo "sim: error: $1:$(grep -n broken "$1" | cut -d: -f1): broken: unknown key" >&2
    exit 3
}

case " $* " in *" --check "*) check_scene "$1" ;; esac
variable=FAKE_${name^^}
behaviour=${!variable:-ok}
echo "$name $*"
echo "namespace $(readlink /proc/self/ns/net)"
[ "$name" != recorder ] || echo fake >"$(argument_after --out)/run.h5"

silence=$FAKE_PIPE.silence # nobody writes to it
case $behaviour in
    fail)
        echo "$name: error: it was told to" >&2
        exit 10
        ;;
    hang)
        trap '' INT TERM
        stay "$silence"
        exit 0
        ;;
esac
case $name in
    sim)
        trap 'say_end; exit 130' INT TERM HUP
        stay "$FAKE_PIPE.walls" # until wallctl answers
        [ "$behaviour" = ok ] || stay "$silence"
        say_end
        stay "$FAKE_PIPE.ack"
        ;;
    wallctl)
        trap 'exit 130' TERM
        echo here >"$FAKE_PIPE.walls"
        stay "$silence"
        ;;
    recorder)
        stay "$FAKE_PIPE"
        trap '' TERM # sim has ended: so does it
        echo complete >"$FAKE_PIPE.ack"
        ;;
    analyzer)
        echo "a table of $1"
        ;;
esac
exit 0
