"""The comparison with MAVLink 2 measures what it says."""

from __future__ import annotations

import pytest

from tools.bench import protocol


@pytest.mark.parametrize("side", [protocol.Rover, protocol.Mavlink])
def test_what_is_encoded_is_decoded(side: type[protocol.Rover] | type[protocol.Mavlink]) -> None:
    source, feed = side(), side.decoder()
    assert [len(feed(source.sonar(number))) for number in range(50)] == [1] * 50


def test_garbage_costs_the_rover_one_frame_at_most() -> None:
    result = protocol.resync(protocol.Rover, seed=3, trials=200)
    assert result.frames_lost_worst <= 1
    assert result.bytes_worst <= framed_sonar()


def framed_sonar() -> int:
    return len(protocol.Rover().sonar(1))


def test_the_same_seed_gives_the_same_figures() -> None:
    first, second = (protocol.resync(protocol.Mavlink, seed=5, trials=20) for _ in range(2))
    assert first == second


def test_a_line_with_bit_errors_loses_about_the_frames_that_were_hit() -> None:
    share = protocol.through_noise(protocol.Rover, seed=1, frames=2000)
    # 120 bits a frame at 1e-4, and the frame behind a zero that was hit or made.
    assert 0.97 < share < 0.995


def test_segments_take_less_than_a_tenth_of_set_points() -> None:
    segments, setpoints = protocol.motion_rates()
    assert segments < setpoints / 10


def test_a_segment_is_two_can_frames_and_at_most_32_bytes_on_the_serial_line() -> None:
    line, frames = protocol.segment_cost()
    assert line <= 32
    assert frames <= 2


def test_every_row_has_the_table_s_columns() -> None:
    rows = [*protocol.byte_rows(), *protocol.noise_rows(seed=1, trials=5, frames=20), *protocol.time_rows(20, 1)]
    assert len(rows) == 12
    assert {line.count("|") for line in (*protocol.HEAD, *rows)} == {5}
