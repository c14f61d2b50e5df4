"""Which cameras the kernel sees, without opening any: a camera in use must not be disturbed by being listed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

SYSTEM = Path("/sys/class/video4linux")


@dataclass(frozen=True)
class Camera:
    """device: its node in /dev. name: as the driver gives it."""

    device: str
    name: str


def list_cameras(system: Path = SYSTEM) -> list[Camera]:
    """Video nodes that pictures come from, by number; a device's further nodes (metadata) are left out."""
    found = []
    for node in system.glob("video*"):
        number = node.name.removeprefix("video")
        if number.isdigit() and _text(node / "index") in ("0", ""):
            found.append((int(number), Camera(f"/dev/{node.name}", _text(node / "name") or "unnamed")))
    return [camera for _, camera in sorted(found, key=lambda entry: entry[0])]


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""
