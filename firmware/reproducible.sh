#!/bin/sh
# Build the firmware twice, in two folders, and compare: the same sources give the same UF2, byte for byte.
#
# usage: firmware/reproducible.sh
set -eu

top=$(cd "$(dirname "$0")/.." && pwd)
export ROVER_GIT_HASH="${ROVER_GIT_HASH:-0}"
unset CARGO_TARGET_DIR
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for folder in one another/folder; do
    mkdir -p "$scratch/$folder"
    (cd "$top" && git ls-files -z firmware protocol tools Cargo.toml Cargo.lock | tar cf - --null -T - |
        tar xf - -C "$scratch/$folder")
    "$scratch/$folder/firmware/build.sh" >"$scratch/printed" 2>&1 || { cat "$scratch/printed" >&2; exit 1; }
done
for first in "$scratch"/one/firmware/build/*.uf2; do
    name=$(basename "$first")
    cmp "$first" "$scratch/another/folder/firmware/build/$name"
    echo "$name: the same bytes from two folders"
done
