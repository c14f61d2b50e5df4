"""A minute or two of the fault campaign: `python -m tools.chaos` has no end of them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_binary

from tools.chaos.campaign import Campaign

pytestmark = [pytest.mark.slow, pytest.mark.rig("sitl")]


@pytest.fixture(scope="module")
def campaign() -> Iterator[Campaign]:
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    with Campaign(seed=20_260) as made:
        yield made


@pytest.mark.parametrize("number", range(8))
def test_no_file_makes_a_command_fail_otherwise_than_in_one_line(campaign: Campaign, number: int) -> None:
    done = campaign.one(number, "hostile file")
    assert done.trial.wrong == [], done.trial.did


@pytest.mark.parametrize(("number", "kind"), [(100, "kill -9"), (103, "frozen")])
def test_whatever_happens_to_a_mission_little_is_lost_and_one_line_says_what(
    campaign: Campaign, number: int, kind: str
) -> None:
    done = campaign.one(number, kind)
    assert done.trial.wrong == [], done.trial.did


def test_a_damaged_run_is_read_as_far_as_it_goes(campaign: Campaign) -> None:
    done = campaign.one(200, "damaged run")
    assert done.trial.wrong == [], done.trial.did
