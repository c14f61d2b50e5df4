"""JSON as RFC 8259 has it: a number that is not finite becomes null, for JSON has none."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any


def finite(value: Any) -> Any:
    """The same value of mappings, sequences and scalars with None for nan and the infinities."""
    if isinstance(value, Mapping):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def document(value: Any, indent: int = 2) -> str:
    """A whole JSON document for people and machines, ending with a newline; keys stay in their order."""
    return json.dumps(finite(value), indent=indent, ensure_ascii=False, allow_nan=False) + "\n"
