# shellcheck shell=bash
# shellcheck disable=SC2154,SC2034 # variables of the driver
# Sourced by the driver: a network of its own for a run, or on a shared one a port that no other run has. Uses the driver's
# die, can_write, status_bus and status_io.

has_multicast_route() {
    ip route get 239.255.76.67 >/dev/null 2>&1
}

# As root without, else with a user namespace around it. Sets `unshare_net`, the words before a command; fails where
# neither is allowed.
find_private_network() {
    unshare_net=(unshare --net --)
    [ "$(id -u)" -eq 0 ] && "${unshare_net[@]}" true >/dev/null 2>&1 && return
    unshare_net=(unshare --map-root-user --net --)
    "${unshare_net[@]}" true >/dev/null 2>&1
}

open_private_network() {
    if ! { ip link set lo up && ip route add 224.0.0.0/4 dev lo; }; then
        die "$status_bus" "cannot set up the private network"
    fi
}

port_is_bound() { # PORT
    local hex
    printf -v hex '%04X' "$1"
    grep -q "^ *[0-9]*: [0-9A-F]*:$hex " /proc/net/udp
}

# Sets `locks`, a folder that nobody else can write to.
choose_locks() {
    for locks in "${XDG_RUNTIME_DIR:-}" "${TMPDIR:-/tmp}/shakedown-$UID" "${XDG_CACHE_HOME:-${HOME:-}/.cache}/shakedown"; do
        [ -n "$locks" ] || continue
        mkdir -p -- "${locks%/*}" 2>/dev/null && mkdir -m 700 -- "$locks" 2>/dev/null
        [ ! -L "$locks" ] && [ -O "$locks" ] && can_write "$locks" && return
    done
    die "$status_io" "no folder of your own for lock files: set XDG_RUNTIME_DIR to one"
}

# Sets `port`. The lock is inherited by the processes of the run, so it lasts as long as any of them: LCM's sockets
# share their port with whoever asks, so binding alone would not tell.
take_port() {
    local lock
    choose_locks
    for port in {7668..7967}; do
        { exec {lock}<>"$locks/shakedown-port-$port.lock"; } 2>/dev/null || continue
        flock -n "$lock" && ! port_is_bound "$port" && return
        exec {lock}>&-
    done
    die "$status_bus" "no free port from 7668 to 7967"
}

# Sets `url`.
choose_url() {
    if [ -n "${LCM_DEFAULT_URL:-}" ]; then
        url=$LCM_DEFAULT_URL
        return
    fi
    port=7668
    [ -n "${SHAKEDOWN_NAMESPACE:-}" ] || take_port # nobody else is in a private network
    url="udpm://239.255.76.67:$port?ttl=0"
}
