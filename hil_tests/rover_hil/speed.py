"""How fast a rig runs: simulated seconds for each second of real time, armed and driving, without a companion's work.

python -m rover_hil.speed [--rig sitl|emulator] [--seconds 20]
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

from rover.errors import RoverError

from rover_hil.serve import RIGS
from rover_hil.testing.firmware_talk import FirmwareTalk
from rover_hil.testing.rigs import Client, start_rig

STEP_US = 20_000
KEEP_ALIVE_STEPS = 5
DRIVE = 1.5
"""Seconds of driving ahead before something stands in the way."""


def _pass(client: Client, talk: FirmwareTalk, now_us: int, seconds: float) -> tuple[int, float]:
    """Lets time pass with keep-alives; returns the new time and the speed."""
    end_us = now_us + round(seconds * 1e6)
    begin, first = time.perf_counter(), now_us
    written = talk.write_raw(b"")
    while now_us < end_us:
        if now_us // STEP_US % KEEP_ALIVE_STEPS == 0:
            written = talk.keep_alive()
        now_us += STEP_US
        reply, _ = client.ask(op="advance", to_us=now_us, host_bytes=written)
        if reply["marks"]:
            talk.read_exactly(reply["marks"][-1][1] - talk.bytes_read)
    return now_us, (now_us - first) / 1e6 / (time.perf_counter() - begin)


def measure(rig: str, seconds: float) -> dict[str, float | str]:
    """Speeds in simulated seconds a second. Raises RuntimeError when the rover does not drive."""
    with tempfile.TemporaryDirectory() as folder:
        running = start_rig(Path(folder) / "control", "--rig", rig)
        try:
            client = running.client()
            client.ask(op="hello")
            with FirmwareTalk(running.port) as talk:
                now_us = talk.arm_and_drive_ahead(client)
                now_us, driving = _pass(client, talk, now_us, DRIVE)
                if talk.newest("State")["state"] != "Moving":
                    raise RuntimeError(f"the rover does not drive: {talk.newest('State')}")
                now_us, _ = _pass(client, talk, now_us, 2.0)
                _, standing = _pass(client, talk, now_us, seconds)
        finally:
            running.stop()
    return {"rig": rig, "driving": round(driving, 2), "standing": round(standing, 2)}


def main(argv: list[str] | None = None) -> int:
    """Prints one line of JSON; returns the exit code."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m rover_hil.speed", description=__doc__, formatter_class=raw)
    parser.add_argument("--rig", choices=tuple(RIGS), default="emulator")
    parser.add_argument("--seconds", type=float, default=20.0)
    given = parser.parse_args(argv)
    try:
        print(json.dumps(measure(given.rig, given.seconds)))
    except (RoverError, RuntimeError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
