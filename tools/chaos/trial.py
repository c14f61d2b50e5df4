"""One trial of a campaign: what is done, and what was wrong with how it went."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

# How long a command may take on a busy computer, seconds, and how much memory, MB: see docs/reference/files.md#limits.
COMMAND_S = 90.0
# What a command holds that has read nothing: its libraries.
BASE_MB = 300.0
PICTURES_MB = 1_000.0 + BASE_MB
ARCHIVES_MB = 512.0 + BASE_MB


@dataclass
class Trial:
    """did: in words; wrong: complaints; loss_s: of mission time; powered_s: of motors that nobody commanded."""

    did: str = ""
    wrong: list[str] = field(default_factory=list)
    loss_s: float | None = None
    powered_s: float | None = None


Run = Callable[[Path, Random], Trial]
"""Makes a trial in a folder of its own."""
