"""The golden vectors, for the tests of this folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cantools
from cantools.database.can import Database

PROTOCOL = Path(__file__).resolve().parents[1]


def load(name: str) -> list[dict[str, Any]]:
    cases: list[dict[str, Any]] = json.loads((PROTOCOL / "vectors" / f"{name}.json").read_text(encoding="utf-8"))
    return cases


def values(vector: dict[str, Any]) -> dict[str, int | bytes]:
    """Raw values; texts, lists in JSON, as bytes."""
    return {name: bytes(v) if isinstance(v, list) else v for name, v in vector["values"].items()}


def database() -> Database:
    """The definition of every message, as cantools reads it."""
    read = cantools.database.load_file(PROTOCOL / "rover.dbc")
    assert isinstance(read, Database)
    return read
