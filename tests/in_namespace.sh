#!/bin/sh
# Runs a command in a network namespace of its own with loopback multicast: it disturbs nobody and nobody disturbs it.
# Works for root and, where user namespaces are allowed, for everyone else. Exit code: the command's, or 125.
set -u

if [ $# -eq 0 ]; then
    echo "usage: $0 command [argument]..." >&2
    exit 125
fi

inside='ip link set lo up && ip route add 224.0.0.0/4 dev lo || {
    echo "in_namespace: cannot set up loopback multicast (is iproute2 installed?)" >&2
    exit 125
}
exec "$@"'

if [ "$(id -u)" -eq 0 ] && unshare --net true 2>/dev/null; then
    exec unshare --net sh -c "$inside" in_namespace "$@"
fi
if unshare --map-root-user --net true 2>/dev/null; then
    exec unshare --map-root-user --net sh -c "$inside" in_namespace "$@"
fi
echo "in_namespace: this system allows no private network namespace (unshare --net, as root or with -r)" >&2
exit 125
