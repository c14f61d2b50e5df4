# Sourced by build.sh and no_panic.sh: `thumb_build FOLDER [CARGO OPTIONS]` builds a crate for the RP2040 in release.
#
# Takes the first toolchain that works: rustup's with the target installed, rustup's after installing the target, or
# Debian's rustc-web and cargo-web, which build the core library themselves from rust-web-src.

target=thumbv6m-none-eabi

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

thumb_build() {
    crate=$1
    shift
    if has_target || { command -v rustup >/dev/null && rustup target add "$target" && has_target; }; then
        (cd "$crate" && cargo build --release --locked --target "$target" "$@")
    elif [ -x /usr/bin/cargo ] && [ -d /usr/lib/rustlib/src/rust/library ]; then
        linker=$(find_linker) || {
            echo "firmware: no linker: install lld (apt-get install lld)" >&2
            return 1
        }
        (
            export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_THUMBV6M_NONE_EABI_LINKER="$linker"
            cd "$crate" && /usr/bin/cargo build --release --locked -Zbuild-std=core --target "$target" "$@"
        )
    else
        echo "firmware: no Rust for $target: run 'rustup target add $target', or on Debian" \
            "'apt-get install rustc-web cargo-web rust-web-src lld'" >&2
        return 1
    fi
}
