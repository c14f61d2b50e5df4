"""A log into a board on a port, in real time and in its test mode: recorded wheels, echoes and commands go in.

A board's clock and the wire's delays are its own, so not every tick can be compared. Compared is what must not depend
on them: the states that it goes through with their causes, how many segments it takes, and how far its commanded
motion leads. Tokens, indices and start times are moved to those of the board. The motors stay off.
"""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from typing import Any

from rover.errors import BadInput, PreflightFailed
from rover.record.difference import NOTHING, Difference
from rover.record.log_reader import Log
from rover.record.rig_step import RigStep
from rover_protocol import framing, messages
from rover_protocol.rig_tick import NO_SENSOR, TickRequest

from rover_hil.device.bench import TEST_KEY, TEST_MODE_FLAG
from rover_hil.device.talk import DeviceTalk
from rover_hil.named_values import named_values
from rover_hil.replay.firmware import Compared

# Ticks between two reports of the wheels: at full speed ten counts, of which two reports make no jump.
SLICE = 5

FORWARDED = ("KeepAlive", "Stop", "EmergencyStop", "Disarm", "SegmentTravel", "SegmentHeading")
SENSORS_EVERY = 10
# A log begins at power-on; a board may be in any of these before it is armed.
FIRST_STATES = ("Boot", "Disarmed", "Latched")

# Battery of a board before the log's first tick.
FULL_MV = 7400

# Of ReferenceDistance, in its units: the last report may be one rounding away.
DISTANCE_TOLERANCE = 2


