#!/bin/sh
# Build the firmware: firmware/build/rover-pico.elf and .uf2 for the RP2040, rover-pico2.elf and .uf2 for the RP2350, and
# a report of their sizes. Without a compiler for the RP2350 that one is left out, and a line says so.
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

# build NAME CHIP [CARGO OPTIONS]
build() {
    name=$1
    chip=$2
    shift 2
    thumb_build "$pico" "$@"
    mkdir -p "$out"
    cp "${CARGO_TARGET_DIR:-$pico/target}/$target/release/rover-pico" "$out/$name.elf"
    echo "$chip"
    PYTHONPATH=$firmware/.. "$python" -m tools.flash.uf2 --chip "$chip" "$out/$name.elf" "$out/$name.uf2"
    echo "$out/$name.uf2"
}

build rover-pico rp2040

target=thumbv8m.main-none-eabihf
if missing=$(find_toolchain 2>&1); then
    build rover-pico2 rp2350 --no-default-features --features rp235xa
else
    # One of an earlier commit would be taken for this one.
    rm -f "$out/rover-pico2.elf" "$out/rover-pico2.uf2"
    echo "the RP2350 is left out: $(echo "$missing" | tail -n 1)" >&2
fi
