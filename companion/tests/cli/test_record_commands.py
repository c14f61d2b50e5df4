"""`rover verify` and `rover compare` over folders as runs leave them."""

from __future__ import annotations

import json
from pathlib import Path

from rover.record.manifest import MANIFEST, manifest_bytes


def make_run(folder: Path, x: float) -> Path:
    folder.mkdir()
    place = {"id": 1, "class": "buried", "p": 0.9, "x": x, "y": 1.0, "sigma_m": 0.01}
    (folder / "summary.json").write_text(json.dumps({"detections": [place], "site": None}))
    (folder / MANIFEST).write_bytes(manifest_bytes(folder, ["summary.json"]))
    return folder


def test_verify_names_each_file_and_fails_for_one_that_changed(rover, tmp_path):
    run = make_run(tmp_path / "run", 1.0)
    done = rover("verify", run, "--json")
    assert done.code == 0
    document = json.loads(done.out)
    assert document["ok"] is True
    assert document["files"] == [{"name": "summary.json", "ok": True, "why": ""}]
    assert "not signed" in rover("verify", run).out
    (run / "summary.json").write_text("x")
    done = rover("verify", run)
    assert (done.code, done.out.splitlines()[0]) == (3, "FAILED summary.json has changed")


def test_verify_refuses_a_folder_without_a_manifest_in_one_line(rover, tmp_path):
    done = rover("verify", tmp_path)
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert "no manifest.json is there" in done.err


def test_compare_reads_two_runs(rover, tmp_path):
    first, second = make_run(tmp_path / "a", 1.0), make_run(tmp_path / "b", 1.3)
    document = json.loads(rover("compare", first, second, "--json").out)
    assert [len(document[name]) for name in ("new", "gone", "moved", "both")] == [0, 0, 1, 0]
    assert "moved  1: buried, p 0.90, at 1.00, 1.00 m, by 30 cm" in rover("compare", first, second).out


def test_compare_says_how_to_get_a_summary_of_a_run_that_was_cut_off(rover, tmp_path):
    done = rover("compare", tmp_path, tmp_path)
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert "see rover recover" in done.err
