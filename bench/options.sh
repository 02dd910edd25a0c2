# shellcheck shell=bash
# What the scripts beside share; to be sourced. Sets `root` and `bin`.
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
# shellcheck disable=SC2034 # they use it
bin=${SHAKEDOWN_BIN:-$root/build}

bench_usage() { # WHAT
    local name=${0##*/}
    echo "bench ${name%.sh}: $1" >&2
    exit 2
}

declare -A given=() # the script's own options and their values
options=()          # those that are passed on, with theirs

# Sorts the arguments into `given` and `options`; "--name=value" is "--name value". OWN are names of either kind that go
# to `given`, a flag with the value 1. Ends the script with exit code 2 on what is unknown.
read_options() { # FLAGS OPTIONS-WITH-VALUE OWN ARGUMENTS...
    local flags=" $1 " valued=" $2 " own=" $3 " name words
    shift 3
    while [ $# -gt 0 ]; do
        name=${1%%=*}
        if [[ $valued == *" $name "* ]]; then
            [ "$1" = "$name" ] || set -- "$name" "${1#*=}" "${@:2}"
            [ $# -ge 2 ] || bench_usage "$name needs a value"
            words=("$name" "$2")
        elif [[ $flags == *" $1 "* ]]; then
            words=("$name")
        else
            bench_usage "unknown option $1; see the head of $0"
        fi
        shift "${#words[@]}"
        if [[ $own == *" $name "* ]]; then
            given[$name]=${words[1]:-1}
        else
            options+=("${words[@]}")
        fi
    done
}

# Sets `out` to the folder of --out, or to one for this time.
take_out() {
    out=${given[--out]:-}
    if [ -z "$out" ]; then
        out=$(mktemp -d)
        trap 'rm -rf "$out"' EXIT
    fi
}
