#!/usr/bin/env bash
# Programs that know nothing of seals listen to an open run: lcm-logger, and decoders that lcm-gen makes for Python, read
# its sealed messages as they are. In a network namespace of its own. Usage: test_open_readers.sh SCENE LCMTYPES
set -uo pipefail
root=$(readlink -f "${BASH_SOURCE[0]%/*}/..")
[ -n "${TEST_NAMESPACE:-}" ] || TEST_NAMESPACE=1 exec "$root/tests/in_namespace.sh" "$BASH" "${BASH_SOURCE[0]}" "$@"
for program in lcm-logger lcm-gen python3; do
    command -v "$program" >/dev/null || { echo "SKIPPED: no $program" && exit 125; }
done
scene=$1 types=$2
work=$(mktemp -d)
logger=''
trap '[ -z "$logger" ] || kill "$logger" 2>/dev/null; rm -rf "$work"' EXIT
cd "$work" || exit 1

fail() {
    echo "FAILED: $*"
    tail -n 20 said logged
    exit 1
}

export LCM_DEFAULT_URL='udpm://239.255.76.67:7999?ttl=0'
lcm-gen -p --ppath "$work" "$types"/sample_t.lcm "$types"/end_t.lcm || fail "lcm-gen"
lcm-logger --lcm-url="$LCM_DEFAULT_URL" all.lcm >logged 2>&1 &
logger=$!
for ((k = 0; k < 500; k++)); do
    grep -q ':1F3F ' /proc/net/udp && break # it has bound port 7999
    sleep 0.01
done
"$root/shakedown" run "$scene" --out run >said 2>&1 || fail "the run"
[ -s run/key ] || fail "an open run without a key"
unset LCM_DEFAULT_URL

# END comes until it is acknowledged, and the logger writes as it hears.
cat >read.py <<'PYTHON'
import struct, sys
sys.path.insert(0, ".")
from shakedown import sample_t, end_t

def events(path):
    data = open(path, "rb").read()
    at = 0
    while at + 28 <= len(data):
        sync, number, time_us, name, size = struct.unpack(">IqqII", data[at:at + 28])
        assert sync == 0xEDA1DA01
        at += 28
        if at + name + size > len(data):
            break
        yield data[at:at + name].decode(), data[at + name:at + name + size]
        at += name + size

samples, ends, sealed = {}, 0, 0
for channel, data in events("all.lcm"):
    kind = {"SAMPLE": sample_t, "END": end_t}.get(channel)
    if not kind:
        continue
    message = kind.decode(data)
    sealed += len(data) - len(message.encode()) == 16
    if channel == "SAMPLE":
        samples[message.seq] = message.strain
    else:
        ends += 1
print("ends", ends, "sealed", sealed, "samples", len(samples))
assert ends >= 1 and sealed >= len(samples) + 1
# Each sample that was heard has the numbers of its row in run.h5. A listener on a busy machine misses many.
numbers = [float(word) for word in open("h5.txt")]
rows = len(numbers) // 2
assert max(samples) < rows and len(samples) >= 20
assert all(list(strain) == numbers[2 * seq:2 * seq + 2] for seq, strain in samples.items())
PYTHON
for ((k = 0; k < 500; k++)); do
    grep -aq END all.lcm && break
    sleep 0.01
done
kill "$logger" && wait "$logger"
logger=''
h5dump -y -w 0 -m %.17g -d /samples/strain/value run/run.h5 | sed -n '/DATA {/,/}/p' | grep -oE -- '-?[0-9][-+.e0-9]*' >h5.txt
python3 read.py >>said 2>&1 || fail "python"
tail -n 1 said
