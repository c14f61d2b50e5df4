"""A board in its test mode: its wheels follow what it commands, its sensors say what the test wants. Nothing moves.

The motors' bridges stay off in test mode whatever the firmware's state is, so these tests may run on a rover that
stands on a desk.
"""

from __future__ import annotations

import secrets
import time
from typing import Any

from rover.vehicle import Vehicle
from rover_protocol import messages

from rover_hil.device.talk import DeviceTalk

TEST_KEY = 0x5445
TEST_MODE_FLAG = 1 << 4
BEGIN, REST = 1, 2
KEEP_ALIVE_PERIOD_S = 0.02
WHEELS_PERIOD_S = 0.01
SENSORS_PERIOD_S = 0.05
REFERENCE_PERIOD_MS = 10
# In one report of the wheels: two may come within one millisecond, and more than 32 counts there are a jump.
MAX_COUNTS = 12

NO_SONAR = 255
START_LEAD_US = 400_000
RAMP_US, RAMP_JERK = 500_000, 320_000
"""µs and µm/s³: two of them lead from rest to 0.08 m/s."""
SPEED_M_S = 0.08


class Bench:
    """One board. `alive`: it gets keep-alives. Voltage, emergency stop and echoes are what is injected."""

    def __init__(self, port: str) -> None:
        self.talk = DeviceTalk(port)
        self.talk.work = self._work
        self.alive = False
        self.injecting = False
        self.wheels_follow = True
        self.battery_v = 7.4
        self.emergency_stop = False
        self.echoes_m: dict[int, float | None] = {}
        # The board compares keep-alives with those of a companion of the same session.
        self.session = secrets.randbelow(1 << 16)
        self._counter = 0
        self._counts = [0, 0]
        self._base: tuple[int, int] | None = None
        self._due = {"alive": 0.0, "wheels": 0.0, "sensors": 0.0}

    def hello(self, flip: int = 0, session: int | None = None) -> dict[str, Any]:
        """The handshake's answer, HelloBuild; `flip` makes our schema another one."""
        session = self.session if session is None else session
        for _ in range(10):
            self.talk.send("Hello", schema_hash=messages.SCHEMA_HASH ^ flip, session=session)
            try:
                return self.talk.until("HelloBuild", lambda m: m["session"] == session, 0.3)
            except TimeoutError:
                continue
        raise TimeoutError(f"{self.talk.port}: no answer to the handshake: is this the rover's port?")

    def settle(self) -> None:
        """Whatever was before: disarmed or latched, out of test mode, handshake done, telemetry as by default."""
        self.hello()
        self.talk.send("Disarm")
        self.state("Disarmed", "Latched")
        # While the motors were on the board belonged to whoever had armed it.
        self.hello()
        self.talk.send("TestMode", enable=0)
        self.talk.until("State", lambda m: not m["flags"] & TEST_MODE_FLAG, 1.0)
        self.talk.forget()

    def enter_test_mode(self) -> None:
        """From here on nothing moves."""
        self.talk.send("TelemetryRate", message=messages.ReferenceDistance.ID, period=REFERENCE_PERIOD_MS)
        self.talk.send("TestMode", enable=1, key=TEST_KEY)
        self.injecting = True
        self.talk.until("State", lambda m: bool(m["flags"] & TEST_MODE_FLAG), 1.0)

    def arm(self) -> None:
        """In test mode only. Raises TimeoutError when it is refused."""
        assert self.injecting, "a board is armed in test mode only"
        self.alive = True
        self.send_arm()
        self.state("Armed", "Moving")

    def send_arm(self, step: int = 1) -> None:
        """An Arm with the next token, or with the same one."""
        token = self.talk.until("State", lambda m: True, 1.0)["arm_token"]
        self.talk.send("Arm", token=(token + step) & 0xFFFF, session=self.session)

    def state(self, *names: str, seconds: float = 2.0) -> dict[str, Any]:
        """Waits for one of these states."""
        return self.talk.until("State", lambda m: m["state"] in names, seconds)

    def drive(self, cruise_s: float) -> float:
        """Sends a run ahead at 0.08 m/s; returns its length in metres."""
        first = self.talk.until("MotionStatus", lambda m: True, 1.0)["next_index"]
        start = self.clock() + START_LEAD_US
        self.talk.send("SegmentStart", index=first, start_time=start & 0xFFFF_FFFF)
        parts = [
            (RAMP_US, RAMP_JERK),
            (RAMP_US, -RAMP_JERK),
            (round(cruise_s * 1e6), 0),
            (RAMP_US, -RAMP_JERK),
            (RAMP_US, RAMP_JERK),
        ]
        for ahead, (duration, jerk) in enumerate(parts):
            index = (first + ahead) & 0xFFFF
            flags = BEGIN * (ahead == 0) | REST * (ahead == len(parts) - 1)
            self.talk.send("SegmentTravel", index=index, duration=duration, jerk_travel=jerk)
            self.talk.send("SegmentHeading", index=index, jerk_heading=0, flags=flags)
        return SPEED_M_S * (cruise_s + 2e-6 * RAMP_US)

    def clock(self) -> int:
        """The firmware's clock, µs."""
        self.talk.send("ClockRequest", sequence=7)
        return int(self.talk.until("ClockReply", lambda m: m["sequence"] == 7, 1.0)["receive_time"])

    def close(self) -> None:
        """Disarms and lets the port go."""
        self.alive = self.injecting = False
        self.talk.send("Disarm")
        self.talk.close()

    def _work(self) -> None:
        now = time.monotonic()
        if self.alive and self._is_due("alive", now, KEEP_ALIVE_PERIOD_S):
            self._counter = (self._counter + 1) & 255
            self.talk.send("KeepAlive", counter=self._counter)
        if not self.injecting:
            return
        if self._is_due("wheels", now, WHEELS_PERIOD_S):
            self._follow()
        if self._is_due("sensors", now, SENSORS_PERIOD_S):
            self._sense()

    def _is_due(self, what: str, now: float, period: float) -> bool:
        if now < self._due[what]:
            return False
        self._due[what] = now + period
        return True

    def _follow(self) -> None:
        """Wheels that have gone where the firmware's reference is."""
        vehicle, references = Vehicle(), self.talk.all("ReferenceDistance")
        wanted = list(self._counts)
        if references and self.wheels_follow:
            travel, heading = references[-1]["travel"] * 1e-5, references[-1]["heading"] * 1e-6
            ways = (travel - heading * vehicle.track_width / 2.0, travel + heading * vehicle.track_width / 2.0)
            at = tuple(round(way / vehicle.metres_per_count) for way in ways)
            self._base = self._base or (at[0] - self._counts[0], at[1] - self._counts[1])
            wanted = [at[0] - self._base[0], at[1] - self._base[1]]
        while True:
            for wheel in (0, 1):
                step = wanted[wheel] - self._counts[wheel]
                self._counts[wheel] += max(-MAX_COUNTS, min(MAX_COUNTS, step))
            self.talk.send("InjectWheels", left=self._counts[0], right=self._counts[1])
            if self._counts == wanted:
                return

    def _sense(self) -> None:
        common = {"battery": round(self.battery_v * 1000.0), "emergency_stop": int(self.emergency_stop), "bumper": 0}
        for sensor, distance in self.echoes_m.items():
            echo = 0 if distance is None else round(2e6 * distance / 343.0)
            self.talk.send("InjectSensors", sonar=sensor, echo=echo, **common)
        if not self.echoes_m:
            self.talk.send("InjectSensors", sonar=NO_SONAR, **common)
