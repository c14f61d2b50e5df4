#!/bin/sh
# The compiler as toolchain.sh has cargo call it: the same sources give the same bytes, whichever folder they lie in.
#
# Cargo tells crates beside pico's own workspace apart by their whole path, from which rustc makes the names of their
# symbols, and from these their order in flash: here name and version tell them apart.
#
# Set RUSTC_WRAPPER to this file for a build.
set -eu

case ${CARGO_PKG_NAME:-} in
rover-*)
    for argument; do
        shift
        case $argument in
        metadata=*) argument=metadata=$CARGO_PKG_NAME-$CARGO_PKG_VERSION ;;
        esac
        set -- "$@" "$argument"
    done
    ;;
esac
exec "$@"
