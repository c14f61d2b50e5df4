"""What a companion that dies has left, and what is said when nothing more can be kept."""

from __future__ import annotations

import shutil
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from rover.mission import checkpoint
from rover.mission.checkpoint import PACKING_SHARE, PERIOD_S, RESERVE_BYTES, Checkpoint

CYCLE_S = 0.02


@pytest.fixture
def packed(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Stands for what the survey has learned: a number that grows with every look at it."""
    state = SimpleNamespace(taken=0, packing_s=0.0)

    def learned(_: object) -> SimpleNamespace:
        state.taken += 1
        content = str(state.taken).encode()

        def packed() -> dict[str, bytes]:
            begin = time.thread_time()
            while time.thread_time() - begin < state.packing_s:
                pass
            return {"survey.npz": content}

        return SimpleNamespace(packed=packed)

    monkeypatch.setattr(checkpoint, "learned", learned)
    return state


def drive(keeper: Checkpoint, seconds: float) -> str | None:
    """Calls it as a mission does, until it says something."""
    for cycle in range(round(seconds / CYCLE_S)):
        if keeper._written is not None:
            keeper._written.exception()  # virtual time is faster than a disk: wait for it
        said = keeper.keep(cycle * CYCLE_S)
        if said is not None:
            return said
    return None


def test_what_is_known_is_on_disk_at_most_ten_seconds_later(packed: SimpleNamespace, tmp_path: Path) -> None:
    with Checkpoint(None, tmp_path) as keeper:  # type: ignore[arg-type]
        for end in (12.0, 25.0, 60.0):
            assert drive(keeper, end) is None
    assert packed.taken >= 60.0 / PERIOD_S - 1
    assert 2 * PERIOD_S <= 10.0
    assert (tmp_path / "survey.npz").read_text() == str(packed.taken)
    assert [path.name for path in tmp_path.iterdir()] == ["survey.npz"]


def test_what_takes_long_to_pack_is_packed_less_often(packed: SimpleNamespace, tmp_path: Path) -> None:
    packed.packing_s = 0.2
    with Checkpoint(None, tmp_path) as keeper:  # type: ignore[arg-type]
        assert drive(keeper, 60.0) is None
    assert 4 <= packed.taken <= 60.0 / (packed.packing_s / PACKING_SHARE) + 1


def test_a_file_that_cannot_be_written_ends_the_mission(packed: SimpleNamespace, tmp_path: Path) -> None:
    (tmp_path / "survey.npz").mkdir()
    with Checkpoint(None, tmp_path) as keeper:  # type: ignore[arg-type]
        said = drive(keeper, 30.0)
    assert said is not None
    assert said.startswith(f"what has been surveyed cannot be written to {tmp_path}: ")


def test_a_mission_ends_before_the_disk_is_full(
    packed: SimpleNamespace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=RESERVE_BYTES - 1))
    with Checkpoint(None, tmp_path) as keeper:  # type: ignore[arg-type]
        said = drive(keeper, 30.0)
    assert said == f"the disk is nearly full: 32 MB are left for {tmp_path}"
