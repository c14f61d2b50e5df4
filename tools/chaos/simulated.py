"""Missions on the simulated rig that are killed, told to end, or run out of disk, at any moment."""

from __future__ import annotations

import json
import os
import resource
import signal
import time
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any

from rover.errors import RoverError
from rover.mission import ear

from tools.chaos.process import Running, run, start
from tools.chaos.trial import ARCHIVES_MB, COMMAND_S, Trial
from tools.chaos.verdict import complaints, missing

# Until a mission has begun, and until one that is told to end has written its report, on a busy computer.
BEGIN_S = 180.0
END_S = 180.0
MISSION_S = 600.0
# Of mission time that may be lost, and of motors that may be powered without a commander: the dead-man and the stop.
LOSS_S = 10.0


def killed(mission: Path) -> Any:
    """kill -9 at any moment: what is recovered ends at most LOSS_S before, and the motors are off."""

    def trial(folder: Path, random: Random) -> Trial:
        cut = folder / "cut"
        running = start("run", mission, "--seed", random.randrange(1000), "--out", cut, "--quiet")
        result = Trial()
        at = _some_time_after_the_begin(running, cut, random)
        running.signal(signal.SIGKILL)
        ended = running.end(END_S)
        result.did = f"kill -9 at {at:.1f} s" if at is not None else "kill -9 before the mission had begun"
        if ended.code != -signal.SIGKILL:
            result.did = "a mission that had ended before"
            result.wrong = complaints(ended, MISSION_S, ARCHIVES_MB)
        elif at is not None:
            result.wrong += _off_within(cut, 10.0)
            again = run("recover", cut, "--out", folder / "again", "--quiet", "--json", limit_s=MISSION_S)
            result.wrong += complaints(again, MISSION_S, ARCHIVES_MB, (0,))
            if again.code == 0:
                result.loss_s = max(0.0, at - float(json.loads(again.out)["recovered_until_s"]))
                if result.loss_s > LOSS_S:
                    result.wrong.append(f"{result.loss_s:.1f} s of the mission are lost")
            if at > 2.0 * LOSS_S and not (cut / "survey.npz").exists():
                result.wrong.append(f"no checkpoint after {at:.1f} s")
        _end_rig(cut)
        return result

    return trial


def told_to_end(mission: Path) -> Any:
    """SIGHUP, SIGTERM, SIGINT, one or two of them: everything is written, exit code 5."""

    def trial(folder: Path, random: Random) -> Trial:
        out = folder / "run"
        number = random.choice((signal.SIGHUP, signal.SIGTERM, signal.SIGINT))
        running = start("run", mission, "--seed", random.randrange(1000), "--out", out, "--quiet", "--json")
        at = _some_time_after_the_begin(running, out, random)
        running.signal(number)
        twice = random.random() < 0.3
        if twice:
            time.sleep(random.uniform(0.0, 1.0))
            running.signal(number)
        ended = running.end(END_S)
        result = Trial(f"{number.name}{' twice' if twice else ''} at {at} s of the mission")
        result.wrong = complaints(ended, END_S, ARCHIVES_MB, (0, 5, 6, 8))
        if ended.code is not None and at is not None:
            result.wrong += missing(out)
            with suppress(ValueError):
                if not json.loads(ended.out)["reason"] and ended.code != 0:
                    result.wrong.append("no reason is told")
        _end_rig(out)
        return result

    return trial


def without_disk(mission: Path) -> Any:
    """No file may grow beyond a limit, as where a disk is full: what is lost is named, the rest is there."""

    def trial(folder: Path, random: Random) -> Trial:
        limit = int(10 ** random.uniform(3.5, 6.5))

        def small_files() -> None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        out = folder / "run"
        line = ("run", mission, "--seed", random.randrange(1000), "--out", out, "--quiet")
        ended = start(*line, before=small_files).end(MISSION_S)
        result = Trial(f"no file above {limit} bytes", complaints(ended, MISSION_S, ARCHIVES_MB, (0, 2, 3, 8)))
        if ended.code in (0, 8):
            said = ended.out + ended.err
            result.wrong += [f"{name}, and nobody says so" for name in missing(out) if name.split()[0] not in said]
        _end_rig(out)
        return result

    return trial


def _some_time_after_the_begin(running: Running, out: Path, random: Random) -> float | None:
    """Waits so long; the mission's own time then, None when it has not begun or has ended."""
    deadline = time.monotonic() + BEGIN_S
    if random.random() < 0.1:
        time.sleep(random.uniform(0.0, 5.0))
        return None
    while running.runs and not (out / ear.SOCKET).exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    wait = time.monotonic() + random.uniform(0.0, 25.0)
    while running.runs and time.monotonic() < wait:
        time.sleep(0.02)
    with suppress(RoverError, OSError, KeyError, TypeError, ValueError):
        return float(ear.ask(out, {"op": "state"})["time_s"])
    return None


def _rig(out: Path) -> dict[str, Any]:
    with suppress(OSError, ValueError):
        document: dict[str, Any] = json.loads((out / "rig.json").read_text())
        return document
    return {}


def _off_within(out: Path, seconds: float) -> list[str]:
    """The rig goes on by itself, in real time: its firmware has to have switched the motors off."""
    port = _rig(out).get("port")
    deadline = time.monotonic() + seconds + COMMAND_S
    told = ""
    while port is not None and time.monotonic() < deadline:
        ended = run("status", "--port", port, "--json", limit_s=COMMAND_S)
        told = ended.out or ended.err
        if ended.code == 0 and json.loads(ended.out)["powered"] is False:
            return []
        time.sleep(0.5)
    return [] if port is None else [f"the motors were not seen off: {told[:200]}"]


def _end_rig(out: Path) -> None:
    """It outlives a killed companion on purpose."""
    pid = _rig(out).get("pid")
    with suppress(OSError):
        if pid is not None and b"rover" in Path(f"/proc/{pid}/cmdline").read_bytes():
            os.kill(pid, signal.SIGTERM)
