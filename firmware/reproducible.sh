#!/bin/sh
# Build the firmware for the RP2040 once more, from a copy of the sources in another folder: it must be the same bytes.
#
# usage: firmware/reproducible.sh
set -eu

firmware=$(cd "$(dirname "$0")" && pwd)
python=${PYTHON:-python3}
. "$firmware/toolchain.sh"
# As build.sh has it, and the copy is no clone that could be asked.
if [ -z "${ROVER_GIT_HASH:-}" ]; then
    ROVER_GIT_HASH=$(git -C "$firmware" rev-parse HEAD 2>/dev/null || echo 0)
fi
export ROVER_GIT_HASH
"$firmware/build.sh" >/dev/null

copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
elsewhere=$copy/a/longer/way
mkdir -p "$elsewhere"
tar -C "$firmware/.." --exclude=target --exclude=firmware/build -cf - Cargo.toml Cargo.lock protocol/rust firmware \
    companion/native hil_tests/plant | tar -C "$elsewhere" -xf -
(unset CARGO_TARGET_DIR && thumb_build "$elsewhere/firmware/pico" --quiet)
PYTHONPATH=$firmware/.. "$python" -m tools.flash.uf2 --chip rp2040 \
    "$elsewhere/firmware/pico/target/$target/release/rover-pico" "$copy/rover-pico.uf2" >/dev/null
if ! cmp "$firmware/build/rover-pico.uf2" "$copy/rover-pico.uf2"; then
    echo "firmware/reproducible.sh: another folder gives another firmware" >&2
    exit 1
fi
echo "rover-pico.uf2: the same bytes from two folders, sha256 $(sha256sum "$copy/rover-pico.uf2" | cut -d ' ' -f 1)"
