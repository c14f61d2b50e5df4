"""Two surveys of one field: what is in both, what moved, and what one has that the other did not see."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Proj
from rover.errors import BadInput
from rover.mapping.map_server import StoredMap
from rover.report.site import Georeference
from rover.report.survey_difference import Survey, difference, read_survey

places = st.lists(
    st.tuples(st.integers(0, 3), st.integers(0, 3), st.sampled_from(("surface", "buried"))), unique=True, max_size=8
)


def entry(number: int, x: float, y: float, kind: str = "buried", sigma: float = 0.01) -> dict[str, object]:
    return {"id": number, "class": kind, "p": 0.9, "x": x, "y": y, "sigma_m": sigma}


def survey(*entries: dict[str, object], seen: bool = True, origin: Georeference | None = None) -> Survey:
    cells = np.full((200, 200), seen)
    ground = StoredMap(cells, np.zeros_like(cells), np.zeros_like(cells), 0.02, (0.0, 0.0))
    return Survey("a run", entries, ground, origin)


def test_a_place_within_three_sigma_is_the_same_and_further_off_it_has_moved():
    found = difference(survey(entry(1, 1.0, 1.0), entry(2, 3.0, 3.0)), survey(entry(7, 1.05, 1.0), entry(8, 3.3, 3.0)))
    assert [(pair["before"]["id"], pair["after"]["id"]) for pair in found["both"]] == [(1, 7)]
    assert [(pair["before"]["id"], pair["distance_m"]) for pair in found["moved"]] == [(2, 0.3)]
    assert found["new"] == found["gone"] == []


def test_a_thing_of_another_class_has_not_moved_there():
    found = difference(survey(entry(1, 1.0, 1.0)), survey(entry(2, 1.3, 1.0, "surface")))
    assert (len(found["new"]), len(found["gone"]), found["moved"]) == (1, 1, [])


def test_what_is_gone_where_nobody_looked_is_said_to_be_so():
    found = difference(survey(entry(1, 1.0, 1.0)), survey(seen=False))
    assert found["gone"] == [{**entry(1, 1.0, 1.0), "surveyed_after": False}]
    beyond_the_map = difference(survey(), survey(entry(1, 9.0, 1.0)))
    assert beyond_the_map["new"][0]["surveyed_before"] is False
    nobody_knows = Survey("a run", (), None, None)
    assert difference(nobody_knows, survey(entry(1, 1.0, 1.0)))["new"][0]["surveyed_before"] is None


@given(places, places)
def test_every_indication_stands_in_exactly_one_list(first, second):
    before = survey(*(entry(k, float(x), float(y), kind) for k, (x, y, kind) in enumerate(first)))
    after = survey(*(entry(k, float(x) + 0.2, float(y), kind) for k, (x, y, kind) in enumerate(second)))
    found = difference(before, after)
    pairs = found["both"] + found["moved"]
    assert sorted(p["before"]["id"] for p in pairs + [{"before": e} for e in found["gone"]]) == list(range(len(first)))
    assert sorted(p["after"]["id"] for p in pairs + [{"after": e} for e in found["new"]]) == list(range(len(second)))


@given(
    *(st.floats(-60.0, 60.0), st.floats(-179.0, 179.0), st.floats(-80.0, 80.0), st.floats(-80.0, 80.0)),
    *(st.floats(0.0, 360.0), st.floats(0.0, 360.0), st.floats(0.0, 20.0), st.floats(0.0, 20.0)),
)
def test_surveys_from_two_launches_meet_on_the_earth(latitude, longitude, east, north, bearing, other, x, y):
    """The second map's origin lies (east, north) metres beside the first one's; a library says where that is."""
    plane = Proj(proj="aeqd", lat_0=latitude, lon_0=longitude, ellps="WGS84")
    away_longitude, away_latitude = plane(east, north, inverse=True)
    first, second = Georeference(latitude, longitude, bearing), Georeference(away_latitude, away_longitude, other)
    # Bearings count clockwise from north: east and north of the place, then its x and y in the second map.
    c, s = math.cos(math.radians(bearing)), math.sin(math.radians(bearing))
    ahead, up = c * x + s * y - east, -s * x + c * y - north
    c, s = math.cos(math.radians(other)), math.sin(math.radians(other))
    found = difference(
        survey(entry(1, x, y), origin=first), survey(entry(2, c * ahead - s * up, s * ahead + c * up), origin=second)
    )
    assert [pair["distance_m"] <= 0.01 for pair in found["both"]] == [True]


def test_the_same_place_on_earth_in_a_map_that_is_turned_by_a_quarter():
    turned = Georeference(50.0, 8.0, 90.0)
    # Map +y of the second points east: what lies north of the first origin lies at -x there.
    found = difference(
        survey(entry(1, 0.0, 3.0), origin=Georeference(50.0, 8.0, 0.0)), survey(entry(2, -3.0, 0.0), origin=turned)
    )
    assert [pair["distance_m"] for pair in found["both"]] == [0.0]


def test_damage_is_one_line(tmp_path: Path):
    (tmp_path / "a").mkdir()
    for content in ("", "[]", "{}", '{"detections": [{"id": 1}]}', '{"detections": [1]}', "[" * 10_000):
        (tmp_path / "a" / "summary.json").write_text(content)
        with pytest.raises(BadInput, match="damaged"):
            read_survey(tmp_path / "a")
