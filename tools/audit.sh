#!/bin/sh
# Hold every crate of the host and of the board to deny.toml. Advisories are looked at when their database can be had, or
# is there from another time; a line says when not.
#
# usage: tools/audit.sh CARGO
set -eu

top=$(cd "$(dirname "$0")/.." && pwd)
cargo=$1
if ! "$cargo" deny --version >/dev/null 2>&1; then
    echo "make audit: cargo-deny is missing: cargo install cargo-deny --locked" >&2
    exit 2
fi

# deny WORKSPACE SUBCOMMAND [OPTIONS]
deny() {
    manifest=$top/$1/Cargo.toml
    shift
    "$cargo" deny --manifest-path "$manifest" --config "$top/deny.toml" --locked --workspace --all-features "$@"
}

checks="bans licenses sources"
if deny . fetch db >/dev/null 2>&1 || deny . --offline check advisories >/dev/null 2>&1; then
    checks="advisories $checks"
else
    echo "make audit: the database of advisories cannot be had: they are not checked" >&2
fi
for workspace in . firmware/pico firmware/no_panic; do
    echo "$workspace/Cargo.lock"
    # shellcheck disable=SC2086 # one word for each check
    deny "$workspace" check --hide-inclusion-graph $checks
done
