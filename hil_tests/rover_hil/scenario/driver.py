"""The companion of a scripted drive: the real link and the real motion, with a list of legs in place of a mission."""

from __future__ import annotations

import math
from collections import deque

from rover.errors import LinkLost, PreflightFailed, SafetyStop
from rover.link.clock import Clock
from rover.link.frames import FrameTransport
from rover.link.session import DRIVEABLE, Link
from rover.link.transport import Transport
from rover.motion.merge import merge, run
from rover.motion.profile import Axis, to_position
from rover.motion.segment import Segment, split
from rover.vehicle import Limits, Vehicle

from rover_hil.scenario.language import Drive, Move

CYCLE_S = 0.02
# Seconds of motion that are kept committed ahead, as a mission does.
HORIZON_S = 0.5

PIECE_US = 200_000
START_DELAY_S = 0.2
BETWEEN_LEGS_S = 0.1


class Killed(Exception):
    """The companion's process is gone."""


class Companion:
    """Drives, as long as it lives. `word` says how it fares, see `observation.py`."""

    def __init__(self, drive: Drive, transport: Transport | FrameTransport, clock: Clock, seed: int) -> None:
        self.link = Link(transport, clock, session=seed & 0xFFFF)
        self.word = "Starting"
        self.reason = ""
        self.hold = False
        self.re_arm = False
        self.armed_at: float | None = None
        self._drive = drive
        self._clock = clock
        self._legs = deque(drive.moves)
        self._pending: deque[Segment] = deque()
        self._not_before = 0.0

    @property
    def driving(self) -> bool:
        """False once nothing of the script is left, or the drive was given up."""
        return self.word in ("Starting", "Driving")

    def live(self, parameters: dict[int, int]) -> None:
        """From the handshake until the process is killed or the link's session is over."""
        try:
            self._prepare(parameters)
            while True:
                self._cycle()
        except Killed:
            self.word, self.reason = "Killed", "killed"
        except (LinkLost, PreflightFailed, SafetyStop) as error:
            self.word, self.reason = type(error).__name__, str(error)

    def _prepare(self, parameters: dict[int, int]) -> None:
        self.link.connect()
        for identifier, value in parameters.items():
            answer = self.link.set_parameter(identifier, value)
            if answer.status != "Ok":
                raise PreflightFailed(f"parameter {identifier} = {value}: {answer.status}")
        if self._drive.arm:
            self.link.arm()
        self.armed_at = self._clock.now()
        self.word = "Driving"

    def _cycle(self) -> None:
        self.link.poll()
        if self.re_arm:
            self._arm_again()
        state = self.link.state
        if self._drive.arm and self.word == "Driving" and state is not None and state.state not in DRIVEABLE:
            self.word, self.reason = "SafetyStop", f"the firmware stopped: {state.cause}"
            self._pending.clear()
        if self.word == "Driving":
            self._stream(self._clock.now())
        self._clock.advance(self._clock.now() + CYCLE_S)

    def _arm_again(self) -> None:
        self.re_arm = False
        self._pending.clear()
        try:
            self.link.arm()
        except PreflightFailed as refusal:
            self.reason = str(refusal)
        else:
            self.word = "Driving"
            self._not_before = self._clock.now()

    def _stream(self, now: float) -> None:
        stream = self.link.stream
        if self.hold:
            return
        if not self._pending and stream.all_done and now >= max(stream.end_time, self._not_before) + BETWEEN_LEGS_S:
            self._next_leg(now)
            return
        while self._pending and stream.end_time - now < HORIZON_S:
            stream.extend([self._pending.popleft()])

    def _next_leg(self, now: float) -> None:
        if not self._legs:
            self.word = "Done"
            if self._drive.disarm:
                self.link.disarm()
            return
        move = self._legs.popleft()
        if move.kind == "pause_s":
            self._not_before = now + move.amount
            return
        self._pending = deque(split(leg_segments(move, self._drive.speed), PIECE_US))
        self.link.stream.begin([self._pending.popleft()], now + START_DELAY_S)
        while self._pending and self.link.stream.end_time - now < HORIZON_S:
            self.link.stream.extend([self._pending.popleft()])


def leg_segments(move: Move, speed: float) -> list[Segment]:
    """One leg from rest to rest."""
    vehicle = Vehicle()
    if move.kind == "turn_deg":
        return run(merge(None, to_position(Axis(), math.radians(move.amount), vehicle.heading)))
    limits = Limits(speed, vehicle.travel.acceleration, vehicle.travel.jerk)
    return run(merge(to_position(Axis(), move.amount, limits), None))
