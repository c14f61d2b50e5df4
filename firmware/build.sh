#!/bin/sh
# Build the RP2040 firmware: firmware/build/rover-pico.elf and .uf2, and a report of its size.
#
# usage: firmware/build.sh
set -eu

firmware=$(cd "$(dirname "$0")" && pwd)
pico=$firmware/pico
out=$firmware/build
python=${PYTHON:-python3}
. "$firmware/toolchain.sh"

if [ -z "${ROVER_GIT_HASH:-}" ]; then
    ROVER_GIT_HASH=$(git -C "$firmware" rev-parse HEAD 2>/dev/null || echo 0)
fi
export ROVER_GIT_HASH

thumb_build "$pico"

mkdir -p "$out"
cp "${CARGO_TARGET_DIR:-$pico/target}/$target/release/rover-pico" "$out/rover-pico.elf"
"$python" "$firmware/../tools/flash/uf2.py" "$out/rover-pico.elf" "$out/rover-pico.uf2"
echo "$out/rover-pico.uf2"
