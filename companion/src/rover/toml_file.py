"""TOML files as a person writes them: read whole, and what is wrong with one said in one line."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from rover.errors import BadInput
from rover.plain_file import plain_file

if sys.version_info >= (3, 11):
    import tomllib
else:  # pragma: no cover - Python 3.10
    import tomli as tomllib

# A mission with a hundred obstacles and its outlines has some 10 kB. What is larger is none, and to take it apart may
# cost a thousand times its size: time and memory grow with the square of a key's parts.
MAX_BYTES = 2**20
MAX_KEY_PARTS = 32
# A part is bounded, so that looking for them costs no more than a few hundred steps a character.
PART = r"""(?:[A-Za-z0-9_-]{1,200}|"[^"\n]{0,200}"|'[^'\n]{0,200}')"""
LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_-])(?:{PART}[ \t]*\.[ \t]*){{{MAX_KEY_PARTS}}}")


def read_toml(path: Path) -> dict[str, Any]:
    """The document as nested dicts; raises BadInput when it can't be read or parsed."""
    try:
        with plain_file(path).open("rb") as file:
            content = file.read(MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            raise BadInput(f"{path}: over {MAX_BYTES // 2**20} MB: no file of this kind is so large")
        text = content.decode()
        if LONG_KEY.search(text):
            raise BadInput(f"{path}: not valid here: a key of over {MAX_KEY_PARTS} parts")
        document: dict[str, Any] = tomllib.loads(text.replace("\r\n", "\n"))
        return document
    except BadInput:
        raise
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
