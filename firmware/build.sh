#!/bin/sh
# Build the RP2040 firmware: firmware/build/rover-pico.elf and .uf2, and a report of its size.
#
# usage: firmware/build.sh
#
# Takes the first toolchain that works: rustup's with the target installed, rustup's after installing the target, or
# Debian's rustc-web and cargo-web, which build the core library themselves from rust-web-src.
set -eu

firmware=$(cd "$(dirname "$0")" && pwd)
pico=$firmware/pico
out=$firmware/build
target=thumbv6m-none-eabi
python=${PYTHON:-python3}

has_target() {
    [ -d "$(rustc --print sysroot 2>/dev/null)/lib/rustlib/$target" ]
}

# rustc-web comes without its linker: take the one of a rustup toolchain, or Debian's lld.
find_linker() {
    for folder in "$(rustc --print sysroot 2>/dev/null)"/lib/rustlib/*/bin /usr/lib/rustlib/*/bin /usr/lib/llvm-*/bin; do
        if [ -x "$folder/rust-lld" ]; then
            echo "$folder/rust-lld"
            return
        elif [ -x "$folder/ld.lld" ]; then
            echo "$folder/ld.lld"
            return
        fi
    done
    command -v rust-lld || command -v ld.lld
}

if [ -z "${ROVER_GIT_HASH:-}" ]; then
    ROVER_GIT_HASH=$(git -C "$firmware" rev-parse HEAD 2>/dev/null || echo 0)
fi
export ROVER_GIT_HASH

if has_target || { command -v rustup >/dev/null && rustup target add "$target" && has_target; }; then
    (cd "$pico" && cargo build --release --locked --target "$target")
elif [ -x /usr/bin/cargo ] && [ -d /usr/lib/rustlib/src/rust/library ]; then
    linker=$(find_linker) || {
        echo "firmware/build.sh: no linker: install lld (apt-get install lld)" >&2
        exit 1
    }
    export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_THUMBV6M_NONE_EABI_LINKER="$linker"
    (cd "$pico" && /usr/bin/cargo build --release --locked -Zbuild-std=core --target "$target")
else
    echo "firmware/build.sh: no Rust for $target: run 'rustup target add $target', or on Debian" \
        "'apt-get install rustc-web cargo-web rust-web-src lld'" >&2
    exit 1
fi

mkdir -p "$out"
cp "${CARGO_TARGET_DIR:-$pico/target}/$target/release/rover-pico" "$out/rover-pico.elf"
"$python" "$firmware/../tools/flash/uf2.py" "$out/rover-pico.elf" "$out/rover-pico.uf2"
echo "$out/rover-pico.uf2"
