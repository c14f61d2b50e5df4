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
    workspace=$1
    shift
    "$cargo" deny --manifest-path "$top/$workspace/Cargo.toml" --locked --all-features "$@"
}

checks="bans licenses sources"
"$cargo" deny --manifest-path "$top/Cargo.toml" fetch --config "$top/deny.toml" db 2>/dev/null ||
    echo "make audit: the database of advisories cannot be fetched" >&2
if deny . check --config "$top/deny.toml" --disable-fetch advisories >/dev/null 2>&1 ||
    [ -n "$(find "${CARGO_HOME:-$HOME/.cargo}/advisory-dbs" -name '*.md' -print -quit 2>/dev/null)" ]; then
    checks="advisories $checks"
else
    echo "make audit: there is no database of advisories: not checked" >&2
fi
for workspace in . firmware/pico firmware/no_panic; do
    echo "$workspace"
    # shellcheck disable=SC2086 # one word for each check
    deny "$workspace" check --config "$top/deny.toml" --disable-fetch --hide-inclusion-graph $checks
done
