#!/usr/bin/env bash
# Do the tests notice faults? ./shakedown bench mutants [--only MODULE] [--again] [--at-most N]
# Each line of bench/mutants.txt is a one-line fault in recorder, analyzer, common or wallctl. It is put into a copy of the
# tree (build-mutants/source), the programs of that module's quick tests are built, and the tests are run: a fault that
# none of them notices is alive, and is listed. What was tried is kept (build-mutants/tried.txt) and is not tried again
# unless the line has changed, or with --again; --at-most: no more than N this time. Exit code 1 if more than 3 are alive.
set -euo pipefail
# shellcheck source=options.sh
. "${BASH_SOURCE[0]%/*}/options.sh"
read_options '--again' '--only --at-most' '--again --only --at-most' "$@"

scratch=$root/build-mutants source=$root/build-mutants/source
list=$root/bench/mutants.txt tried=$scratch/tried.txt

# Quick tests of a module, and the programs that they need.
declare -A tests=(
    [recorder]='recorder|recorder_log|record_proof|checkpoint_kill_after_end|fuzz_seeds|fuzz_seed_checkpoint|fuzz_run_file|export|recorder_fault'
    [analyzer]='analyzer_.*|fuzz_seeds|fuzz_seed_checkpoint|fuzz_run_file'
    [common]='scene|sim_bad_scenes|bus|recorder|recorder_log|record_proof|law|sim_unit|judge|fuzz_seeds|fuzz_seed_checkpoint|fuzz_message|fuzz_event_log|fuzz_scene'
    [wallctl]='law|wall_command|command_check')
declare -A programs=(
    [recorder]='programs fault_shim test_record_proof test_recorder test_recorder_log test_recorder_fault fuzz_run_file_corpus fuzz_seeds'
    [analyzer]='analyzer fuzz_run_file_corpus fuzz_seeds sim'
    [common]='test_scene test_bus recorder test_recorder test_recorder_log test_record_proof test_law test_sim_unit test_judge sim fuzz_message_corpus fuzz_event_log_corpus fuzz_scene_corpus fuzz_seeds'
    [wallctl]='test_law test_wall_command test_command_check')

copy_tree() {
    mkdir -p "$source"
    (cd "$root" && git ls-files -z --cached --others --exclude-standard | tar --null -cf - -T -) | tar -xf - -C "$source"
    # as old as it was, it would not be built again
    [ ! -e "$scratch/changed" ] || touch "$(<"$scratch/changed")"
}

build() { # TARGET...
    cmake --build "$source/build" --target "$@" >"$scratch/build.log" 2>&1
}

build_of() { # MODULE
    local names file
    read -ra names <<<"${programs[$1]}"
    for file in "$source"/tests/test_analyzer_*.c; do
        file=${file##*/}
        [ "$1" != analyzer ] || [ "$file" = test_analyzer_fixture.c ] || names+=("${file%.c}")
    done
    build "${names[@]}"
}

# Those without processes first, as they take the least time.
run_tests() { # MODULE
    local ctest=(timeout 300 ctest --test-dir "$source/build" -R "^(${tests[$1]})\$" --stop-on-failure)
    "${ctest[@]}" -L unit >"$scratch/tests.log" 2>&1 && "${ctest[@]}" -LE unit >"$scratch/tests.log" 2>&1
}

# Puts a fault in, and sets `verdict`.
try() { # FILE FROM TO
    local file=$source/$1 module=${1%%/*} text
    text=$(<"$file")
    case ${text#*"$2"} in
        "$text") verdict='not there' && return ;;
        *"$2"*) verdict='there twice' && return ;;
    esac
    echo "$file" >"$scratch/changed" # should this run be ended before it is put back
    printf '%s\n' "${text/"$2"/"$3"}" >"$file"
    if ! build_of "$module"; then
        verdict='does not compile'
    elif run_tests "$module"; then
        verdict=alive
    else
        verdict="noticed by $(sed -n 's/^[[:space:]]*[0-9]* - \([a-z_0-9]*\) (.*/\1/p' "$scratch/tests.log" | head -n 1)"
    fi
    printf '%s\n' "$text" >"$file"
}

forget_lines_that_changed() {
    local line kept=()
    while IFS= read -r line; do
        ! grep -qxF -- "${line#* => }" "$list" || kept+=("$line")
    done <"$tried"
    printf '%s\n' "${kept[@]}" | sed '/^$/d' >"$tried"
}

mkdir -p "$scratch"
copy_tree
[ -f "$source/build/build.ninja" ] || cmake -S "$source" -B "$source/build" --preset "${SHAKEDOWN_PRESET:-release}" >"$scratch/build.log" 2>&1
[ -z "${given[--again]:-}" ] || rm -f "$tried"
touch "$tried"
forget_lines_that_changed
left=${given[--at-most]:-1000}
for module in recorder analyzer common wallctl; do
    [ -z "${given[--only]:-}" ] || [ "${given[--only]}" = "$module" ] || continue
    build_of "$module" || { tail -n 40 "$scratch/build.log" && exit 1; }
    run_tests "$module" || { echo "the tests of $module fail without a fault" && tail -n 20 "$scratch/tests.log" && exit 1; }
    total=$(grep -c "^$module/" "$list") count=0
    while IFS= read -r line; do
        count=$((count + 1))
        ! grep -qF -- " => $line" "$tried" || continue
        [ "$left" -gt 0 ] || break
        left=$((left - 1))
        plain=${line//'\|'/$'\a'} # a bar that belongs to the text
        file=${plain%% | *} rest=${plain#* | }
        try "$file" "$(tr '\a' '|' <<<"${rest%% | *}")" "$(tr '\a' '|' <<<"${rest#* | }")"
        printf '%s => %s\n' "$verdict" "$line" >>"$tried"
        printf '%s %d/%d: %s: %s\n' "$module" "$count" "$total" "$file" "$verdict"
    done < <(grep "^$module/" "$list")
done
alive=$(grep -c '^alive => ' "$tried" || true)
echo "$(grep -c '^noticed' "$tried" || true) noticed, $alive alive, $(grep -cE '^(not there|there twice|does not compile)' "$tried" || true) no use," \
    "$(($(grep -c '^[a-z]*/' "$list") - $(wc -l <"$tried"))) not tried"
grep -E '^(alive|not there|there twice|does not compile) => ' "$tried" || true
[ "$alive" -le 3 ]
