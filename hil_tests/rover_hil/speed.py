"""How fast a rig runs: simulated seconds for each second of real time, armed and driving, without a companion's work.

python -m rover_hil.speed [--rig sitl|emulator] [--seconds 20] [--camera]

Without vision the camera takes no pictures; `--camera` has it take them, 8.3 a second. `real` counts the seconds of a
clock on the wall, `processor` those that rig and firmware have computed: on a loaded machine the second one tells.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from rover.errors import RoverError

from rover_hil.serve import RIGS
from rover_hil.testing.firmware_talk import FirmwareTalk
from rover_hil.testing.rigs import Client, RunningRig, start_rig

# As often as a keep-alive must be sent, with a margin of three to the dead-man.
STEP_US = 100_000
# Seconds of driving ahead before something stands in the way.
DRIVE_S = 1.5


@dataclass(frozen=True)
class Moment:
    """Seconds: simulated, on the wall, and computed by the rig and its firmware."""

    simulated: float
    real: float
    processor: float

    def speed_since(self, before: Moment) -> dict[str, float]:
        """Simulated seconds for each second of either clock."""
        simulated = self.simulated - before.simulated
        processor = max(self.processor - before.processor, 1.0 / _TICKS_PER_SECOND)
        return {
            "real": round(simulated / (self.real - before.real), 2),
            "processor": round(simulated / processor, 2),
        }


_TICKS_PER_SECOND = os.sysconf("SC_CLK_TCK")


def _computed(pid: int) -> float:
    """Seconds of user and system time of a process (proc(5), fields 14 and 15)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_PER_SECOND


def _moment(running: RunningRig, now_us: int) -> Moment:
    computed = _computed(running.process.pid) + _computed(running.firmware_pid)
    return Moment(now_us * 1e-6, time.perf_counter(), computed)


def _pass(client: Client, talk: FirmwareTalk, now_us: int, seconds: float) -> int:
    """Lets time pass with keep-alives; returns the new time."""
    end_us = now_us + round(seconds * 1e6)
    while now_us < end_us:
        now_us += STEP_US
        reply, _ = client.ask(op="advance", to_us=now_us, host_bytes=talk.keep_alive())
        if reply["marks"]:
            talk.read_exactly(reply["marks"][-1][1] - talk.bytes_read)
    return now_us


def measure(rig: str, seconds: float, pictures: bool = False) -> dict[str, object]:
    """Speeds in simulated seconds a second. Raises RuntimeError when the rover does not drive."""
    with tempfile.TemporaryDirectory() as folder:
        options = () if pictures else ("--no-camera",)
        running = start_rig(Path(folder) / "control", "--rig", rig, *options)
        try:
            client = running.client()
            client.ask(op="hello")
            with FirmwareTalk(running.port) as talk:
                now_us = talk.arm_and_drive_ahead(client)
                begin = _moment(running, now_us)
                now_us = _pass(client, talk, now_us, DRIVE_S)
                if talk.newest("State")["state"] != "Moving":
                    raise RuntimeError(f"the rover does not drive: {talk.newest('State')}")
                driven = _moment(running, now_us)
                now_us = _pass(client, talk, now_us, 2.0)
                stopped = _moment(running, now_us)
                now_us = _pass(client, talk, now_us, seconds)
                end = _moment(running, now_us)
        finally:
            running.stop()
    driving, standing = driven.speed_since(begin), end.speed_since(stopped)
    return {"rig": rig, "pictures": pictures, "driving": driving, "standing": standing}


def main(argv: list[str] | None = None) -> int:
    """Prints one line of JSON; returns the exit code."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m rover_hil.speed", description=__doc__, formatter_class=raw)
    parser.add_argument("--rig", choices=tuple(RIGS), default="emulator")
    parser.add_argument("--seconds", type=float, default=20.0, help="of standing, simulated")
    parser.add_argument("--camera", action="store_true", help="pictures are taken")
    given = parser.parse_args(argv)
    try:
        print(json.dumps(measure(given.rig, given.seconds, given.camera)))
    except (RoverError, RuntimeError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
