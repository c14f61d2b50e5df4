"""A run's folder is made when the rover may set off; an earlier run in it stays until then."""

from __future__ import annotations

from pathlib import Path

import pytest
from rover.errors import BadInput, PreflightFailed
from rover.mission.run_folder import RunFolder


def fail_to_start(folder: RunFolder) -> None:
    folder.starting_log.write_text("no firmware\n")
    raise PreflightFailed("the rig did not start")


def write_half_a_log(folder: RunFolder) -> None:
    folder.begin()
    (folder.path / "mission.mcap").write_text("log")
    raise RuntimeError("disk full")


def test_nothing_is_left_of_a_run_that_could_not_start(tmp_path: Path) -> None:
    out = tmp_path / "runs" / "field-1"
    with pytest.raises(PreflightFailed), RunFolder(out) as folder:
        fail_to_start(folder)
    assert list(tmp_path.iterdir()) == []


def test_an_earlier_run_stays_when_the_new_one_could_not_start(tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(PreflightFailed), RunFolder(tmp_path):
        raise PreflightFailed("camera")
    assert [file.name for file in tmp_path.iterdir()] == ["summary.json"]


def test_an_earlier_runs_files_go_when_the_new_one_begins_and_other_files_stay(tmp_path: Path) -> None:
    for name in ("summary.json", "report.html", "truth.tum", "rig.log", "notes.txt"):
        (tmp_path / name).write_text("earlier")
    with RunFolder(tmp_path) as folder:
        folder.starting_log.write_text("now")
        folder.begin()
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {"notes.txt": "earlier", "rig.log": "now"}


def test_what_a_run_has_written_stays_when_it_ends_by_an_error(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), RunFolder(tmp_path / "run") as folder:
        write_half_a_log(folder)
    assert (tmp_path / "run" / "mission.mcap").exists()


def test_a_file_in_its_place_is_one_clear_line(tmp_path: Path) -> None:
    (tmp_path / "run").write_text("")
    folder = RunFolder(tmp_path / "run")
    with pytest.raises(BadInput, match=r"--out .*run: cannot be made a folder: File exists"):
        folder.__enter__()
