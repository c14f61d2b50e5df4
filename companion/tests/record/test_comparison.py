"""A journal against a log: equal runs are equal, and the first difference is named by topic, time and field."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.record.comparison import Comparison, Differs, RecordingOver
from rover.record.difference import first_field
from rover.record.journal import Journal
from rover.record.log_reader import Log
from rover.record.recording import Recording
from rover.record.rig_step import TICK_SIZE, pack_step, unpack_step

STOP = 16


def play(journal: Journal, x: float = 1.0, reason: int = 3, last: bool = True) -> None:
    """A short run."""
    counts = np.arange(120 * 160, dtype=np.uint16).reshape(120, 160)
    for step in range(200):
        journal.frame(step * 0.1 + 0.06, Frame(counts + step, step * 0.1, step, ffc=step == 7))
        journal.pose(step * 0.1 + 0.06, Pose2(0.0 if step < 150 else x, 0.0, 0.0))
    journal.link("tx", 20.0, STOP, bytes([reason]))
    if last:
        journal.log(20.0, "info", "done")


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "run.mcap"
    with Recording(path, {"seed": "1"}) as recording:
        recording.attach("mission.toml", "application/toml", b"[mission]\n")
        play(recording)
    return path


def test_the_same_run_is_equal(log: Path) -> None:
    comparison = Comparison(Log(log))
    play(comparison)
    comparison.finish()
    assert (comparison.messages, comparison.difference) == (202, None)


def test_frames_metadata_and_files_come_back_as_they_went_in(log: Path) -> None:
    read = Log(log)
    frames = list(read.frames())
    assert [frame.header["sequence"] for frame in frames] == list(range(200))
    assert [frame.header["sequence"] for frame in frames if frame.header["ffc"]] == [7]
    assert frames[3].header["exposure_us"] == 300_000
    assert np.frombuffer(frames[3].pixels, "<u2")[5] == 8
    assert (read.metadata, read.files) == ({"mission": {"seed": "1"}}, {"mission.toml": b"[mission]\n"})


@pytest.mark.parametrize(
    ("changes", "topic", "time", "field", "recorded", "replayed"),
    [
        ({"x": 1.5}, "/pose", 15.06, "pose.position.x", 1.0, 1.5),
        ({"reason": 4}, "/link/tx", 20.0, "Stop.reason", 3, 4),
    ],
)
def test_the_first_difference_is_named(
    log: Path, changes: dict[str, float], topic: str, time: float, field: str, recorded: float, replayed: float
) -> None:
    comparison = Comparison(Log(log))
    with pytest.raises(Differs):
        play(comparison, **changes)  # type: ignore[arg-type]
    found = comparison.difference
    assert found is not None
    assert (found.topic, found.field, found.recorded, found.replayed) == (topic, field, recorded, replayed)
    assert found.time == pytest.approx(time)


def test_a_run_that_ends_too_early_differs(log: Path) -> None:
    comparison = Comparison(Log(log))
    play(comparison, last=False)
    with pytest.raises(Differs):
        comparison.finish()
    assert comparison.difference is not None
    assert (comparison.difference.topic, comparison.difference.replayed) == ("/log", "nothing")


def test_a_log_that_was_cut_is_over_where_it_ends(log: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(log.read_bytes()[: log.stat().st_size // 2])
    comparison = Comparison(Log(cut))
    with pytest.raises(RecordingOver):
        play(comparison)
    assert 20 < comparison.messages < 200


def test_what_is_no_log_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("hello, this is no log at all")
    (tmp_path / "empty").touch()
    for name, said in (("text", "not an MCAP log"), ("empty", "empty"), ("none", "no such log")):
        with pytest.raises(BadInput, match=said):
            Log(tmp_path / name)


def test_a_step_of_a_rig_reads_back_and_a_damaged_one_does_not() -> None:
    ticks = bytes(range(TICK_SIZE)) * 3
    packed = pack_step(23_000, ticks, b"up", b"down")
    step = unpack_step(packed)
    assert (step.now_us, step.start_us, len(step.requests)) == (23_000, 20_000, 3)
    assert step.requests[1] + step.replies[1] == ticks[TICK_SIZE : 2 * TICK_SIZE]
    assert (step.to_firmware, step.from_firmware) == (b"up", b"down")
    assert [time for time, _ in step.marks()] == [21_000, 22_000, 23_000]
    for bad in (packed[:-1], packed + b"x", b"short"):
        with pytest.raises(ValueError, match="bytes"):
            unpack_step(bad)


def test_the_first_field_is_found_in_depth_and_missing_ones_count() -> None:
    assert first_field({"a": 1, "b": [{"c": 2}]}, {"a": 1, "b": [{"c": 3}]}) == ("b[0].c", 2, 3)
    assert first_field({"a": [1]}, {"a": [1, 2]}) == ("a[1]", None, 2)
    assert first_field({"a": 1}, {"a": 1}) is None
