"""Missions that the console starts: each a process of its own that goes on whatever becomes of the console."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from rover.console.sessions import Refused
from rover.link.rig import RigName
from rover.mission.run_folder import new_folder

MAX_SEED = 2**31
SAID_BYTES = 4000
MAX_TEXT = 200


@dataclass(frozen=True)
class Wish:
    """What to drive and with what. resume: the folder of an earlier run, None to begin anew."""

    rig: RigName
    seed: int
    port: str
    camera_source: str
    resume: Path | None

    def options(self) -> list[str]:
        """As options of `rover run`."""
        given = [("--rig", self.rig.value), ("--seed", str(self.seed))]
        if self.rig is RigName.DEVICE:
            given += [("--port", self.port), ("--camera-source", self.camera_source)]
        if self.resume is not None:
            given.append(("--resume", str(self.resume)))
        return [word for name, value in given if value for word in (name, value)]


def wish_of(content: dict[str, Any], resume: Path | None) -> Wish:
    """What a request asks for. Raises Refused."""
    try:
        rig = RigName(str(content.get("rig", RigName.SITL.value)))
    except ValueError:
        raise Refused(f"a rig is one of {', '.join(name.value for name in RigName)}", 400) from None
    seed = content.get("seed", 1)
    if not isinstance(seed, int) or isinstance(seed, bool) or not 0 <= seed < MAX_SEED:
        raise Refused("a seed is a whole number from 0 on", 400)
    return Wish(rig, seed, _name(content, "port"), _name(content, "camera_source"), resume)


def _name(content: dict[str, Any], key: str) -> str:
    value = content.get(key, "")
    if not isinstance(value, str) or len(value) > MAX_TEXT or value.startswith("-") or not value.isprintable():
        raise Refused(f"{key}: a name is expected", 400)
    return value


class Started:
    """The missions that one console has started, by the name of their run."""

    def __init__(self, runs: Path, logs: Path) -> None:
        self._runs = runs
        self._logs = logs
        self._processes: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, mission: Path, name: str, wish: Wish) -> str:
        """The name of the new run. Its folder is there once its pre-flight check has passed."""
        if sum(process.poll() is None for process in self._processes.values()) >= 2:
            raise Refused("two missions are on their way already", 409)
        folder = new_folder(name, datetime.now(), self._runs)
        self._logs.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "rover.cli.main", "run", str(mission), "--out", str(folder), *wish.options()]
        with self._log(folder.name).open("wb") as said:
            self._processes[folder.name] = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=subprocess.STDOUT,
                # Not of the console's session: neither its Ctrl-C nor its end reaches the mission.
                start_new_session=True,
                env={**os.environ, "NO_COLOR": "1"},
            )
        return folder.name

    def document(self, name: str) -> dict[str, Any] | None:
        """How the process of a run stands, and what it said last; None for a run that was not started here."""
        process = self._processes.get(name)
        if process is None:
            return None
        return {"exit_code": process.poll(), "said": self._said(name)}

    def beginning(self) -> list[str]:
        """Runs whose process lives."""
        return [name for name, process in self._processes.items() if process.poll() is None]

    def _log(self, name: str) -> Path:
        return self._logs / f"{name}.log"

    def _said(self, name: str) -> list[str]:
        try:
            text = self._log(name).read_bytes()[-SAID_BYTES:].decode("utf-8", "replace")
        except OSError:
            return []
        return [line.removeprefix("rover: ") for line in text.splitlines() if line.strip()][-12:]
