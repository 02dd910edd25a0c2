#!/usr/bin/env bash
# test_includes.sh ROOT: the arrows between our files run one way (docs/design.md): between the rooms of the simulator,
# between the folders of the tree, and without a circle between modules (a .c file and its header are one).
set -uo pipefail
root=$1
cd "$root" || exit 1

# A room includes itself and those before it.
rooms=(base lanes law grains contacts neighbours kernels sample measure run)

# What a folder includes beside itself; the programs of bench/, studies/ and tests/ may look at everything.
declare -A allowed=([common]="" [wallctl]="common/" [sim]="common/ wallctl/control_law.h" [recorder]="common/"
    [analyzer]="common/" [launcher]="common/" [export]="common/")

failed=0
complain() {
    echo "$*"
    failed=1
}

# FILE INCLUDED, for all includes of our own files by their path.
folders=(common sim wallctl recorder analyzer launcher)
[ ! -d export ] || folders+=(export)
includes=$(grep -roE --include='*.[ch]' '^#include "[a-z_]+/[A-Za-z0-9_/]+\.h"' "${folders[@]}" |
    sed -E 's/^([^:]+):#include "([^"]+)"$/\1 \2/')
[ -n "$includes" ] || complain "no includes found below $root"

room_index() {
    local k
    for k in "${!rooms[@]}"; do
        [ "${rooms[$k]}" = "$1" ] && echo "$k" && return
    done
    echo -1
}

check_rooms() {
    local file included from to
    while read -r file included; do
        from=$(room_index "$(cut -d/ -f2 <<<"$file")")
        to=$(room_index "$(cut -d/ -f2 <<<"$included")")
        [ "$file" = sim/main.c ] && continue
        [ "$from" -ge 0 ] || complain "$file is in no room of sim/"
        [ "$to" -ge 0 ] || complain "$file includes $included, which is in no room of sim/"
        [ "$to" -le "$from" ] || complain "$file includes $included: ${rooms[$from]} comes before ${rooms[$to]}"
    done < <(grep -E '^sim/[^ ]* sim/' <<<"$includes" | sort -u -t/ -k2,2 -k3)
}

check_folders() {
    local file included from to prefix fits
    while read -r file included; do
        from=${file%%/*}
        to=${included%%/*}
        [ "$from" != "$to" ] || continue
        fits=
        for prefix in ${allowed[$from]}; do
            [[ $included == "$prefix"* ]] && fits=1
        done
        [ -n "$fits" ] || complain "$file includes $included, which $from/ does not know"
    done <<<"$includes"
}

check_circles() {
    local circles
    circles=$(sed -E 's/\.[ch]( |$)/\1/g' <<<"$includes" | awk '$1 != $2' | sort -u | tsort 2>&1 >/dev/null | sed 's/^tsort: -: //')
    [ -z "$circles" ] || complain "modules include each other in a circle: $(tr '\n' ' ' <<<"$circles")"
}

check_rooms
check_folders
check_circles
exit "$failed"
