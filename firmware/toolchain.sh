# shellcheck shell=sh
# Sourced by build.sh, no_panic.sh and lint.sh: `thumb_build FOLDER [CARGO OPTIONS]` builds a crate for $target in
# release, `thumb_lint FOLDER [CARGO OPTIONS]` checks it and takes every warning for an error.
#
# Takes the first toolchain that works: rustup's with the target installed, rustup's after installing the target, or
# Debian's rustc-web and cargo-web, which build the core library themselves from rust-web-src.

# The RP2040; the RP2350 is thumbv8m.main-none-eabihf.
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

# Whose compiler builds for $target: sets `toolchain` to rustup or debian, and `linker` for the latter. Otherwise fails
# and says in its last line what is missing.
find_toolchain() {
    if has_target || { command -v rustup >/dev/null && rustup target add "$target" >&2 && has_target; }; then
        toolchain=rustup
    elif [ -x /usr/bin/cargo ] && [ -d /usr/lib/rustlib/src/rust/library ]; then
        toolchain=debian
        linker=$(find_linker) || {
            echo "firmware: no linker: install lld (apt-get install lld)" >&2
            return 1
        }
    else
        echo "firmware: no Rust for $target: run 'rustup target add $target', or on Debian" \
            "'apt-get install rustc-web cargo-web rust-web-src lld'" >&2
        return 1
    fi
}

# Where the sources and the crates lie goes into no binary.
same_paths() {
    top=$(cd "$1/../.." && pwd -P)
    echo "--remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=/cargo --remap-path-prefix=$top=/rover"
}

# thumb_cargo FOLDER SUBCOMMAND [CARGO OPTIONS]
thumb_cargo() {
    crate=$1
    subcommand=$2
    shift 2
    find_toolchain || return 1
    (
        RUSTFLAGS="${RUSTFLAGS:-} $(same_paths "$crate")"
        RUSTC_WRAPPER=$(cd "$crate/.." && pwd)/rustc.sh
        export RUSTFLAGS RUSTC_WRAPPER
        cd "$crate" || exit 1
        if [ "$toolchain" = rustup ]; then
            cargo "$subcommand" --release --locked --target "$target" "$@"
        else
            export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1
            export "CARGO_TARGET_$(echo "$target" | tr 'a-z.-' 'A-Z__')_LINKER=$linker"
            /usr/bin/cargo "$subcommand" --release --locked -Zbuild-std=core --target "$target" "$@"
        fi
    )
}

thumb_build() {
    crate=$1
    shift
    thumb_cargo "$crate" build "$@"
}

thumb_lint() {
    crate=$1
    shift
    find_toolchain || return 1
    if [ "$toolchain" = rustup ] && command -v cargo-clippy >/dev/null; then
        thumb_cargo "$crate" clippy --quiet "$@" -- -D warnings
    else
        # Debian's rustc-web comes without clippy: the compiler's own warnings are what is left.
        echo "lint: no clippy for $target: $crate is checked by the compiler alone" >&2
        RUSTFLAGS="-D warnings" thumb_cargo "$crate" check --quiet "$@"
    fi
}
