"""`rover monitor` and `rover jog` on a rig in real time, as somebody at a bench uses them."""

from __future__ import annotations

import csv
import json
import math
import os
import pty
import select
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import pytest
from rover.cli.jog import split_keys
from rover_hil.testing.served import ServedRig

pytestmark = pytest.mark.rig("sitl")
MISSION = Path(__file__).parent / "missions" / "wide.toml"


@pytest.fixture(scope="module")
def rig() -> Iterator[ServedRig]:
    served = ServedRig(str(MISSION), "--free-run", "--no-camera")
    yield served
    served.stop()


def moments(rig: ServedRig, *options: str) -> list[dict[str, Any]]:
    command = [sys.executable, "-m", "rover.cli.main", "monitor", "--port", rig.port, "--json", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_the_monitor_tells_what_is_measured_and_draws_it(rig: ServedRig, tmp_path: Path) -> None:
    picture, table = tmp_path / "plot.png", tmp_path / "plot.csv"
    told = moments(rig, "--seconds", "2", "--plot", str(table))
    assert len(told) >= 10
    last = told[-1]
    assert last["state"] == "Disarmed"
    assert 7.0 < last["battery_v"] < 8.4
    assert (last["left_counts"], last["left_counts_per_s"]) == (0, 0.0)
    assert set(last["sonars"]) <= {"Ok", "NoEcho"}
    rows = list(csv.DictReader(table.open()))
    assert [float(row["battery_v"]) for row in rows[-3:]] == [moment["battery_v"] for moment in told[-3:]]
    moments(rig, "--seconds", "1", "--plot", str(picture))
    drawn = cv2.imread(str(picture))
    assert drawn is not None
    assert drawn.shape[1] == 1800


def test_the_rover_moves_while_a_key_is_held_and_no_longer(rig: ServedRig) -> None:
    before = rig.ask("tape")["rover"]
    terminal, far = pty.openpty()
    command = [sys.executable, "-m", "rover.cli.main", "jog", "--port", rig.port]
    jog = subprocess.Popen(command, stdin=far, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    os.close(far)
    try:
        assert jog.stderr is not None
        while b"arrows drive" not in jog.stderr.readline():
            assert jog.poll() is None
        hold(terminal, "\x1b[A", 2.5)
        time.sleep(2.0)
        driven = rig.ask("tape")["rover"]
        time.sleep(1.0)
        assert apart(rig.ask("tape")["rover"], driven) < 0.003
        way = apart(driven, before)
        assert 0.05 < way < 0.4, way
        hold(terminal, "q", 2.0)
        time.sleep(1.5)
        turned = rig.ask("tape")["rover"]
        assert turned["heading_deg"] < driven["heading_deg"] - 5.0  # the left wheel alone: to the right
        os.write(terminal, b"\x1b")
        assert jog.wait(10.0) == 0
    finally:
        jog.kill()
        jog.wait()
        os.close(terminal)
    assert moments(rig, "--seconds", "0.5")[-1]["state"] == "Disarmed"


def apart(one: dict[str, float], other: dict[str, float]) -> float:
    """Metres."""
    return math.hypot(one["x"] - other["x"], one["y"] - other["y"])


def hold(terminal: int, key: str, seconds: float) -> None:
    """A key that the terminal repeats."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        os.write(terminal, key.encode())
        select.select([], [], [], 0.05)


def test_keys_that_come_in_one_go_are_told_apart() -> None:
    assert split_keys("\x1b[A\x1b[Dq x") == ["up", "left", "q", " ", "x"]
