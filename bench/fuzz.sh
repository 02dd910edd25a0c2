#!/usr/bin/env bash
# Fuzzing with libFuzzer, address and undefined-behaviour sanitizers, in a build folder of its own (build-fuzz):
# ./shakedown bench fuzz [TARGET]... [--minutes N]
# Targets: message event_log scene run_file checkpoint (default: all). N (default 1) is for each. What it finds is kept
# below build-fuzz/found; the inputs that reached something new, below build-fuzz/corpus, serve the next time.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"

minutes=1
targets=()
while [ $# -gt 0 ]; do
    case $1 in
        --minutes)
            [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || bench_usage "--minutes wants a whole number"
            minutes=$2
            shift
            ;;
        message | event_log | scene | run_file | checkpoint) targets+=("$1") ;;
        *) bench_usage "there is no target $1: message, event_log, scene, run_file, checkpoint" ;;
    esac
    shift
done
[ "${#targets[@]}" -gt 0 ] || targets=(message event_log scene run_file checkpoint)
command -v clang >/dev/null || bench_usage "clang is missing; as root: apt-get install clang"

fuzz=$root/build-fuzz
programs=("${targets[@]/#/fuzz_}")
programs=("${programs[@]/%/_fuzzer}")
mkdir -p "$fuzz"
exec 9>"$fuzz/lock"
flock 9 # targets may be fuzzed side by side, but built one after the other
cmake -S "$root" --preset fuzz >"$fuzz/build.log" 2>&1 || { cat "$fuzz/build.log" && exit 1; }
cmake --build "$fuzz" --target fuzz_seeds "${programs[@]}" >>"$fuzz/build.log" 2>&1 ||
    { tail -n 40 "$fuzz/build.log" && exit 1; }
mkdir -p "$fuzz/found" "$fuzz/corpus"
"$fuzz/tests/fuzz_seeds" "$fuzz/seeds"
mkdir -p "$fuzz/seeds/scene"
cp "$root"/scenes/*.cfg "$root"/tests/scenes/*.cfg "$fuzz/seeds/scene"
if [[ " ${targets[*]} " == *" checkpoint "* ]]; then
    rm -f "$fuzz/checkpoint.h5"
    "$bin/sim/sim" "$root/tests/scenes/small.cfg" --in-process --checkpoint "$fuzz/checkpoint.h5" >/dev/null
fi
exec 9>&-
export FUZZ_CHECKPOINT=$fuzz/checkpoint.h5
export LSAN_OPTIONS=suppressions=$root/tests/fuzz/leaks.supp:print_suppressions=0
failed=0
for target in "${targets[@]}"; do
    corpus=$fuzz/corpus/$target found=$fuzz/found/$target
    mkdir -p "$corpus" "$found"
    # Large extents are claimed on purpose: an allocation that fails is an answer, not a fault. A busy machine, or one
    # that suspends this, is no hang: hence ten minutes.
    if ASAN_OPTIONS=allocator_may_return_null=1:detect_leaks=1 "$fuzz/tests/fuzz_${target}_fuzzer" "$corpus" \
        "$fuzz/seeds/$target" "-max_total_time=$((60 * minutes))" -max_len=16384 -timeout=600 -rss_limit_mb=3000 \
        "-artifact_prefix=$found/" -print_final_stats=1 >"$found.log" 2>&1; then
        result='nothing found'
    else
        result="FOUND SOMETHING: $found.log" failed=1
    fi
    printf '%-10s %3d min %12s inputs %6s kept   %s\n' "$target" "$minutes" \
        "$(sed -n 's/^stat::number_of_executed_units: *//p' "$found.log")" "$(find "$corpus" -type f | wc -l)" "$result"
done
exit $failed
