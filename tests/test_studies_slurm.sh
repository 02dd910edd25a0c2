#!/usr/bin/env bash
# Studies on a real Slurm, started here on loopback in namespaces of its own: test_studies_slurm.sh CASE. Skipped (125)
# where Slurm, munge or the right to make namespaces is missing.
set -uo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

skip() {
    echo "SKIPPED: $*"
    exit 125
}

for program in slurmctld slurmd sbatch munged; do
    command -v "$program" >/dev/null || skip "$program is not installed (apt-get install slurmctld slurmd slurm-client munge)"
done
[ "$(id -u)" -eq 0 ] || skip "Slurm's daemons are tested as root"
# Network, host name, mounts and processes of its own: it sees no other Slurm, and none sees it.
namespaces=(--net --uts --mount --propagation private --pid --fork --kill-child --mount-proc)
if [ -z "${TEST_SLURM:-}" ]; then
    unshare "${namespaces[@]}" true 2>/dev/null || skip "no right to make namespaces"
    TEST_SLURM=1 exec unshare "${namespaces[@]}" "$BASH" "${BASH_SOURCE[0]}" "$@"
fi

work=$(mktemp -d)
chmod 755 "$work"
cd "$work" || exit 1
daemons=()
trap 'kill -KILL "${daemons[@]}" 2>/dev/null; rm -rf "$work"' EXIT

fail() {
    echo "FAILED at line ${BASH_LINENO[0]}: $*"
    tail -n 15 ./*.out ./*.log s/slurm/log-* 2>/dev/null
    exit 1
}

wait_for() { # COMMAND...: bounded; the daemons give no signal
    local k
    for ((k = 0; k < 300; k++)); do
        "$@" >/dev/null 2>&1 && return
        read -rt 0.1 <> <(:)
    done
    fail "waited in vain for: $*"
}

configure() {
    mkdir state spool1 spool2 munge
    dd if=/dev/urandom of=munge/key bs=1k count=1 2>/dev/null
    chmod 700 munge && chmod 400 munge/key
    cat >slurm.conf <<TEXT
ClusterName=test
SlurmctldHost=testhost(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
CryptoType=crypto/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool-%n
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd-%n.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
MpiDefault=none
SlurmdTimeout=10
SchedulerParameters=batch_sched_delay=1,sched_interval=2
NodeName=node1 NodeHostname=testhost NodeAddr=127.0.0.1 Port=17001 CPUs=1 State=UNKNOWN
NodeName=node2 NodeHostname=testhost NodeAddr=127.0.0.1 Port=17002 CPUs=1 State=UNKNOWN
PartitionName=all Nodes=node1,node2 Default=YES MaxTime=10 State=UP
TEXT
    export SLURM_CONF=$work/slurm.conf
}

start_node() { # NAME
    slurmd -D -N "$1" >>"$1.out" 2>&1 &
    daemons+=($!)
    node_pid=$!
}

start_slurm() {
    hostname testhost
    ip link set lo up
    # with nothing but lo Slurm 22.05 finds no family of addresses: one more
    ip address add 10.254.254.1/32 dev lo
    cp /etc/hosts hosts && echo "127.0.0.1 testhost" >>hosts && mount --bind hosts /etc/hosts
    configure
    munged --force --foreground --key-file="$work/munge/key" --socket="$work/munge/socket" --pid-file="$work/munge/pid" \
        --log-file="$work/munge/log" --seed-file="$work/munge/seed" >munged.out 2>&1 &
    daemons+=($!)
    wait_for [ -S munge/socket ]
    slurmctld -D >slurmctld.out 2>&1 &
    daemons+=($!)
    wait_for sinfo
    start_node node1
    start_node node2
    wait_for nodes_idle 2
}

nodes_idle() { # HOW MANY
    [ "$(sinfo -h -N -o '%N %T' | grep -c ' idle$')" -ge "$1" ]
}

write_small() { # LENGTH-OF-THE-TEST
    cat >small.cfg <<TEXT
name = "small";
scene = "$root/scenes/quick.cfg";
set = [ "coupling.interval_steps=1", "sample.count=100", "stages.0.material.kc_n_per_m=0.0", "stages.2.duration_s=$1",
        "stages.2.sample_interval_s=5e-5" ];
prepare = "ring";
seeds = 2;
vary = ( { name = "kc"; keys = [ "material.kc_n_per_m" ]; values = [ 0.0, 1e5 ]; } );
quantities = [ "peak.sigma_corr_pa", "initial.phi" ];
TEXT
}

study() { # OUTPUT ARGUMENTS...
    local output=$1
    shift
    timeout 100 "$root/shakedown" study small.cfg "$@" >"$output" 2>&1 </dev/null
}

# The same report as here; one array; again: nothing is submitted.
case_array() {
    write_small 0.01
    start_slurm
    study local.out --out l || fail "exit code $?"
    study slurm.out --out s --executor slurm --sbatch '--partition=all --time=5' || fail "exit code $?"
    cmp l/results.json s/results.json || fail "other results"
    cmp l/report.html s/report.html || fail "another report"
    [ "$(grep -c 'study: job ' slurm.out)" -eq 1 ] || fail "not one array"
    study again.out --out s --executor slurm || fail "exit code $?"
    ! grep -q 'study: job ' again.out || fail "submitted again"
}

# What fails is submitted once more and listed.
case_failing() {
    write_small 0.01
    mkdir bin && ln -s "$SHAKEDOWN_BIN"/* bin/ && rm bin/sim && mkdir bin/sim
    cat >bin/sim/sim <<TEXT
#!/bin/sh
case \$PWD in */kc_100000-seed2) echo "I shall not"; exit 1 ;; esac
exec "$SHAKEDOWN_BIN/sim/sim" "\$@"
TEXT
    chmod +x bin/sim/sim
    start_slurm
    SHAKEDOWN_BIN=$work/bin study first.out --out s --executor slurm
    [ $? -eq 9 ] || fail "a failed run is no success"
    [ "$(grep -c 'study: job ' first.out)" -eq 2 ] || fail "not two arrays"
    grep -q 'study: job [0-9]*, 1 runs' first.out || fail "more than the failed run was tried again"
    grep -q 'kc_100000-seed2 failed again' first.out || fail "not listed"
    grep -q '3 of 4 runs are in this report' s/report.html || fail "the report does not say so"
}

# A node dies with its jobs, the study itself is killed: no result is lost or different.
case_killed() {
    local pid second
    write_small 0.2
    start_slurm
    second=$node_pid
    study local.out --out l || fail "exit code $?"
    "$root/shakedown" study small.cfg --out s --executor slurm >killed.out 2>&1 </dev/null &
    pid=$!
    wait_for running_on node2
    kill -KILL "$second" # and what runs there
    kill_jobs node2
    kill -KILL "$pid"
    wait "$pid" 2>/dev/null
    start_node node2
    study last.out --out s --executor slurm || fail "exit code $?"
    cmp l/results.json s/results.json || fail "other results"
    cmp l/report.html s/report.html || fail "another report"
}

running_on() { # NODE
    [ -n "$(squeue -h -t R -w "$1" -o %i)" ]
}

# Ends the processes of jobs on a node; there are only ours here.
kill_jobs() { # NODE
    local file
    while read -r file; do
        file=${file#/proc/}
        kill -KILL "${file%/environ}" 2>/dev/null
    done < <(grep -lsz "^SLURMD_NODENAME=$1$" /proc/[0-9]*/environ)
}

"case_$1"
