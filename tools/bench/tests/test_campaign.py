"""What a folder of missions comes to: everything is counted, also what was never finished."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import pytest
from rover.errors import BadInput

from tools.bench.campaign import main
from tools.chaos.damage import DAMAGES


def write(folder: Path, seed: int, collisions: int, over: bool, contrast: float = 0.96) -> None:
    run = folder / f"seed-{seed}"
    run.mkdir()
    summary = {
        "status": "done", "collisions": collisions, "bumper_contacts": 1, "keepout_violations": 0,
        "unseen_ground_m2": 0.0, "surveyed_m2": 11.0, "area_m2": 12.0, "duration_s": 200.0, "distance_m": 1.0,
        "mines": {"mines": 1, "found": 0, "with_contrast": 1, "with_contrast_found": 0, "false": 0},
    }  # fmt: skip
    truth = {"verdict": {"mines": [{"driven_over": over, "contrast_k": contrast}]}}
    (run / "summary.json").write_text(json.dumps(summary))
    (run / "truth.json").write_text(json.dumps(truth))
    way = "".join(f"{0.01 * step} {0.005 * step} 0 0 0 0 0 1\n" for step in range(200))
    (run / "truth.tum").write_text(way)


def test_missions_are_counted_with_their_interval_and_mines_that_hardly_show_are_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path, 9, 0, True)
    write(tmp_path, 10, 2, False)
    write(tmp_path, 11, 0, True, contrast=0.3)
    assert main([str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "Seeds 9 to 11" in said
    assert "wheel over a mine of at least 0.5 K | 1 of 3: 0.33 [0.01, 0.91]" in said
    assert "collision (harder than 0.1 m/s) | 1 of 3" in said
    assert "collisions, bumper contacts | 2, 3" in said
    # Two tyres, a metre, 25 mm: 0.05 m² on 11 m².
    assert "per m² surveyed | 0.004" in said


def test_a_mission_without_a_result_is_named_and_no_success(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path, 1, 0, False)
    (tmp_path / "seed-2").mkdir()
    assert main([str(tmp_path)]) == 1
    assert "without a result: seed-2" in capsys.readouterr().out
    with pytest.raises(BadInput, match="no seed-N"):
        main([str(tmp_path / "seed-2")])


@pytest.mark.parametrize("name", ["summary.json", "truth.json", "truth.tum"])
def test_a_damaged_result_is_named_in_one_line(tmp_path: Path, name: str) -> None:
    write(tmp_path, 1, 0, False)
    file = tmp_path / "seed-1" / name
    whole = file.read_bytes()
    refused = []
    for seed in range(15):
        random = Random(f"{name}/{seed}")
        file.write_bytes(random.choice(DAMAGES)(whole, random))
        try:
            main([str(tmp_path)])
        except BadInput as error:
            refused.append(str(error))
    assert len(refused) >= 3
    assert all("seed-1" in each and "\n" not in each for each in refused)
