"""Specification: which hours show mines, by soil, season, latitude and clouds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rover.cli.main import invoke
from rover.errors import BadInput
from rover_hil.commands.when import spans, summary, text
from rover_hil.ground.season import Season
from rover_hil.outlook import EXAMPLE, Site, outlook, read_site

DAY = """[site]
soil = "{soil}"
latitude_deg = {latitude}
date = "{date}"
"""


def written(folder: Path, soil: str = "loam", latitude: float = 45.0, date: str = "2026-06-21", more: str = "") -> Path:
    file = folder / "site.toml"
    file.write_text(DAY.format(soil=soil, latitude=latitude, date=date) + more)
    return file


def test_the_sun_is_higher_in_summer_and_near_the_equator_and_weaker_under_clouds() -> None:
    noon = Season().irradiance(12.0)
    assert Season(day_of_year=355).irradiance(12.0) < 0.5 * noon
    assert Season(latitude_deg=60.0).irradiance(12.0) < noon < Season(latitude_deg=23.0).irradiance(12.0)
    assert 0.2 * noon < Season(cloud=1.0).irradiance(12.0) < 0.3 * noon
    assert Season(latitude_deg=-45.0, day_of_year=355).irradiance(12.0) == pytest.approx(noon, rel=0.01)


def test_days_are_long_in_summer() -> None:
    hours = np.arange(0.0, 24.0, 0.1)
    longest, equinox = (np.mean(Season(day_of_year=day).irradiance(hours) > 0.0) * 24.0 for day in (172, 81))
    assert longest == pytest.approx(15.4, abs=0.3)
    assert equinox == pytest.approx(12.0, abs=0.3)


def test_a_covered_sky_is_nearly_as_warm_as_the_air() -> None:
    clear, covered = Season(), Season(cloud=1.0)
    assert float(clear.air(12.0) - clear.sky(12.0)) == pytest.approx(18.0, abs=1.0)
    assert 0.0 < float(covered.air(12.0) - covered.sky(12.0)) < 4.0


@pytest.mark.parametrize("soil", ["loam", "clay"])
def test_two_hours_show_deep_mines_much_better_than_the_best_one(soil: str) -> None:
    day = outlook(Site(soil, (0.05, 0.07), Season()))
    for depth in (0, 1):
        pair = day.best_pair(depth)
        gain = day.pair[depth][pair] / day.single[depth].max()
        assert 1.4 < gain < 2.0
        morning, afternoon = day.hour[list(pair)]
        assert 5.0 <= morning <= 9.0
        assert 14.0 <= afternoon <= 18.0
        night, noon = np.searchsorted(day.hour, (1.0, 12.0)).tolist()
        assert day.pair[depth, night, noon] < 0.75 * day.pair[depth][pair]


def test_two_visits_never_tell_less_than_either() -> None:
    day = outlook(Site("clay", (0.02, 0.05), Season(cloud=0.5)))
    apart = ~np.eye(len(day.hour), dtype=bool)
    either = np.maximum(day.single[:, :, None], day.single[:, None, :])
    assert (day.pair[:, apart] >= either[:, apart] - 1e-9).all()


def test_deeper_mines_are_seen_at_fewer_hours_and_under_clouds_hardly_any() -> None:
    depths = (0.0, 0.02, 0.05, 0.10)
    clear, covered = (outlook(Site("loam", depths, Season(cloud=cloud))).seen().sum(axis=1) for cloud in (0.0, 1.0))
    assert (np.diff(clear) <= 0).all()
    assert clear[0] > 24
    assert clear[-1] == 0
    assert covered[1:].sum() < 0.5 * clear[1:].sum()


def test_the_command_s_answer_is_what_the_model_says(tmp_path: Path) -> None:
    told = summary(outlook(read_site(written(tmp_path, more="depths_cm = [0, 5]\n"))))
    assert json.loads(json.dumps(told)) == told
    surface, deep = told["depths"]
    assert surface["d_prime"] > 3.0 * deep["d_prime"]
    assert [row["seen_to_cm"] is not None for row in told["hours"]].count(True) == len(surface["hours_seen"])
    assert "5 cm: best at" in text(told)
    assert spans(["00:00", "00:30", "01:00", "12:30"]) == "00:00 to 01:00, 12:30 to 12:30"
    assert spans([]) == "none"


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"soil": "mud"}, r"soil: .*mud.* is not one of dry-sand"),
        ({"latitude": 91.0}, r"latitude_deg: 91.* lies outside -66 to 66"),
        ({"date": "21 June"}, r"date: '21 June' is not a date like"),
        ({"more": "air_c = [20, 10]\n"}, r"air_c: 20 is the lowest"),
        ({"more": "depths_cm = []\n"}, r"depths_cm: 1 to 12 depths"),
        ({"more": "moon = 1\n"}, r"moon: unknown key"),
    ],
)
def test_a_mistake_in_the_file_is_one_line(tmp_path: Path, change: dict[str, Any], told: str) -> None:
    with pytest.raises(BadInput, match=told):
        read_site(written(tmp_path, **change))


def test_the_example_is_the_one_in_the_docs_and_another_day_gives_another_outlook(tmp_path, capfd):
    shipped = Path(__file__).resolve().parents[2] / "docs" / "examples" / "site.toml"
    assert shipped.read_text() == EXAMPLE
    told = {}
    for day in ("2026-06-21", "2026-12-21"):
        assert invoke(["when", str(shipped), "--date", day, "--json"]) == 0
        told[day] = json.loads(capfd.readouterr().out)
    for document in told.values():
        assert document["best"] in [hour["time"] for hour in document["hours"]]
        assert document["best_pair"] == sorted(document["best_pair"])
    assert told["2026-06-21"]["hours"] != told["2026-12-21"]["hours"]
