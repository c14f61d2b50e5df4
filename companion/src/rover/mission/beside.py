"""Files that a mission file names: they lie beside it."""

from __future__ import annotations

from pathlib import Path

from rover.toml_table import Table


def beside(table: Table, key: str, file: Path, name: str) -> str:
    """The path of a file named in a mission file, relative to that file. Raises BadInput."""
    try:
        path = (file.parent / name).resolve()
        found = path.is_file()
    except (OSError, ValueError):
        raise table.error(key, f"{name!r} is no file name") from None
    if not found:
        raise table.error(key, f"{path}: no such file")
    return str(path)
