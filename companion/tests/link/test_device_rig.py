"""The wall clock's rig: a grid of cycles, late ones counted, pictures on the companion's clock, all of it noted."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.capture.latest import LatestFrames
from rover.capture.v4l2 import CameraLost
from rover.errors import BadInput, LinkLost
from rover.link.clock import WallClock
from rover.link.device import DeviceRig, in_centikelvin
from rover.link.intake import Cycle
from rover.link.opening import open_frames
from rover.link.session import Link
from rover.record.device_cycle import pack_cycle, unpack_cycle

PERIOD = 0.02


class Camera:
    """Gives pictures until it is told to die."""

    def __init__(self, unit: float | None = 0.01) -> None:
        self.unit = unit
        self.middle = 2950
        self.dying = threading.Event()

    def __iter__(self) -> Iterator[Frame]:
        for number in range(1000):
            if self.dying.wait(0.01):
                raise CameraLost("/dev/video7: the camera went away")
            yield Frame(np.full((4, 4), self.middle + number % 2, np.uint16), time.monotonic(), number,
                        kelvin_per_count=self.unit)  # fmt: skip


@pytest.fixture
def camera() -> Camera:
    return Camera(unit=0.1)


@pytest.fixture
def cycles() -> list[Cycle]:
    return []


@pytest.fixture
def rig(pty_firmware, camera, cycles) -> Iterator[DeviceRig]:
    clock = WallClock()
    wire = open_frames(pty_firmware.port, clock=clock)
    with LatestFrames(camera) as latest:
        yield DeviceRig(wire, latest, clock, cycles.append)
    wire.close()


def turn(rig: DeviceRig) -> float:
    due = rig.next_cycle(PERIOD)
    rig.advance(due)
    return due


def test_time_stands_still_within_a_cycle_and_cycles_lie_on_a_grid(rig):
    begin = rig.now()
    dues = [turn(rig) for _ in range(5)]
    if rig.pace.overruns == 0:
        assert np.diff([begin, *dues]) == pytest.approx([PERIOD] * 5, abs=1e-9)
    now = rig.now()
    time.sleep(0.005)
    assert rig.now() == now == dues[-1]
    assert rig.lead() >= 0.005


def test_a_cycle_that_comes_late_is_counted_and_the_grid_begins_anew(rig):
    turn(rig)
    before = rig.pace.overruns
    time.sleep(3.5 * PERIOD)
    late = turn(rig)
    assert rig.pace.overruns == before + 1
    assert rig.pace.longest >= 3.5 * PERIOD
    assert rig.next_cycle(PERIOD) >= late + PERIOD - 1e-9


def test_pictures_have_the_companions_clock_and_kelvin_by_hundreds(rig):
    time.sleep(0.1)
    turn(rig)
    frames = list(rig.frames)
    assert frames
    for frame in frames:
        assert set(np.unique(frame.counts)) <= {29500, 29510}
        assert -0.2 < frame.time - rig.now() <= 0.02
        assert frame.time == round(frame.time * 1e6) * 1e-6


def test_a_camera_that_dies_is_remembered_and_gives_nothing_more(rig, camera):
    camera.dying.set()
    deadline = time.monotonic() + 3.0
    while rig.camera_failure is None and time.monotonic() < deadline:
        list(rig.frames)
        time.sleep(0.01)
    assert rig.camera_failure == "/dev/video7: the camera went away"
    assert list(rig.frames) == []


def test_a_driver_that_throws_anything_ends_the_pictures_and_not_the_mission(rig, camera):
    camera.unit = None
    time.sleep(0.1)
    assert list(rig.frames) == []
    assert "no temperatures" in (rig.camera_failure or "")


@pytest.mark.parametrize(("middle", "why"), [(800, "raw counts of 14 bits"), (3200, "change by +25 K"), (6000, "°C")])
def test_a_picture_that_cannot_be_ground_is_not_used_and_says_why(rig, camera, middle, why):
    time.sleep(0.1)
    assert all(not frame.ffc for frame in rig.frames)
    camera.middle = middle
    time.sleep(0.1)
    doubted = [frame for frame in rig.frames if frame.doubt]
    assert doubted
    assert all(frame.ffc for frame in doubted)
    assert why in doubted[0].doubt


def test_raw_counts_and_flames_are_no_pictures_of_ground():
    with pytest.raises(BadInput, match="no temperatures"):
        in_centikelvin(Frame(np.zeros((2, 2), np.uint16), 0.0, 0, kelvin_per_count=None))
    with pytest.raises(BadInput, match="more than"):
        in_centikelvin(Frame(np.full((2, 2), 9000, np.uint16), 0.0, 0, kelvin_per_count=0.1))


def test_what_came_in_is_noted_cycle_by_cycle_and_survives_the_log(rig, cycles):
    link = Link(rig.transport, rig)
    link.connect()
    for _ in range(20):
        turn(rig)
        link.poll()
    rig.finish()
    assert sum(len(data) for cycle in cycles for _, data in cycle.chunks) == link.figures().bytes_received > 500
    assert sum(cycle.sent for cycle in cycles) == link.figures().frames_sent
    assert sum(len(cycle.leads) for cycle in cycles) >= 3
    assert [unpack_cycle(pack_cycle(cycle)) for cycle in cycles] == cycles


def test_where_the_link_breaks_is_noted_too(rig, cycles, pty_firmware):
    link = Link(rig.transport, rig)
    link.connect()
    pty_firmware.pull()

    def live() -> None:
        for _ in range(100):
            turn(rig)
            link.poll()

    with pytest.raises(LinkLost):
        live()
    rig.finish()
    assert cycles[-1].failed in ("send", "receive")
    assert pty_firmware.port in cycles[-1].why
    assert unpack_cycle(pack_cycle(cycles[-1])) == cycles[-1]


@pytest.mark.parametrize("cut", [0, 7, 30])
def test_bytes_that_are_no_cycle_are_refused(cut):
    whole = pack_cycle(Cycle(1.5, chunks=[(1.4, b"abcdef")], leads=[0.001], why="x"))
    with pytest.raises(ValueError, match="does not hold"):
        unpack_cycle(whole[:cut])
