"""The golden vectors, for the tests of this folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

PROTOCOL = Path(__file__).resolve().parents[1]


def load(name: str) -> list[dict[str, Any]]:
    return json.loads((PROTOCOL / "vectors" / f"{name}.json").read_text(encoding="utf-8"))


def values(vector: dict[str, Any]) -> dict[str, int | bytes]:
    """Raw values; texts, lists in JSON, as bytes."""
    return {name: bytes(v) if isinstance(v, list) else v for name, v in vector["values"].items()}