class DeviceReplay:
    """One board under a log's inputs. Raises PreflightFailed, LinkLost, BadInput."""

    def __init__(self, log: Log, port: str) -> None:
        if log.metadata["mission"]["transport"] != "serial":
            raise BadInput(f"{log.path}: recorded over CAN: a board gets logs of the serial line only")
        self._log = log
        self._talk = DeviceTalk(port)
        # A new one each time: the log's keep-alives count from its beginning.
        self._session = secrets.randbelow(1 << 16)
        self._host = framing.Decoder()
        self._rover = framing.Decoder()
        self._recorded: dict[str, list[dict[str, Any]]] = {}
        self._index_offset = self._clock_offset = 0
        self._arm_token: int | None = None
        self._next_token = 0
        self._slices = 0

    def run(self, on_time: Callable[[float], None]) -> Compared:
        """Through the whole log in real time."""
        try:
            self._prepare()
            begin = time.monotonic()
            for step in self._log.steps():
                self._take(step, begin)
                on_time(step.now_us * 1e-6)
            self._talk.wait(0.3)
            return self._compare()
        except TimeoutError as error:
            raise PreflightFailed(str(error)) from error
        finally:
            self._talk.send("Disarm")
            self._talk.close()

    def _prepare(self) -> None:
        talk = self._talk
        talk.send("Hello", schema_hash=messages.SCHEMA_HASH, session=self._session)
        talk.until("HelloBuild", lambda m: m["accepted"] == 1, 2.0)
        talk.send("Disarm")
        talk.until("State", lambda m: m["state"] in FIRST_STATES, 2.0)
        talk.send("TestMode", enable=1, key=TEST_KEY)
        state = talk.until("State", lambda m: bool(m["flags"] & TEST_MODE_FLAG), 1.0)
        self._next_token = state["arm_token"]
        talk.send("InjectSensors", battery=FULL_MV, emergency_stop=0, sonar=NO_SENSOR, echo=0, bumper=0)
        self._index_offset = talk.until("MotionStatus", lambda m: True, 1.0)["next_index"]
        talk.send("ClockRequest", sequence=1)
        self._clock_offset = talk.until("ClockReply", lambda m: m["sequence"] == 1, 1.0)["receive_time"]
        talk.forget()

    def _take(self, step: RigStep, begin: float) -> None:
        """Commands at the step's beginning, as the companion's left; sensors as time goes on."""
        self._note(step)
        commands = [(identifier, payload) for identifier, _, payload in self._host.feed(step.to_firmware)]
        for first in range(0, len(step.requests), SLICE):
            due = begin + (step.start_us + 1000 * first) * 1e-6
            self._talk.wait(max(0.0, due - time.monotonic()))
            for identifier, payload in commands:
                self._forward(identifier, payload)
            commands = []
            for request in step.requests[first : first + SLICE]:
                tick = TickRequest.unpack(request)
                if tick.echo_sensor != NO_SENSOR:
                    self._sense(tick, tick.echo_sensor, tick.echo_us)
            if self._slices % SENSORS_EVERY == 0:
                self._sense(tick, NO_SENSOR, 0)
            self._slices += 1
            self._talk.send("InjectWheels", left=tick.encoder_left, right=tick.encoder_right)
            self._talk.receive()

    def _sense(self, tick: TickRequest, sensor: int, echo_us: int) -> None:
        switches = {"emergency_stop": tick.emergency_stop, "bumper": tick.bumper}
        self._talk.send("InjectSensors", battery=tick.battery_mv, sonar=sensor, echo=echo_us, **switches)

    def _forward(self, identifier: int, payload: bytes) -> None:
        message, fields = messages.decode(identifier, payload)
        raw = {key: int(value) for key, value in fields.items()}
        if "index" in raw:
            raw["index"] = (raw["index"] + self._index_offset) & 0xFFFF
        if message.name == "SegmentStart":
            raw["start_time"] = (raw["start_time"] + self._clock_offset) & 0xFFFF_FFFF
        elif message.name == "Arm":
            if raw["token"] != self._arm_token:
                self._arm_token = raw["token"]
                self._next_token = (self._next_token + 1) & 0xFFFF
            raw["token"], raw["session"] = self._next_token, self._session
        elif message.name not in FORWARDED:
            return
        self._talk.send(message.name, **raw)

    def _note(self, step: RigStep) -> None:
        """What the recorded firmware has said."""
        for identifier, _, payload in self._rover.feed(step.from_firmware):
            message, fields = messages.decode(identifier, payload)
            told = {**named_values(message, fields), "at": step.now_us * 1e-6}
            self._recorded.setdefault(message.name, []).append(told)

    def _compare(self) -> Compared:
        recorded, replayed = _course(self._recorded.get("State", [])), _course(self._talk.all("State"))
        count = 0
        for index in range(max(len(recorded), len(replayed))):
            before = recorded[index] if index < len(recorded) else None
            now = replayed[index] if index < len(replayed) else None
            if before is None or now is None or before[:2] != now[:2]:
                at = before[2] if before else recorded[-1][2] if recorded else 0.0
                shown = [f"{state[0]}, {state[1]}" if state else NOTHING for state in (before, now)]
                return Compared(count, Difference("State", at, "state", *shown))
            count += 1
        checks = (("MotionStatus", "next_index", 0), ("ReferenceDistance", "travel", DISTANCE_TOLERANCE),
                  ("ReferenceDistance", "heading", DISTANCE_TOLERANCE))  # fmt: skip
        for name, key, tolerance in checks:
            said = self._recorded.get(name, []), self._talk.all(name)
            if not all(said):
                continue
            before, now = (values[-1][key] - values[0][key] for values in said)
            if abs(before - now) > tolerance:
                return Compared(count, Difference(name, said[0][-1]["at"], key, before, now))
            count += 1
        return Compared(count, None)


def _course(states: list[dict[str, Any]]) -> list[tuple[str, str, float]]:
    """States with their causes as they followed each other from the first arming on, and the times of recorded ones."""
    course: list[tuple[str, str, float]] = []
    armed = False
    for state in states:
        armed = armed or state["state"] not in FIRST_STATES
        if armed and (not course or course[-1][:2] != (state["state"], state["cause"])):
            course.append((state["state"], state["cause"], state.get("at", 0.0)))
    return course
