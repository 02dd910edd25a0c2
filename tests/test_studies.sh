#!/usr/bin/env bash
# Whole studies with the real programs (SHAKEDOWN_BIN) on a small scene: test_studies.sh CASE.
set -uo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=$(mktemp -d)
cd "$work" || exit 1
trap 'rm -rf "$work"' EXIT

fail() {
    echo "FAILED at line ${BASH_LINENO[0]}: $*"
    tail -n 30 ./*.out 2>/dev/null
    exit 1
}

study() { # OUTPUT ARGUMENTS...
    local output=$1
    shift
    "$root/shakedown" study small.cfg --jobs 2 "$@" >"$output" 2>&1 </dev/null
}

# Four runs of a tenth of a second, two preparations.
write_small() {
    cat >small.cfg <<TEXT
name = "small";
title = "A <small> study & its report";
scene = "$root/scenes/quick.cfg";
set = [ "coupling.interval_steps=1", "sample.count=100", "stages.0.material.kc_n_per_m=0.0", "stages.2.sample_interval_s=5e-5" ];
prepare = "ring";
seeds = 2;
vary = ( { name = "kc"; label = "k_c"; unit = "N/m"; keys = [ "material.kc_n_per_m" ]; values = [ 0.0, 1e5 ]; } );
quantities = [ "peak.sigma_corr_pa", "initial.phi" ];
paper = ( { quantity = "initial.phi"; where = { kc = 0.0; }; value = 0.8; source = "nowhere"; } );
figures = (
  { kind = "curves"; name = "stress"; title = "stress"; x = "eps_zz"; y = "sigma_zz_pa"; },
  { kind = "points"; name = "phi"; title = "solid fraction"; x = "kc"; y = "initial.phi"; }
);
TEXT
}

# The study files that come with the program can be read, and their scenes too.
case_shipped() {
    local file
    for file in "$root"/studies/*.cfg; do
        "$root/shakedown" study "$(basename "$file" .cfg)" --list --out "$work/$(basename "$file" .cfg)" >list.out 2>&1 ||
            fail "$file"
        grep -q '^[1-9][0-9]* runs' list.out || fail "$file has no runs"
    done
    "$root/shakedown" study no-such-study >list.out 2>&1 && fail "a study that is not there"
    grep -q 'there is no study no-such-study' list.out || fail "no word of it"
}

case_report() {
    local file
    write_small
    study first.out --out s || fail "exit code $?"
    for file in report.html results.json runs.csv cells.csv comparison.csv figures/{stress,phi}.{svg,pdf,png,csv,gp}; do
        [ -s "s/$file" ] || fail "no $file"
    done
    [ "$(grep -o '<svg role="img" aria-label="' s/report.html | wc -l)" -eq 2 ] || fail "two figures with texts"
    grep -q 'A &lt;small&gt; study &amp; its report' s/report.html || fail "the title is not escaped"
    grep -qE '[0-9] are sound by the verdict of their analysis, [0-9] doubtful' s/report.html || fail "no verdicts"
    grep -qE '<td>(sound|doubtful|failed)</td>' s/report.html || fail "no verdict of a run"
    ! grep -qE '(src|href)="(https?:|/|\.)' s/report.html || fail "the report needs other files"
    [ "$(find s/prepared -name 'prepared.h5' | wc -l)" -eq 2 ] || fail "two preparations"
    grep -q '2 of 2\|4 of 4 done' first.out || fail "no progress"
    # again: nothing is run, the same report
    cp s/report.html before.html
    study second.out --out s || fail "exit code $?"
    ! grep -q running second.out || fail "something ran again"
    cmp before.html s/report.html || fail "another report"
    # a scene of the study alone gives the same analysis, so that a run can be looked at
    "$root/shakedown" analyze --no-plots s/runs/kc_0-seed1 >alone.out 2>&1 || fail "analyze"
}

# Contact networks and particles of each cell, and in 3D spheres where there is POV-Ray.
case_pictures() {
    local file count=0
    write_small
    study first.out --out s --pictures || fail "exit code $?"
    for file in s/pictures/kc_{0,100000}-seed1-{start,end}-{network,particles}.{png,svg}; do
        [ "$(stat -c %s "$file")" -gt 3000 ] || fail "$file"
    done
    [ "$(grep -o '<img alt="contact network[^"]*"' s/report.html | wc -l)" -eq 6 ] || fail "six networks in the page"
    # as many lines as there are contacts: each is a path of its own
    for file in s/pictures/kc_0-seed1-{start,end}-network.svg; do
        count=$(grep -c 'stroke-linecap:round' "$file")
        [ "$count" -gt 150 ] && [ "$count" -lt 400 ] || fail "$count contacts of 100 particles"
    done
    sed -i 's|scenes/quick.cfg|scenes/triaxial_quick.cfg|; /^set/,/];/d; /prepare/d; /vary/d; /paper/d; /figures/,$d; s/seeds = 2/seeds = 1/' small.cfg
    echo 'set = [ "sample.count=64", "stages.0.duration_s=0.02", "stages.0.until_stress_error=0.0", "stages.1.duration_s=0.02", "stages.2.duration_s=0.02", "stages.2.cut_path=true" ];' >>small.cfg
    study third.out --out s3 --pictures || fail "exit code $?"
    if command -v povray >/dev/null; then
        [ "$(stat -c %s s3/pictures/seed1-end-spheres.png)" -gt 3000 ] || fail "no spheres"
    else
        echo "POV-Ray is not installed: spheres are not tested"
        grep -q 'POV-Ray, which is not installed' s3/report.html || fail "no word of it"
    fi
}

# In a real browser, without a network: no word in its console, every figure there and of a size, with its text.
case_browser() {
    local browser=()
    command -v chromium >/dev/null || { echo "SKIPPED: chromium is not installed"; exit 125; }
    write_small
    study first.out --out s || fail "exit code $?"
    cat >look.html <<'TEXT'
<!DOCTYPE html><meta charset="utf-8"><title>look</title><iframe src="s/report.html" width="1000" height="800"></iframe><pre></pre>
<script>
onload = () => {
    const page = document.querySelector('iframe').contentDocument;
    const figures = [...page.querySelectorAll('figure > svg[role=img]')].filter(svg => {
        const box = svg.getBoundingClientRect();
        return box.width > 300 && box.height > 200 && svg.querySelectorAll('path').length > 10 && svg.getAttribute('aria-label');
    });
    const ids = [...page.querySelectorAll('[id]')].map(e => e.id);
    const absent = [...page.querySelectorAll('use')].filter(e => !page.getElementById((e.getAttribute('xlink:href') || '#').slice(1)));
    document.querySelector('pre').textContent = `figures ${figures.length}, repeated ids ${ids.length - new Set(ids).size}, `
        + `uses of nothing ${absent.length}, tables ${page.querySelectorAll('table').length}`;
};
</script>
TEXT
    [ "$(id -u)" -ne 0 ] || browser=(--no-sandbox)
    HOME=$work "$root/tests/in_namespace.sh" timeout 60 chromium --headless "${browser[@]}" --disable-gpu \
        --user-data-dir="$work/profile" --allow-file-access-from-files --enable-logging=stderr --virtual-time-budget=5000 \
        --dump-dom "file://$work/look.html" >dom.out 2>browser.out || fail "chromium"
    ! grep CONSOLE browser.out || fail "words in the console"
    grep -q 'figures 2, repeated ids 0, uses of nothing 0, tables 3' dom.out || fail "the page"
}

# Killed with -9 at stated points (bench/fault_shim.c), the study goes on and gives the report of one that was not: while
# the runs are written down, at work in sim, at work in the recorder, while the report is written.
case_killed() {
    local point
    write_small
    study whole.out --out whole || fail "exit code $?"
    for point in study:rename:3:KILL sim:write:1:STOP recorder:rename:1:STOP study:rename:5:KILL; do
        rm -f struck.0
        FAULTS_AT=$point FAULTS_ONCE=$work/struck LD_PRELOAD=$SHAKEDOWN_BIN/bench/fault_shim.so \
            ASAN_OPTIONS=${ASAN_OPTIONS:-}:verify_asan_link_order=0 \
            "$root/shakedown" study small.cfg --jobs 2 --out s >killed.out 2>&1 </dev/null &
        wait_for_strike $!
        kill -KILL $! 2>/dev/null
        wait $! 2>/dev/null
    done
    study last.out --out s || fail "exit code $?"
    cmp whole/report.html s/report.html || fail "another report"
    cmp whole/results.json s/results.json || fail "other results"
}

wait_for_strike() { # PID
    local k runs
    for ((k = 0; k < 6000; k++)); do
        runs=
        [ ! -d "/proc/$1" ] || runs=1
        [ ! -e struck.0 ] || return
        [ -n "$runs" ] || fail "$point was never reached"
        sleep 0.01
    done
    fail "$point: waited in vain"
}

# Levels ranked by their distance from published numbers: (mean - paper)/tolerance of the one that there is.
case_score() {
    local mean
    write_small
    echo 'score = "kc";' >>small.cfg
    sed -i 's/where = { kc = 0.0; }; value = 0.8;/value = 0.8; tolerance = 0.1;/' small.cfg
    study first.out --out s || fail "exit code $?"
    mean=$(grep '"k_c = 0 N/m",initial.phi' s/cells.csv | cut -d, -f5)
    awk -v mean="$mean" -v score="$(sed -n '/"scores"/,/}/s/.*"0": \([0-9.]*\).*/\1/p' s/results.json)" \
        'BEGIN { off = (mean - 0.8)/0.1 - score; exit !(mean > 0.5 && off < 1e-6 && off > -1e-6) }' || fail "the score"
    grep -q 'id="score"' s/report.html || fail "no map"
}

