"""A V4L2 camera at the boundary where OpenCV hands frames over: formats, telemetry, the shutter, and going away.

The device is a fake with the interface of cv2.VideoCapture; no real camera was there.
"""

from __future__ import annotations

from itertools import islice

import cv2
import numpy as np
import pytest
from rover.capture.telemetry import split_telemetry
from rover.capture.v4l2 import GIVE_UP_AFTER, MAX_DELAY, Y16, CameraLost, V4l2Source
from rover.errors import BadInput


class Clock:
    """Time that passes only when somebody sleeps."""

    def __init__(self) -> None:
        self.now = 100.0
        self.slept: list[float] = []

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds


class FakeDevice:
    """Delivers what it was given; afterwards reads fail, as they do when a camera is unplugged."""

    def __init__(self, deliveries, opened=True, stamp_ms=0.0):
        self.deliveries, self.opened, self.stamp_ms = list(deliveries), opened, stamp_ms
        self.properties: dict[int, float] = {}
        self.released = False

    def isOpened(self):  # noqa: N802
        return self.opened

    def set(self, prop, value):
        self.properties[prop] = value
        return True

    def get(self, prop):
        return self.stamp_ms if prop == cv2.CAP_PROP_POS_MSEC else 0.0

    def read(self):
        return (True, self.deliveries.pop(0)) if self.deliveries else (False, None)

    def release(self):
        self.released = True


def source(devices, location="/dev/video3", clock=None):
    clock = clock or Clock()
    waiting = list(devices)
    opener = lambda _: waiting.pop(0) if waiting else FakeDevice([], opened=False)  # noqa: E731
    return V4l2Source(location, opener, clock, clock.sleep)


def picture(seed=0, shape=(120, 160)):
    return np.random.default_rng(seed).integers(29000, 31000, shape).astype(np.uint16)


def telemetry_words(counter=300, uptime_ms=90_000, ffc_ms=60_000, state=3, linear=1, resolution=1, agc=0):
    words = np.zeros(320, np.uint16)
    words[0] = 0x0E0E
    for at, value in ((1, uptime_ms), (3, state << 4 | agc << 12), (20, counter), (30, ffc_ms)):
        words[at], words[at + 1] = value & 0xFFFF, value >> 16
    words[24] = 30515
    words[160 + 48], words[160 + 49] = linear, resolution
    return words.reshape(2, 160)


def test_a_plain_y16_camera_gives_its_counts_and_is_told_to_convert_nothing():
    device = FakeDevice([picture(1), picture(2)])
    frames = list(islice(source([device]), 2))
    assert device.properties[cv2.CAP_PROP_FOURCC] == Y16
    assert device.properties[cv2.CAP_PROP_CONVERT_RGB] == 0
    np.testing.assert_array_equal(frames[1].counts, picture(2))
    assert [frame.sequence for frame in frames] == [0, 1]
    assert frames[0].kelvin_per_count == 0.01


@pytest.mark.parametrize("form", ["channel", "bytes"])
def test_other_forms_of_16_bits_are_the_same_picture(form):
    given = picture()
    delivered = given[:, :, None] if form == "channel" else given.astype("<u2").view(np.uint8).reshape(120, 160, 2)
    assert np.array_equal(next(iter(source([FakeDevice([delivered])]))).counts, given)


@pytest.mark.parametrize("wrong", [np.zeros((120, 160), np.uint8), np.zeros((120, 160, 3), np.uint8),
                                   np.zeros((1, 38400), np.uint16)])  # fmt: skip
def test_the_first_picture_must_be_16_bits_of_one_channel(wrong):
    with pytest.raises(BadInput, match=r"video3: delivers .*Y16"):
        next(iter(source([FakeDevice([wrong])])))


def test_a_picture_of_another_size_later_is_refused():
    with pytest.raises(BadInput, match="changed from 160×120 to 80×60"):
        list(source([FakeDevice([picture(), picture(1, (60, 80))])]))


