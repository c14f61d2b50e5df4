"""Values of a message by the protocol's names, for rigs and tests that look at what a firmware says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rover_protocol import messages
from rover_protocol.message import Message


def named_values(message: Message, raw: Mapping[str, int | bytes]) -> dict[str, Any]:
    """Raw values; where the protocol has a name for one, the name."""
    names = messages.VALUES.get(message.name, {})
    return {
        key: value if isinstance(value, bytes) else names.get(key, {}).get(value, value) for key, value in raw.items()
    }
