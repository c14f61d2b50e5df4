"""Which Rust file of a crate names which other of it: `crate::`, `super::` and `self::` paths, `mod` lines apart."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

PATH = re.compile(r"\b(crate|super|self)::((?:\w+::)*(?:\w+|\{))")
COMMENT = re.compile(r"//[^\n]*")
TESTS = re.compile(r"#\[cfg\(test\)\]\s*mod\s+\w+\s*\{.*", re.DOTALL)
"""Unit tests, which stand at a file's end."""


def modules_of(files: Iterable[Path]) -> dict[str, Path]:
    """Names of a crate's modules, `crate` for its root; paths are relative to the crate's src."""
    named = {}
    for path in files:
        parts = [part for part in path.with_suffix("").parts if part not in ("lib", "main", "mod")]
        named["::".join(["crate", *parts])] = path
    return named


def uses_of(source: str, module: str, known: Mapping[str, Path]) -> set[str]:
    """The modules among `known` that a file names outside of comments and tests."""
    text = COMMENT.sub("", TESTS.sub("", source))
    found = set()
    for start, rest in PATH.findall(text):
        base = {"crate": "crate", "self": module, "super": module.rpartition("::")[0]}[start]
        name = f"{base}::{rest}".removesuffix("::{").removesuffix("{").removesuffix("::")
        while name and name not in known:
            name = name.rpartition("::")[0]
        if name and name not in (module, "crate"):
            found.add(name)
    return found
