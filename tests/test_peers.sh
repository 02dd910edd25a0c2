#!/usr/bin/env bash
# ./shakedown bench peers without the peers: it says what to do and fails, or installs them; it refuses what it does not
# know.
set -uo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
script=$root/bench/peers.sh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
empty=$work/empty
mkdir "$empty" "$work/bin" "$work/bin/bench" "$work/tmp"
for program in bash readlink env; do
    ln -s "$(type -P "$program")" "$empty/$program"
done
failures=0

expect() { # CODE TEXT COMMAND...
    local code=$1 text=$2 said got
    shift 2
    said=$("$@" 2>&1)
    got=$?
    if [ "$got" -ne "$code" ] || ! grep -q -- "$text" <<<"$said"; then
        echo "$*: exit code $got instead of $code, or no \"$text\" in: $said"
        failures=$((failures + 1))
    fi
}

fake() { # FILE LINE...
    printf '#!%s\n' "$(type -P bash)" >"$1"
    printf '%s\n' "${@:2}" >>"$1"
    chmod +x "$1"
}

bench() { # OPTIONS...: where nothing is installed but what was put into $empty
    env PATH="$empty" SHAKEDOWN_BIN="$work/bin" TMPDIR="$work/tmp" bash "$script" "$@"
}

expect 1 'not installed: lammps liggghts' bench
expect 1 'bench peers --install' bench --reps 1
expect 1 'no apt-get here' bench --install

# An installer that puts the programs there, and one that does not.
fake "$empty/apt-get" "echo \"apt-get \$*\" >>'$work/said'" "[ \"\$2\" = install ] || exit 1" \
    "for package; do case \$package in lammps) package=lmp ;; liggghts) ;; *) continue ;; esac" \
    "    [ -n \"\${BROKEN:-}\" ] || $(type -P ln) -s '$(type -P true)' '$empty/'\$package" "done" \
    "[ \"\${BROKEN:-}\" != fails ]"
fake "$empty/id" 'echo 1000'
expect 1 'no sudo; as root: apt-get install lammps liggghts' bench --install
fake "$empty/sudo" "echo sudo >>'$work/said'" 'exec "$@"'
BROKEN=fails expect 1 'apt-get failed; as root' bench --install
BROKEN=quiet expect 1 'still not in PATH: lammps liggghts' bench --install
fake "$work/bin/bench/bench_peers" "echo \"bench_peers \$*\""
rm -f "$work/said"
ln -s "$(type -P mktemp)" "$(type -P rm)" "$empty"
expect 0 "bench_peers --bin $work/bin --root $root --out $work/tmp/.* --reps 1" bench --install --reps 1
expect 0 '^sudo$' cat "$work/said"
expect 0 'install -y --no-install-recommends lammps liggghts$' cat "$work/said"
[ -z "$(ls -A "$work/tmp")" ] || expect 0 'nothing left' ls -A "$work/tmp"

# With them there, nothing is installed; with one of them, it is the other.
rm "$work/said" "$empty/id"
expect 0 'out kept --json a b' bench --install --out kept --json "a b"
expect 2 '' ls "$work/said"
rm "$empty/liggghts"
expect 1 'not installed: liggghts' bench
ln -s "$(type -P id)" "$empty"
expect 0 'bench_peers' bench --install
expect 0 'recommends liggghts$' cat "$work/said"

expect 2 'bench peers: unknown option --nonsense' bash "$script" --nonsense
expect 2 'unknown option --install=yes' bash "$script" --install=yes
expect 2 'needs a value' bash "$script" --scene
[ "$failures" -eq 0 ]
