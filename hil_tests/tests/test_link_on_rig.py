"""The whole link with the real firmware: handshake, clock, motion, stop, and a rig that is torn away."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from rover.errors import LinkLost, RoverError
from rover.link.baud import DEFAULT_BAUD
from rover.link.rig import RigOptions, StartedRig, start_rig
from rover.link.session import Link
from rover.link.telemetry import MotorDuty, ReferenceDistance, Telemetry, WheelMotion
from rover.mission.config import load
from rover.motion.merge import merge, run
from rover.motion.profile import Axis, to_position
from rover.vehicle import Vehicle

pytestmark = pytest.mark.rig("sitl")


class Driven:
    """A rig, its virtual time and a connected link."""

    def __init__(self, process: StartedRig) -> None:
        self.process = process
        self.rig = process.connect(DEFAULT_BAUD)
        self.link = Link(self.rig.transport, self.rig)
        self.identity = self.link.connect()

    def run(self, seconds: float) -> list[Telemetry]:
        events: list[Telemetry] = []
        end = self.rig.now() + seconds
        while self.rig.now() < end:
            events += self.link.poll()
            self.rig.advance(self.rig.now() + 0.02)
        return events


@pytest.fixture
def transport() -> str:
    return "serial"


@pytest.fixture
def driven(tmp_path: Path, transport: str) -> Iterator[Driven]:
    try:
        process = start_rig(RigOptions(load("demo").path, seed=2, transport=transport), tmp_path / "rig.log")
    except RoverError as error:
        pytest.skip(f"the sitl rig does not start: {error}")
    rig = Driven(process)
    yield rig
    rig.rig.close()
    process.stop()


@pytest.mark.parametrize("transport", ["serial", "can"])
def test_a_run_is_driven_to_its_end_and_no_further(driven: Driven) -> None:
    assert driven.identity.board == "Sitl"
    driven.link.arm()
    segments = run(merge(to_position(Axis(), 0.25, Vehicle().travel), None))
    end = driven.link.stream.begin(segments, driven.rig.now() + 0.2)
    events = driven.run(end - driven.rig.now() + 0.5)
    assert driven.link.stream.all_done
    assert [e.travel for e in events if isinstance(e, ReferenceDistance)][-1] == pytest.approx(0.25, abs=2e-4)
    counts = [(e.left_counts + e.right_counts) / 2 for e in events if isinstance(e, WheelMotion)]
    assert counts[-1] * Vehicle().metres_per_count == pytest.approx(0.25, abs=0.005)
    figures = driven.link.figures()
    assert (figures.lost, figures.checksum_errors, figures.segments_repeated, figures.segments_rejected) == (0, 0, 0, 0)
    assert figures.segments_accepted == len(segments)


@pytest.mark.parametrize("transport", ["serial", "can"])
def test_the_firmwares_clock_is_known_within_its_tick(driven: Driven) -> None:
    driven.run(3.0)
    now = driven.rig.now()
    error = abs(driven.link.clock_estimate.to_firmware(now) * 1e-6 - now)  # the rig's clock is the firmware's
    assert error < 20e-6
    assert error < driven.link.clock_estimate.error_bound < 0.002


def test_a_stop_ends_motion_latches_and_is_rearmed(driven: Driven) -> None:
    driven.link.arm()
    segments = run(merge(to_position(Axis(), 0.6, Vehicle().travel), None))
    driven.link.stream.begin(segments, driven.rig.now() + 0.2)
    driven.run(1.2)
    assert driven.link.state is not None
    assert driven.link.state.state == "Moving"
    driven.link.stop(reason=9)
    driven.run(1.5)
    assert (driven.link.state.state, driven.link.state.cause, driven.link.state.cause_detail) == (
        "Latched",
        "StopCommand",
        9,
    )
    assert driven.link.stream.unacknowledged == 0
    driven.link.arm()
    again = run(merge(to_position(Axis(), 0.1, Vehicle().travel), None))
    end = driven.link.stream.begin(again, driven.rig.now() + 0.4)
    driven.run(end - driven.rig.now() + 0.4)
    assert driven.link.stream.all_done
    assert driven.link.figures().segments_rejected == 0
    assert driven.link.disarm()


def test_an_emergency_stop_cuts_the_motors_within_a_cycle(driven: Driven) -> None:
    driven.link.arm()
    segments = run(merge(to_position(Axis(), 0.6, Vehicle().travel), None))
    driven.link.stream.begin(segments, driven.rig.now() + 0.2)
    driven.run(1.2)
    driven.link.emergency_stop()
    at = driven.rig.now()
    events = driven.run(0.5)
    duties = [e for e in events if isinstance(e, MotorDuty) and e.time > at + 0.02]
    assert duties
    assert all(duty.left == duty.right == 0.0 for duty in duties)


def test_a_rig_that_is_torn_away_is_a_lost_link(driven: Driven) -> None:
    os.kill(driven.process.pid, signal.SIGKILL)
    with pytest.raises(LinkLost, match="link lost") as error:
        driven.run(2.0)
    assert "\n" not in str(error.value)
