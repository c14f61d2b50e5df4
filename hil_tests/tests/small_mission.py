"""The small mission, run by the command that an operator types: what it printed, and the folder that it left."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

MISSION = Path(__file__).resolve().parent / "missions" / "small.toml"


@dataclass(frozen=True)
class Run:
    """One mission that has ended: exit code, what it printed, its folder."""

    code: int
    printed: str
    said: str
    out: Path

    @cached_property
    def summary(self) -> dict[str, Any]:
        document: dict[str, Any] = json.loads((self.out / "summary.json").read_text())
        return document

    @cached_property
    def truth(self) -> dict[str, Any]:
        document: dict[str, Any] = json.loads((self.out / "truth.json").read_text())
        return document

    @property
    def comparable(self) -> str:
        """summary.json without what may differ from run to run; the order of keys and every digit count."""
        return json.dumps({key: value for key, value in self.summary.items() if key not in ("wall_clock", "out")})


def run_small(out: Path, seed: int) -> Run:
    """On `sitl`, into `out`."""
    rover = str(Path(sys.executable).with_name("rover"))
    command = [rover, "run", str(MISSION), "--rig", "sitl", "--seed", str(seed), "--out", str(out), "--json"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=150.0, check=False)
    return Run(ended.returncode, ended.stdout, ended.stderr, out)
