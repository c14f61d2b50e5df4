"""A campaign tells how often something happens, with its bounds, and loses no mission."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rover.errors import BadInput
from rover.mission.config import load
from rover_hil.campaign import rates, store
from rover_hil.campaign.file import EXAMPLE, Campaign, Distribution, load_campaign
from rover_hil.campaign.intervals import binomial_interval, poisson_interval, upper_bound
from rover_hil.campaign.trial import draw, figures, mission_text

TINY = """
[mission]
name = "tiny"
max_duration_s = 8
[area]
width_m = 1.3
height_m = 1.3
[launch]
x_m = 0.4
y_m = 0.4
[field]
rocks = 0
grass = 0
surface_mines = 0
buried_mine_depths_cm = []
"""
CAMPAIGN = """
[campaign]
mission = "tiny.toml"
missions = 3
strata = ["mission.time_of_day"]
[draw]
"mission.time_of_day" = { choice = ["10:00", "15:00"] }
"area.width_m" = { uniform = [1.3, 1.5] }
"""


@pytest.fixture
def write(tmp_path: Path):
    def campaign(text: str = CAMPAIGN) -> Campaign:
        (tmp_path / "tiny.toml").write_text(TINY)
        (tmp_path / "campaign.toml").write_text(text)
        return load_campaign(tmp_path / "campaign.toml")

    return campaign


def row(index: int, **more: object) -> dict[str, object]:
    common = {"index": index, "seed": index, "status": "done", "reason": "", "field.rocks": index % 3, "coverage": 0.99}
    return {**common, "mines_with_contrast": 2, "mines_with_contrast_found": 2, "mines_false": 0, "area_m2": 12.0,
            "inside_95": 0.95, **more}  # fmt: skip


def test_the_example_is_a_campaign(write):
    campaign = write(EXAMPLE)
    assert (campaign.missions, campaign.strata) == (16, ("field.world",))
    assert len(draw(campaign)) == 16


@pytest.mark.parametrize("sampling", ["sobol", "random"])
def test_the_same_file_draws_the_same_missions_each_with_a_seed_of_its_own(write, sampling):
    text = CAMPAIGN.replace("missions = 3", f'missions = 64\nsampling = "{sampling}"')
    trials = draw(write(text))
    assert trials == draw(write(text))
    assert len({trial.seed for trial in trials}) == 64
    times = [trial.values["mission.time_of_day"] for trial in trials]
    assert 16 <= times.count("10:00") <= 48
    assert all(1.3 <= trial.values["area.width_m"] <= 1.5 for trial in trials)


def test_a_drawn_mission_is_a_mission_file(write, tmp_path):
    campaign = write()
    trial = draw(campaign)[0]
    (tmp_path / "drawn.toml").write_bytes(mission_text(campaign, trial))
    assert load(tmp_path / "drawn.toml").area.width == trial.values["area.width_m"]


@given(st.floats(0.0, 1.0, exclude_max=True), st.integers(-5, 5), st.integers(0, 9))
def test_a_whole_number_is_drawn_from_both_ends_and_between(u, low, more):
    value = Distribution("x", low=low, high=low + more, whole=True).at(u)
    assert isinstance(value, int)
    assert low <= value <= low + more


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('"field.rock" = { integer = [1, 2] }', "is no key of a mission file"),
        ('"field.rocks" = { integer = [1, 2], choice = [1] }', "takes one of choice, uniform and integer"),
        ('"field.rocks" = { integer = [2, 1] }', "2 lies above 1"),
        ('"field.rocks" = { integer = [1.5, 2] }', "whole numbers"),
        ('"field.rocks" = { choice = [] }', "list of values"),
    ],
)
def test_a_mistake_in_the_file_is_one_line(write, line, says):
    with pytest.raises(BadInput, match=says):
        write(CAMPAIGN + line + "\n")


def test_intervals_are_those_of_the_textbooks():
    # Hanley and Lippman-Hand's rule of three, and Garwood's interval of no event.
    assert upper_bound(0, 2000) == pytest.approx(3.0 / 2000, rel=5e-3)
    assert binomial_interval(0, 20)[1] == pytest.approx(0.1684, abs=1e-4)
    assert binomial_interval(20, 20)[0] == pytest.approx(1.0 - 0.1684, abs=1e-4)
    assert poisson_interval(0, 2.0)[1] == pytest.approx(3.6889 / 2.0, abs=1e-4)


def test_no_event_hides_in_a_mean():
    rows = [row(index) for index in range(18)]
    rows += [row(18, collisions=1), row(19, status="crashed", mines_with_contrast=None)]
    found = rates.rates(rows)
    assert (found["collision"]["count"], found["collision"]["of"]) == (1, 20)
    assert found["no end"]["count"] == 1
    assert sum(map(rates.failed, rows)) == 2
    assert [each["index"] for each in rates.worst(rows, 0.0)] == [18, 19] or [19, 18]
    strata = rates.by_stratum(rows, ["field.rocks"])
    assert {name: rate["collision"]["count"] for name, rate in strata.items()} == {
        "field.rocks = 0": 1, "field.rocks = 1": 0, "field.rocks = 2": 0
    }  # fmt: skip


def test_what_an_outcome_depends_on_comes_first():
    rows = [row(index, coverage=0.9 + 0.01 * (index % 3), duration_s=float(index * 7 % 30)) for index in range(30)]
    first = rates.sensitivity(rows, ["field.rocks"])[0]
    assert (first["outcome"], first["effect"]) == ("coverage", 1.0)
    assert first["p"] < 1e-6


def test_two_builds_are_compared_mission_by_mission():
    before, now = [row(k, collisions=1) for k in range(10)], [row(k, collisions=0) for k in range(10)]
    found = rates.against(now, before)
    assert found["collision"] == {"pairs": 10, "gone": 10, "new": 0, "p": 0.002, "real": True}
    assert rates.against(before, before)["collision"]["real"] is False


def test_a_mission_without_a_summary_has_a_row_with_its_last_words(write):
    trial = draw(write())[0]
    assert figures(trial, 1, b"", b"rover: unexpected error: X\n")["status"] == "crashed"
    assert figures(trial, None, b"", b"")["status"] == "timed out"
    assert figures(trial, 2, b"", b"rover: too full\n") == {
        **{"index": 0, "seed": trial.seed, "exit_code": 2, **trial.values},
        **{"status": "refused", "reason": "rover: too full"},
    }


def test_rows_survive_being_cut_off_and_belong_to_one_file(write, tmp_path):
    campaign, out = write(), tmp_path / "out"
    assert store.begin(out, campaign, go_on=False) == []
    store.append(out, row(0))
    with (out / store.ROWS).open("a") as file:
        file.write('{"index": 1, "stat')
    with pytest.raises(BadInput, match="--continue"):
        store.begin(out, campaign, go_on=False)
    assert [each["index"] for each in store.begin(out, campaign, go_on=True)] == [0]
    other = write(CAMPAIGN.replace("missions = 3", "missions = 4"))
    with pytest.raises(BadInput, match="no rows of this campaign file"):
        store.begin(out, other, go_on=True)


@pytest.mark.slow
@pytest.mark.rig("sitl")
def test_a_campaign_on_ray_has_a_row_a_mission_and_goes_on_where_it_was_stopped(write, tmp_path):
    import pyarrow.parquet
    from rover_hil.campaign.conduct import conduct

    campaign, out = write(), tmp_path / "out"
    told = conduct(campaign, out, workers=2)
    assert (told["missions"], told["rates"]["no end"]["count"]) == (3, 0)
    table = pyarrow.parquet.read_table(out / store.PARQUET).to_pylist()
    assert [each["index"] for each in table] == [0, 1, 2]
    assert {each["status"] for each in table} <= {"done", "partial"}
    assert json.loads((out / "report.json").read_text())["rates"] == told["rates"]
    # The row that is missing is driven again, and comes out the same but for the computer's own time.
    rows = (out / store.ROWS).read_text().splitlines()
    lost = json.loads(rows.pop(1))
    (out / store.ROWS).write_text("\n".join(rows) + "\n")
    conduct(campaign, out, go_on=True, workers=1)
    again = {each["index"]: each for each in store.read_rows(out)}[lost["index"]]
    for key in ("wall_s", "processor_s"):
        lost.pop(key), again.pop(key)
    assert again == lost
