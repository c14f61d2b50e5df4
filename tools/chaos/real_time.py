"""Missions in real time on a rig of their own: a frozen companion, a pulled port, a second client."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random
from typing import Any

from rover.errors import RoverError
from rover.mission import ear
from rover_hil.testing.served import ServedRig

from tools.chaos.process import Running, run, start
from tools.chaos.trial import ARCHIVES_MB, COMMAND_S, Trial
from tools.chaos.verdict import complaints, missing

BEGIN_S = 120.0
END_S = 120.0
# The firmware's dead-man is 0.3 s; the stop that follows it takes 1.5 s at most, and a reading of the meter 0.2 s.
POWERED_S = 0.3 + 1.5 + 0.2
# Above this gap nobody but the operator lets the rover go on.
ASKED_AFTER_S = 5.0
ON_PORT = ("--port", "PORT")
# (a second client's command, the exit codes that are right for it)
CLIENTS: tuple[tuple[tuple[str, ...], tuple[int, ...]], ...] = (
    (("status", *ON_PORT), (0, 3)),
    (("status", *ON_PORT, "--json"), (0, 3)),
    (("doctor", *ON_PORT), (0, 3)),
    (("monitor", *ON_PORT, "--seconds", "2", "--json"), (0, 3)),
    (("param", "list", *ON_PORT), (3,)),
    (("param", "set", "dead_man=200", *ON_PORT), (3,)),
    (("vehicle", "push", *ON_PORT), (3,)),
    (("status", "--crash", *ON_PORT), (3,)),
    (("link", "bench", "--rig", "device", *ON_PORT, "--seconds", "2"), (3,)),
    (("flash", *ON_PORT), (2, 3)),
    (
        ("run", "MISSION", "--rig", "device", *ON_PORT, "--camera-source", "CAMERA", "--out", "OUT", "--quiet"),
        (3,),
    ),
)


@contextmanager
def driving(mission: Path, folder: Path, random: Random) -> Iterator[tuple[ServedRig, Running, bool]]:
    """A rig and a mission on it, at some moment; whether it has begun and answers."""
    rig = ServedRig(str(mission), "--free-run", "--seed", str(random.randrange(1000)))
    running: Running | None = None
    try:
        port = ("--port", rig.port, "--camera-source", rig.camera_source)
        out = folder / "run"
        running = start("run", mission, "--rig", "device", *port, "--out", out, "--quiet", "--unattended", "--json")
        deadline = time.monotonic() + BEGIN_S
        while running.runs and not (out / ear.SOCKET).exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        wait = time.monotonic() + random.uniform(0.0, 12.0)
        while running.runs and time.monotonic() < wait:
            time.sleep(0.05)
        yield rig, running, _time(folder) is not None
    finally:
        if running is not None and running.runs:
            running.signal(signal.SIGCONT)
            running.signal(signal.SIGKILL)
            running.end(END_S)
        rig.stop()


def frozen(mission: Path) -> Any:
    """The companion stands still for 0.1 to 30 s: the motors go off, and come on again after a short gap alone."""

    def trial(folder: Path, random: Random) -> Trial:
        seconds = 0.1 * 300.0 ** random.random()
        with driving(mission, folder, random) as (rig, running, begun):
            result = Trial(f"frozen for {seconds:.1f} s")
            running.signal(signal.SIGSTOP)
            begin = rig.ask("motors")
            now = begin
            while now["time_s"] - begin["time_s"] < seconds:
                now = rig.ask("motors")
                if not now["powered"] and begin["powered"] and result.powered_s is None:
                    result.powered_s = now["time_s"] - begin["time_s"]
                time.sleep(0.02)
            if begin["powered"] and seconds > POWERED_S and (result.powered_s or seconds) > POWERED_S:
                result.wrong.append(f"the motors were powered for {result.powered_s or seconds:.2f} s")
            running.signal(signal.SIGCONT)
            time.sleep(4.0)
            if seconds > ASKED_AFTER_S + 1.0 and rig.ask("motors")["powered"]:
                result.wrong.append("after a long gap the motors are on again, and nobody was asked")
            running.signal(signal.SIGTERM)
            result.wrong += _well_ended(running, folder, begun)
        return result

    return trial


def pulled(mission: Path) -> Any:
    """Rig and port are gone at once: the mission ends by itself, with all that it knew."""

    def trial(folder: Path, random: Random) -> Trial:
        with driving(mission, folder, random) as (rig, running, begun):
            rig.process.kill()
            return Trial("rig and port gone", _well_ended(running, folder, begun, (0, 5, 6, 7, 8)))

    return trial


def second_client(mission: Path) -> Any:
    """Somebody else on the port of a mission: told who holds it, or answered, and the mission goes on."""

    def trial(folder: Path, random: Random) -> Trial:
        words, codes = random.choice(CLIENTS)
        with driving(mission, folder, random) as (rig, running, begun):
            stand_for = {
                "PORT": rig.port,
                "CAMERA": rig.camera_source,
                "MISSION": str(mission),
                "OUT": str(folder / "second"),
            }
            result = Trial(f"rover {' '.join(words)} on the port of a mission")
            before = _time(folder)
            ended = run(*(stand_for.get(word, word) for word in words), limit_s=COMMAND_S)
            after = _time(folder)
            if before is None or after is None:
                result.did += ", which had ended or not begun"
                codes = tuple(range(9))
            found = complaints(ended, COMMAND_S, ARCHIVES_MB, codes)
            result.wrong += [each for each in found if "instead of one" not in each]
            running.signal(signal.SIGTERM)
            result.wrong += _well_ended(running, folder, begun, (0, 5, 6, 8))
            if (folder / "second").exists():
                result.wrong.append("the second client has made a run")
        return result

    return trial


def _time(folder: Path) -> float | None:
    with suppress(RoverError, OSError, KeyError, TypeError, ValueError):
        return float(ear.ask(folder / "run", {"op": "state"})["time_s"])
    return None


def _well_ended(running: Running, folder: Path, begun: bool, codes: tuple[int, ...] = (0, 5, 6, 7, 8)) -> list[str]:
    ended = running.end(END_S)
    wrong = complaints(ended, END_S, ARCHIVES_MB, codes if begun else tuple(range(9)))
    if begun and ended.code is not None:
        wrong += missing(folder / "run")
    return wrong
