"""The first place at which two messages that should be equal are not."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from rover_protocol import messages

NOTHING = "nothing"


@dataclass(frozen=True)
class Difference:
    """Where a replay left the recording. `time` in seconds of the mission; `field` is a path into the message."""

    topic: str
    time: float
    field: str
    recorded: Any
    replayed: Any

    def document(self) -> dict[str, Any]:
        """For JSON."""
        values = asdict(self)
        return {"topic": self.topic, "time_s": round(values.pop("time"), 6), **values}

    def __str__(self) -> str:
        return f"{self.topic} at {self.time:.3f} s: {self.field}: recorded {self.recorded}, replayed {self.replayed}"


def first_field(recorded: Any, replayed: Any, path: str = "") -> tuple[str, Any, Any] | None:
    """Path and both values of the first leaf that differs between two JSON values, by order of keys; or None."""
    if isinstance(recorded, dict) and isinstance(replayed, dict):
        for key in [*recorded, *(key for key in replayed if key not in recorded)]:
            inner = f"{path}.{key}" if path else str(key)
            found = first_field(recorded.get(key), replayed.get(key), inner)
            if found is not None:
                return found
        return None
    if isinstance(recorded, list) and isinstance(replayed, list):
        for index in range(max(len(recorded), len(replayed))):
            pair = [values[index] if index < len(values) else None for values in (recorded, replayed)]
            found = first_field(pair[0], pair[1], f"{path}[{index}]")
            if found is not None:
                return found
        return None
    return None if recorded == replayed else (path or "value", recorded, replayed)


def name_link_frame(content: dict[str, Any]) -> dict[str, Any]:
    """A frame of the link by its message's name with its fields, where the protocol knows it."""
    try:
        message, fields = messages.decode(int(content["id"]), bytes.fromhex(content["data"]))
    except (ValueError, KeyError):
        return content
    plain = {key: value.hex() if isinstance(value, bytes) else value for key, value in fields.items()}
    return {"message": message.name, message.name: plain}
