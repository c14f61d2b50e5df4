#!/bin/sh
# Says everything that is missing before anything is installed; exits with 1 if something is.
#
# usage: tools/prerequisites.sh PYTHON CARGO
set -u

python=$1
cargo=$2
missing=0

lacks() {
    echo "missing: $1" >&2
    missing=1
}

if ! command -v "$python" >/dev/null; then
    lacks "Python 3.10 or newer ('$python' was not found; 'make PYTHON=…' names another)"
elif ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))'; then
    lacks "Python 3.10 or newer ('$python' is $("$python" -V 2>&1); 'make PYTHON=…' names another)"
elif ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
    lacks "Python's venv (on Debian and Ubuntu: apt-get install python3-venv)"
elif [ "$(uname -m)" != x86_64 ]; then
    # ruckig has wheels for x86-64 only: elsewhere pip builds it.
    "$python" -c 'import os, sysconfig, sys; sys.exit(not os.path.exists(sysconfig.get_path("include") + "/Python.h"))' ||
        lacks "Python's headers, to build ruckig (on Debian and Ubuntu: apt-get install python3-dev)"
    command -v c++ >/dev/null ||
        lacks "a compiler for C++20, to build ruckig (on Debian and Ubuntu: apt-get install g++)"
fi

# The oldest that heapless and our own code (is_multiple_of) take.
if ! command -v "$cargo" >/dev/null; then
    lacks "Rust 1.87 or newer ('$cargo' was not found; from rustup, or your distribution's)"
else
    version=$("$cargo" --version | cut -d ' ' -f 2)
    minor=$(echo "$version" | cut -d . -f 2)
    [ "${version%%.*}" -gt 1 ] || [ "${minor:-0}" -ge 87 ] ||
        lacks "Rust 1.87 or newer ('$cargo' is $version; 'rustup update' brings one)"
fi
command -v cc >/dev/null ||
    lacks "a C compiler, which Rust links with (on Debian and Ubuntu: apt-get install gcc)"

if [ "$missing" = 1 ]; then
    echo "nothing was installed; install what is missing and run make again" >&2
fi
exit "$missing"
