"""Mission files that the page makes, and what people say of indications."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from rover.console.judgement import MAX_NOTE, Verdict, judge, read_judgements
from rover.console.missions import Missions, document, rendered
from rover.console.runs import list_runs, run_document
from rover.console.sessions import Refused, Role, Session
from rover.errors import BadInput
from rover.mission.config import SHIPPED, load
from rover.mission.run_folder import RunFolder

ADA = Session("token", 1, "Ada", Role.OPERATOR, 0.0)


@pytest.fixture
def missions(tmp_path: Path) -> Missions:
    return Missions(tmp_path / "missions", tmp_path)


def demo() -> str:
    return (SHIPPED / "demo.toml").read_text(encoding="utf-8")


def test_a_mission_comes_out_as_it_went_in(missions: Missions) -> None:
    content = document(demo())
    assert document(rendered(content)) == content
    missions.save(rendered(content), "field-1")
    assert missions.names()["own"] == ["field-1"]
    assert missions.read("field-1")["document"] == missions.check(demo(), "field-1")["document"]


def test_what_is_kept_is_what_rover_run_reads(missions: Missions) -> None:
    content = document(demo()) | {"area": {"polygon": [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0]]}}
    told = missions.save(rendered(content), "triangle")
    assert load(missions.path("triangle")).area.polygon == ((0.0, 0.0), (3.0, 0.0), (3.0, 3.0))
    assert told["estimate"]["area_m2"] == pytest.approx(4.5, abs=0.1)


def test_what_rover_run_refuses_is_not_kept(missions: Missions) -> None:
    with pytest.raises(Refused, match="width_m"):
        missions.save("[area]\nwidth_m = 1e9\nheight_m = 2.0\n", "wide")
    assert missions.names()["own"] == []


@pytest.mark.parametrize("name", ["", ".", "..", "a/b", "a.b", "-a", "a" * 65, "a\n"])
def test_a_name_is_a_name(missions: Missions, name: str) -> None:
    with pytest.raises(Refused):
        missions.save(demo(), name)
    with pytest.raises(Refused):
        missions.path(name)


def test_the_pace_is_that_of_earlier_runs_or_unknown(missions: Missions, tmp_path: Path) -> None:
    assert missions.check(demo(), "a")["estimate"]["duration_s"] is None
    (tmp_path / "run").mkdir()
    summary = {"status": "done", "surveyed_m2": 6.0, "duration_s": 100.0, "coverage": 0.97}
    (tmp_path / "run" / "summary.json").write_text(json.dumps(summary))
    told = missions.check(demo(), "a")["estimate"]
    assert (told["duration_s"], told["coverage"], told["runs"]) == (200, 0.97, 1)


def test_too_much_is_no_mission() -> None:
    with pytest.raises(BadInput):
        document("#" * 300_000)


def test_judgements_are_kept_in_the_order_in_which_they_were_made(tmp_path: Path) -> None:
    judge(tmp_path, ADA, {"verdict": "rejected", "place": 3, "note": "a  can\n"}, {3})
    judge(tmp_path, ADA, {"verdict": "confirmed", "place": 3}, {3})
    judge(tmp_path, ADA, {"verdict": "marked", "x": 1.0, "y": 2}, set())
    read = read_judgements(tmp_path)
    assert [each["verdict"] for each in read] == ["rejected", "confirmed", "marked"]
    assert (read[0]["author"], read[0]["note"], read[0]["place"]) == ("Ada", "a can", 3)
    assert read[0]["utc"].endswith("Z")
    assert (read[2]["x"], read[2]["y"]) == (1.0, 2.0)


@pytest.mark.parametrize(
    "content",
    [
        {"verdict": "clear", "place": 3},
        {"verdict": "cleared", "place": 3},
        {"verdict": "safe", "place": 3},
        {"verdict": "confirmed"},
        {"verdict": "rejected", "place": 4},
        {"verdict": "rejected", "place": "3"},
        {"verdict": "marked"},
        {"verdict": "marked", "x": float("nan"), "y": 0.0},
        {"verdict": "marked", "x": True, "y": 0.0},
        {},
    ],
)
def test_nothing_else_can_be_said(tmp_path: Path, content: dict[str, Any]) -> None:
    with pytest.raises(Refused):
        judge(tmp_path, ADA, content, {3})
    assert read_judgements(tmp_path) == []


def test_no_verdict_says_anything_good_of_ground() -> None:
    assert {verdict.value for verdict in Verdict} == {"confirmed", "rejected", "marked"}


def test_a_line_that_was_cut_off_costs_no_other(tmp_path: Path) -> None:
    judge(tmp_path, ADA, {"verdict": "marked", "x": 1, "y": 1, "note": "n" * 9999}, set())
    with (tmp_path / "judgements.jsonl").open("a") as file:
        file.write('{"verdict": "rej')
    assert [len(each["note"]) for each in read_judgements(tmp_path)] == [MAX_NOTE]


def test_judgements_go_with_the_run_that_they_are_of(tmp_path: Path) -> None:
    judge(tmp_path, ADA, {"verdict": "marked", "x": 1, "y": 1}, set())
    with RunFolder(tmp_path, force=True) as folder:
        folder.accept()
    assert read_judgements(tmp_path) == []


def test_runs_are_told_apart_from_other_folders(tmp_path: Path) -> None:
    for name in ("one", "two", "missions", ".console"):
        (tmp_path / name).mkdir()
    (tmp_path / "one" / "mission.mcap").write_bytes(b"")
    (tmp_path / "two" / "summary.json").write_text('{"status": "done", "started_utc": "2026-01-01T00:00:00Z"}')
    assert {(run["name"], run["state"]) for run in list_runs(tmp_path)} == {("one", "interrupted"), ("two", "over")}
    assert run_document(tmp_path / "two")["utc"] == "2026-01-01T00:00:00Z"
    assert list_runs(tmp_path / "nothing") == []