# Other settings never show old numbers.
case_changed() {
    write_small
    study first.out --out s || fail "exit code $?"
    cp s/cells.csv before.csv
    study second.out --out s --set 'material.gamma_b_kg_per_s=0.02' --report
    [ $? -eq 9 ] || fail "the report of other settings"
    grep -q '4 of 4 runs failed' second.out || fail "old runs count"
    study third.out --out s --set 'material.gamma_b_kg_per_s=0.02' || fail "exit code $?"
    ! cmp -s before.csv s/cells.csv || fail "old numbers"
    study fourth.out --out s || fail "exit code $?"
    cmp before.csv s/cells.csv || fail "the first settings give other numbers than before"
}

# A run that fails is tried once more, then listed; the others are reported.
case_failing() {
    write_small
    mkdir bin && ln -s "$SHAKEDOWN_BIN"/* bin/ && rm bin/sim && mkdir bin/sim
    cat >bin/sim/sim <<TEXT
#!/bin/sh
case \$PWD in */kc_100000-seed2) echo "I shall not"; exit 1 ;; esac
exec "$SHAKEDOWN_BIN/sim/sim" "\$@"
TEXT
    chmod +x bin/sim/sim
    SHAKEDOWN_BIN=$work/bin study first.out --out s
    [ $? -eq 9 ] || fail "a failed run is no success"
    grep -q 'kc_100000-seed2 failed, once more: .*not complete' first.out || fail "not tried again"
    grep -q 'kc_100000-seed2 failed again' first.out || fail "not listed"
    grep -q 'I shall not' first.out || fail "not its words"
    grep -q '3 of 4 runs are in this report' s/report.html || fail "the report does not say so"
    study second.out --out s || fail "exit code $?"
    grep -q '4 of 4 runs are in this report' s/report.html || fail "not mended"
}

"case_$1"
