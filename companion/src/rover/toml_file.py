"""TOML files as a person writes them: read whole, and what is wrong with one said in one line."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from rover.errors import BadInput
from rover.plain_file import plain_file

if sys.version_info >= (3, 11):
    import tomllib
else:  # pragma: no cover - Python 3.10
    import tomli as tomllib


def read_toml(path: Path) -> dict[str, Any]:
    """The document as nested dicts; raises BadInput when it can't be read or parsed."""
    try:
        with plain_file(path).open("rb") as file:
            document: dict[str, Any] = tomllib.load(file)
            return document
    except FileNotFoundError:
        raise BadInput(f"{path}: no such file") from None
    except IsADirectoryError:
        raise BadInput(f"{path}: is a folder, a TOML file is wanted") from None
    except PermissionError:
        raise BadInput(f"{path}: not readable") from None
    except (OSError, ValueError) as error:
        if isinstance(error, (tomllib.TOMLDecodeError, UnicodeDecodeError)):
            raise BadInput(f"{path}: not valid TOML: {printable(str(error))}") from None
        raise BadInput(f"{printable(str(path))}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    except RecursionError:
        raise BadInput(f"{path}: not valid TOML: nested too deeply") from None


def parse_value(text: str) -> Any:
    """What stands behind the = of a TOML line; a word that is none is taken as it stands."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, KeyError):
        return text


def printable(text: str) -> str:
    """The text on one line, whatever a file has put into it."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
