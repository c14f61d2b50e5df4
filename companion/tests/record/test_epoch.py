"""A record has a date: of the system's clock on a real rover, of the mission file on a simulated rig."""

from __future__ import annotations

import time
from datetime import date

from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from rover.record.epoch import NO_EPOCH, Epoch, epoch_of, simulated_epoch, system_epoch
from rover.record.log_reader import Log
from rover.record.recording import Recording


def test_a_simulated_day_is_the_mission_files_and_its_hour_the_suns():
    # The sun stands over 15 degrees east an hour earlier than over Greenwich.
    epoch = simulated_epoch(date(2026, 5, 4), 13 * 3600.0, 15.0)
    assert epoch.utc(0.0) == "2026-05-04T12:00:00Z"
    assert epoch.local(90.0) == "2026-05-04T13:01:30+01:00"


def test_a_simulated_day_that_nobody_named_is_one_on_which_nobody_drove():
    assert simulated_epoch(None, 0.0, None).utc(0.0).startswith("2000-")


def test_the_systems_clock_counts_back_to_the_missions_zero():
    epoch = system_epoch(100.0)
    assert abs(epoch.utc_ns * 1e-9 + 100.0 - time.time()) < 5.0
    assert epoch.source.startswith("system clock, ")


@given(
    st.builds(
        Epoch,
        st.integers(0, 4 * 10**18),
        st.integers(-14 * 3600, 14 * 3600),
        st.text(st.characters(codec="utf-8"), min_size=1),
    )
)
def test_a_log_gives_back_the_epoch_that_it_was_told(epoch):
    assert epoch_of(epoch.metadata()) == epoch


def test_a_log_that_says_nothing_or_nonsense_of_its_epoch_has_none():
    assert epoch_of(None) == NO_EPOCH
    assert epoch_of({"utc_ns": "soon", "local_offset_s": "0", "source": "x"}) == NO_EPOCH


def test_stamps_in_a_file_are_real_times_and_read_back_as_mission_time(tmp_path):
    epoch = simulated_epoch(date(2026, 5, 4), 3600.0, None)
    path = tmp_path / "mission.mcap"
    with Recording(path, {"seed": "1"}, epoch) as recording:
        recording.log(1.25, "info", "here")
    with path.open("rb") as stream:
        _, _, message = next(iter(make_reader(stream).iter_messages()))
    assert message.log_time == epoch.utc_ns + 1_250_000_000
    log = Log(path)
    assert log.epoch == epoch
    assert [entry.time_ns for entry in log.messages()] == [1_250_000_000]