@pytest.mark.parametrize("where", ["footer", "header"])
def test_telemetry_rows_are_taken_off_and_understood(where):
    rows = telemetry_words(counter=70_001, uptime_ms=90_000, ffc_ms=89_500, state=2)
    parts = [picture(), rows] if where == "footer" else [rows, picture()]
    frame = next(iter(source([FakeDevice([np.vstack(parts)])])))
    np.testing.assert_array_equal(frame.counts, picture())
    assert frame.ffc
    assert frame.since_ffc == pytest.approx(0.5)
    assert frame.kelvin_per_count == 0.01


def test_telemetry_says_what_counts_mean_unless_the_user_does():
    raw = np.vstack((picture(), telemetry_words(linear=0)))
    assert next(iter(source([FakeDevice([raw])]))).kelvin_per_count is None
    tenths = np.vstack((picture(), telemetry_words(resolution=0)))
    assert next(iter(source([FakeDevice([tenths])]))).kelvin_per_count == 0.1
    assert next(iter(source([FakeDevice([raw])], "0?unit=centikelvin"))).kelvin_per_count == 0.01


def test_the_camera_s_own_counter_shows_what_was_lost():
    """It counts at three times the rate of new pictures."""
    delivered = [np.vstack((picture(n), telemetry_words(counter=c))) for n, c in enumerate((300, 303, 312))]
    reader = source([FakeDevice(delivered)])
    assert [frame.sequence for frame in islice(reader, 3)] == [0, 1, 4]
    assert reader.lost == 2


def test_ordinary_pixels_do_not_pass_for_telemetry():
    for seed in range(50):
        whole, found = split_telemetry(picture(seed, (122, 160)))
        assert found is None
        assert whole.shape == (122, 160)
    assert split_telemetry(np.zeros((122, 160), np.uint16))[1] is None


def test_a_picture_that_repeats_was_taken_behind_the_shutter():
    frames = list(islice(source([FakeDevice([picture(1), picture(1), picture(2)])]), 3))
    assert [frame.ffc for frame in frames] == [False, True, False]


def test_time_is_the_driver_s_where_it_is_on_our_clock():
    assert next(iter(source([FakeDevice([picture()], stamp_ms=99_960.0)]))).time == pytest.approx(99.96)
    assert next(iter(source([FakeDevice([picture()], stamp_ms=5.0)]))).time == pytest.approx(100.0)


def test_a_camera_that_comes_back_goes_on_with_the_next_number():
    first, second = FakeDevice([picture(1)]), FakeDevice([picture(2)])
    gone = [FakeDevice([], opened=False) for _ in range(3)]
    reader = source([first, *gone, second])
    frames = list(islice(reader, 2))
    assert [frame.sequence for frame in frames] == [0, 1]
    assert reader.reconnects == 1
    assert first.released
    assert all(device.released for device in gone)


def test_a_camera_that_stays_away_ends_with_one_line_after_growing_waits():
    clock = Clock()
    reader = iter(source([FakeDevice([picture()])], clock=clock))
    next(reader)
    with pytest.raises(CameraLost, match="did not come back"):
        next(reader)
    assert clock.slept[:4] == pytest.approx([0.1, 0.2, 0.4, 0.8])
    assert max(clock.slept) == MAX_DELAY
    assert sum(clock.slept) < GIVE_UP_AFTER + MAX_DELAY


def test_no_camera_at_the_start_is_said_at_once():
    with pytest.raises(BadInput, match="/dev/video9: no camera can be opened"):
        next(iter(V4l2Source("9")))


@pytest.mark.parametrize(
    ("location", "says"),
    [("0?unit=celsius", "one of centikelvin"), ("0?size=160", "WIDTHxHEIGHT"), ("0?colour=1", "known: size=")],
)
def test_options_that_do_not_fit_are_named(location, says):
    with pytest.raises(BadInput, match=says):
        V4l2Source(location)


@pytest.mark.parametrize("location", ["/dev/video3", "/dev/video3?unit=centikelvin"])
def test_with_gain_control_on_counts_are_no_temperatures_whatever_else_is_said(location):
    delivered = np.vstack([picture(), telemetry_words(agc=1)])
    frame = next(iter(source([FakeDevice([delivered])], location)))
    assert frame.kelvin_per_count is None
    assert "AGC is on" in frame.doubt
    assert next(iter(source([FakeDevice([np.vstack([picture(), telemetry_words()])])], location))).doubt is None
