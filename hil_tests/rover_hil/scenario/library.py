"""The scenarios that ship, and what a command line means by the name of one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rover.errors import BadInput

FOLDER = Path(__file__).resolve().parents[2] / "scenarios"


def shipped() -> list[Path]:
    """All files that ship, by name."""
    return sorted(FOLDER.glob("*.toml"))


def find(words: Sequence[str]) -> list[Path]:
    """Files of names that ship, of paths, and of whole folders, in the order given. Raises BadInput."""
    files: list[Path] = []
    for word in words:
        files += _find(word)
    return list(dict.fromkeys(files))


def _find(word: str) -> list[Path]:
    path = Path(word)
    if path.is_dir():
        inside = sorted(path.glob("*.toml"))
        if not inside:
            raise BadInput(f"{word}: no scenario (*.toml) in this folder")
        return inside
    if path.is_file():
        return [path]
    named = FOLDER / f"{word}.toml"
    if named.is_file():
        return [named]
    near = ", ".join(file.stem for file in shipped() if word[:4] in file.stem)
    hint = f"; similar: {near}" if near else "; 'rover hil list' shows those that ship"
    raise BadInput(f"{word}: no such scenario{hint}")
