"""The folder of a run: complete files, strict JSON, the keys of the contract, the same bytes for the same run."""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rover.report.result import Localization, RunResult, Safety
from rover.report.site import Georeference, Site
from rover.report.write import write_run

from companion.tests.report.sample_run import make_result

FILES = {"summary.json", "map.png", "report.html", "detections.local.json", "detections.csv"}
CONTRACT = {
    "status", "duration_s", "distance_m", "detections", "goals", "collisions", "keepout_violations",
    "unseen_ground_m2", "min_clearance_m", "localization", "out",
}  # fmt: skip


def strict(path: Path) -> dict[str, Any]:
    def refuse(word: str) -> None:
        raise ValueError(f"{path.name}: {word} is no JSON")

    document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)
    return document


@pytest.fixture(scope="module")
def folder(result: RunResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("runs") / "made" / "here"
    write_run(result, out)
    return out


def test_all_files_are_there_and_nothing_temporary(folder: Path) -> None:
    assert {path.name for path in folder.iterdir()} == FILES


def test_the_summary_has_the_keys_of_the_contract(folder: Path, result: RunResult) -> None:
    summary = strict(folder / "summary.json")
    assert summary.keys() >= CONTRACT
    assert all(entry.keys() >= {"id", "class", "p", "x", "y", "sigma_m"} for entry in summary["detections"])
    assert all(entry.keys() >= {"id", "x", "y", "reached"} for entry in summary["goals"])
    assert summary["localization"].keys() >= {"ate_rmse_m", "odometry_only_ate_rmse_m"}
    assert [entry["id"] for entry in summary["detections"]] == [d.id for d in result.detections]


def test_numbers_that_json_lacks_become_null(tmp_path: Path) -> None:
    odd = make_result(safety=Safety(0, 0, 0.0, float("inf"), 0), localization=Localization(final_sigma=float("nan")))
    write_run(replace(odd, detections=(replace(odd.detections[0], sigma=float("inf"), thumbnail=None),)), tmp_path)
    summary = strict(tmp_path / "summary.json")
    assert summary["min_clearance_m"] is None
    assert summary["localization"]["final_sigma_m"] is None
    assert strict(tmp_path / "detections.local.json")["features"][0]["properties"]["sigma_m"] is None


def test_with_an_origin_the_results_are_those_of_a_gis(tmp_path: Path) -> None:
    write_run(make_result(site=Site(origin=Georeference(50.1, 8.7))), tmp_path)
    assert "rover:frame" not in strict(tmp_path / "detections.geojson")
    assert not (tmp_path / "detections.local.json").exists()
    assert strict(tmp_path / "summary.json")["site"]["origin"] == [50.1, 8.7]


def test_the_report_holds_the_map_that_lies_beside_it(folder: Path) -> None:
    data = base64.b64encode((folder / "map.png").read_bytes()).decode()
    assert data in (folder / "report.html").read_text(encoding="utf-8")


def test_the_same_run_gives_the_same_bytes_in_place_of_the_old_ones(folder: Path, tmp_path: Path) -> None:
    for name in FILES:
        (tmp_path / name).write_text("from an earlier run, and longer than nothing")
    write_run(make_result(), tmp_path)
    for name in sorted(FILES):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name


def test_a_file_that_cannot_be_written_costs_itself_alone(tmp_path: Path) -> None:
    (tmp_path / "map.png").mkdir()  # nothing can be put in its place
    (lost,) = write_run(make_result(), tmp_path)
    assert lost.startswith(f"{tmp_path / 'map.png'} was not written: ")
    assert {path.name for path in tmp_path.iterdir()} == FILES


def test_a_write_that_fails_leaves_the_old_file_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "map.png").write_bytes(b"old")

    def full(number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    lost = write_run(make_result(), tmp_path)
    assert len(lost) == len(FILES)
    assert all(line.endswith("was not written: No space left on device") for line in lost)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"map.png": b"old"}
