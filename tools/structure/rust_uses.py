"""Which Rust file of a crate names which other of it: `crate::`, `super::` and `self::` paths, `mod` lines apart."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

START = re.compile(r"\b(crate|super|self)::")
WORD = re.compile(r"\w+")
ALIAS = re.compile(r"\s+as\s+\w+")
COMMENT = re.compile(r"//[^\n]*")
# Unit tests, which stand at a file's end.
TESTS = re.compile(r"#\[cfg\(test\)\]\s*mod\s+\w+\s*\{.*", re.DOTALL)


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
    for start in START.finditer(text):
        base = {"crate": "crate", "self": module, "super": module.rpartition("::")[0]}[start[1]]
        for name in _paths(text, start.end(), base)[0]:
            while name and name not in known:
                name = name.rpartition("::")[0]
            if name and name not in (module, "crate"):
                found.add(name)
    return found


def _paths(text: str, at: int, base: str) -> tuple[list[str], int]:
    """The paths that begin with `base` and go on at a place of the text, groups in braces resolved; where they end."""
    while (part := WORD.match(text, at)) is not None:
        base, at = f"{base}::{part[0]}", part.end()
        if not text.startswith("::", at):
            return [base], at
        at += 2
    if not text.startswith("{", at):
        return [base], at
    paths: list[str] = []
    at += 1
    while at < len(text) and text[at] != "}":
        if text[at].isspace() or text[at] == ",":
            at += 1
            continue
        inner, end = _paths(text, at, base)
        paths += inner
        if end == at:  # a glob, or nothing that this reader knows
            end += 1
        alias = ALIAS.match(text, end)
        at = alias.end() if alias is not None else end
    return paths, at + 1
