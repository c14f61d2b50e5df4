#!/bin/sh
# Prove that no panic is left in rover-core as it is built for the board; fails and names the function otherwise.
#
# usage: firmware/no_panic.sh
set -eu

firmware=$(cd "$(dirname "$0")" && pwd)
. "$firmware/toolchain.sh"

thumb_build "$firmware/no_panic" --quiet
# The check itself is checked: with a panic put in, it must not link, and for that reason.
if message=$(thumb_build "$firmware/no_panic" --quiet --features provoke 2>&1); then
    echo "firmware/no_panic.sh: a panic was put in and not found" >&2
    exit 1
elif ! echo "$message" | grep -q rover_core_can_panic; then
    echo "$message" >&2
    exit 1
fi
echo "rover-core for $target: no panic left"
