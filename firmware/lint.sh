#!/bin/sh
# Check what the workspace's own lint does not reach: the crates that are built for the board.
#
# usage: firmware/lint.sh
set -eu

firmware=$(cd "$(dirname "$0")" && pwd)
. "$firmware/toolchain.sh"

for crate in pico no_panic; do
    (cd "$firmware/$crate" && cargo fmt --check)
done

thumb_lint "$firmware/pico"
thumb_lint "$firmware/no_panic"
target=thumbv8m.main-none-eabihf
if missing=$(find_toolchain 2>&1); then
    thumb_lint "$firmware/pico" --no-default-features --features rp235xa
else
    echo "lint: the RP2350 is left out: $(echo "$missing" | tail -n 1)" >&2
fi
