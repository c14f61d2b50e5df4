"""A rover at the bench: single runs, by duty or by speed, and what was told meanwhile."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import field as listed

from rover.errors import RoverError
from rover.link.jogging import Wish, ramp
from rover.link.parameters import read_parameters, write_parameters
from rover.link.session import DRIVEABLE, STEP_S, Link
from rover.link.telemetry import Battery, FirmwareState, SonarRange, Telemetry, WheelMotion
from rover.motion.merge import run as whole_run
from rover.motion.segment import MIN_DURATION_US, Segment, State, evaluate

# Seconds from now at which a run starts, and for which the wheels are watched after its end.
START_S, ROLL_OUT_S = 0.15, 0.5
Q15 = 32767.0
# A segment lasts 16 s at most.
PIECE_S = 10.0
# Half of what it takes to come up to speed, microseconds.
RAMP_US = 400_000
# Duty follows the reference speed by this alone, so that a run is one of duty; see `Bench.by_duty`.
OPEN_LOOP = {
    "feed_static": 0,
    "feed_acceleration": 0,
    "gain_velocity": 0,
    "gain_integral": 0,
    "gain_position": 0,
    "stall_duty": 32767,
    "stall_time": 10_000,
    "following_error": 1_000_000,
    "guard_enabled": 0,
}
# Duty for each m/s of reference in such a run.
DUTY_PER_M_S = 2.0


@dataclass
class Run:
    """One run: what was commanded, and the wheels from its start on; times are seconds since then.

    cause: why the firmware ended it, "None" when it ran to its end.
    """

    segments: list[Segment]
    start: float
    wheels: list[WheelMotion] = listed(default_factory=list)
    cause: str = "None"

    def commanded(self, time: float) -> State:
        """The reference at a time since the start."""
        return evaluate(self.segments, State(), max(time, 0.0))

    @property
    def counts(self) -> tuple[int, int]:
        """Of both wheels, from the beginning to the end."""
        if not self.wheels:
            return 0, 0
        first, last = self.wheels[0], self.wheels[-1]
        return last.left_counts - first.left_counts, last.right_counts - first.right_counts


class Bench:
    """One rover on one link. Parameters that a step changes are put back by `restore`."""

    def __init__(self, link: Link) -> None:
        self.link = link
        self.before = read_parameters(link)
        link.set_telemetry_period("WheelTicks", 0.01)
        link.set_telemetry_period("Battery", 0.1)

    @property
    def track(self) -> float:
        """Between the wheels as the firmware believes, metres: it turns headings into ways with it."""
        return read_parameters(self.link, ["track"])["track"] * 1e-6

    def set(self, values: Mapping[str, int]) -> None:
        """Parameters in the board's memory. The motors are off then."""
        self.rest()
        write_parameters(self.link, values)

    def restore(self, keep: Mapping[str, int]) -> None:
        """Everything as it was before, but for `keep`."""
        wanted = {**self.before, **keep}
        there = read_parameters(self.link)
        self.set({name: value for name, value in wanted.items() if there.get(name) != value})

    def rest(self) -> None:
        """Motors off."""
        state = self.link.state
        if state is not None and state.state in DRIVEABLE:
            self.link.disarm()

    def by_duty(self, left: float, right: float, seconds: float) -> Run:
        """Both motors at a duty of nominal voltage, whatever the encoders say; call `open_loop` before."""
        speeds = left / DUTY_PER_M_S, right / DUTY_PER_M_S
        return self.by_speed(Wish(0.5 * sum(speeds), (speeds[1] - speeds[0]) / self.track), seconds)

    def open_loop(self) -> None:
        """From here on duty follows the reference and nothing else."""
        self.set({**OPEN_LOOP, "feed_velocity": round(DUTY_PER_M_S * Q15)})

    def by_speed(self, wish: Wish, seconds: float) -> Run:
        """Up to a speed, on for so long, down to rest."""
        up, down = ramp(wish, RAMP_US), ramp(Wish(-wish.travel, -wish.heading), RAMP_US)
        cruise = [Segment(round(PIECE_S * 1e6), 0, 0)] * int(seconds // PIECE_S)
        rest_us = round((seconds - PIECE_S * len(cruise)) * 1e6)
        cruise += [Segment(rest_us, 0, 0)] if rest_us >= MIN_DURATION_US else []
        return self.run(whole_run([*up, *cruise, *down]))

    def run(self, segments: list[Segment]) -> Run:
        """From rest to rest. The motors are off before and after. Raises PreflightFailed when it does not arm."""
        link = self.link
        link.arm()
        link.poll()  # what was told while it was not armed yet
        start = link.clock.now() + START_S
        end = link.stream.begin(segments, start) + ROLL_OUT_S
        done = Run(segments, start)
        try:
            while link.clock.now() < end:
                for event in self.wait(STEP_S):
                    if isinstance(event, WheelMotion) and event.time >= start - 0.05:
                        done.wheels.append(WheelMotion(event.time - start, event.left_counts, event.right_counts))
                    elif isinstance(event, FirmwareState) and event.state not in DRIVEABLE:
                        done.cause = event.cause
                if done.cause != "None":
                    end = min(end, link.clock.now() + ROLL_OUT_S)
        finally:
            self.rest()
        return done

    def wait(self, seconds: float) -> list[Telemetry]:
        """What is told in that time."""
        events: list[Telemetry] = []
        end = self.link.clock.now() + seconds - 1e-9
        while self.link.clock.now() < end:
            self.link.clock.advance(min(self.link.clock.now() + STEP_S, end + 1e-9))
            events += self.link.poll()
        return events

    def voltage(self, seconds: float = 1.0) -> float | None:
        """Mean of the battery's voltage as the board has it; None when it tells none."""
        told = [event.voltage for event in self.wait(seconds) if isinstance(event, Battery)]
        return sum(told) / len(told) if told else None

    def ranges(self, seconds: float = 1.2) -> list[list[SonarRange]]:
        """What each sensor says for a while: left, centre, right."""
        found: list[list[SonarRange]] = [[], [], []]
        for event in self.wait(seconds):
            if isinstance(event, SonarRange) and event.sensor < len(found):
                found[event.sensor].append(event)
        return found


class StepFailed(RoverError):
    """A step has found something that only hands can put right; the message says what."""

    exit_code = 3
