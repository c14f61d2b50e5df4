"""The folder of a run: its own, locked, and never at the cost of what lay there before."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import pytest
from rover.errors import BadInput
from rover.mission.run_folder import RUN_FILES, RunFolder, new_folder

NOW = datetime(2026, 5, 4, 9, 30, 15)


def fill(folder: Path, *names: str) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / name).write_text(f"old {name}")


def content(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def test_a_new_folder_is_named_by_date_time_and_mission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    first = new_folder("north/field 3", NOW)
    assert first == Path("runs/20260504-093015-north-field-3")
    first.mkdir(parents=True)
    assert new_folder("north/field 3", NOW) == Path("runs/20260504-093015-north-field-3-2")
    assert new_folder("...", NOW).name == "20260504-093015-mission"


def test_a_run_that_sets_off_has_its_folder(tmp_path: Path) -> None:
    with RunFolder(tmp_path / "a" / "b") as folder:
        folder.rig_log.write_text("ready")
        folder.accept()
        folder.rig_log.open("a").write(", driving")
    assert content(tmp_path / "a" / "b") == {"rig.log": "ready, driving"}


def test_a_run_that_does_not_set_off_leaves_nothing(tmp_path: Path) -> None:
    with RunFolder(tmp_path / "a" / "b") as folder:
        folder.rig_log.write_text("it cannot start")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_was_there_before_stays_there(tmp_path: Path) -> None:
    with RunFolder(tmp_path):
        pass
    assert tmp_path.is_dir()


@pytest.mark.parametrize("name", ["summary.json", "holiday.jpg", ".hidden"])
def test_a_folder_that_holds_anything_is_refused(tmp_path: Path, name: str) -> None:
    fill(tmp_path, name)
    with pytest.raises(BadInput, match=r"is not empty; name a new folder, or replace the run"):
        RunFolder(tmp_path)
    assert content(tmp_path) == {name: f"old {name}"}


def test_with_force_only_what_a_run_made_goes(tmp_path: Path) -> None:
    fill(tmp_path, *RUN_FILES, "notes.txt", "map.jpg")
    with RunFolder(tmp_path, force=True) as folder:
        folder.accept()
    assert set(content(tmp_path)) == {"notes.txt", "map.jpg"}


def test_with_force_nothing_goes_before_the_check_has_passed(tmp_path: Path) -> None:
    fill(tmp_path, *RUN_FILES)
    with RunFolder(tmp_path, force=True) as folder:
        folder.rig_log.write_text("it cannot start")
    assert content(tmp_path) == {name: f"old {name}" for name in RUN_FILES}


def test_two_runs_cannot_have_one_folder(tmp_path: Path) -> None:
    with RunFolder(tmp_path):
        for force in (False, True):
            with pytest.raises(BadInput, match="another run is writing there"):
                RunFolder(tmp_path, force)
    with RunFolder(tmp_path):
        pass


def test_what_cannot_be_a_folder_is_said_to_be_none(tmp_path: Path) -> None:
    fill(tmp_path, "file")
    for path in (tmp_path / "file", tmp_path / "file" / "under"):
        with pytest.raises(BadInput, match=r"--out .*: cannot be made a folder: "):
            RunFolder(path)
