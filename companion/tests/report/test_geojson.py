"""Results for a GIS: valid GeoJSON, and honest about coordinates that are no longitudes."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from rover.geometry import Pose2
from rover.outcome import RunStatus
from rover.report.geojson import geojson_name, projection, results_geojson
from rover.report.result import DetectionResult, GoalResult, Identities, MapLayers, RunResult
from rover.report.site import Georeference, Site

NONE = np.zeros((1, 1), bool)
DEPTH = {"Point": 0, "LineString": 1, "Polygon": 2}


@pytest.fixture
def result() -> RunResult:
    return RunResult(
        mission="strip",
        status=RunStatus.DONE,
        reason="all seen",
        duration=10.0,
        distance=1.0,
        area_width=3.0,
        area_height=4.0,
        launch=Pose2(0.4, 0.4, 0.0),
        path=np.array([[0.0, 0.4, 0.4], [4.0, 1.4, 0.4]]),
        layers=MapLayers((0.0, 0.0), 4.0, np.full((1, 1), 300.0, np.float32), ~NONE, NONE),
        identities=Identities("sitl", 1, "0.1.0"),
        detections=(
            DetectionResult(3, "buried", 0.8, 1.0, 2.0, 0.03, 5, 0.15, 4.0, True),
            DetectionResult(8, "surface", 0.9, 2.0, 1.0, 0.02, 9, 0.15, 5.0, False, "no way"),
        ),
        goals=(GoalResult(1, 2.0, 2.5, True),),
    )


def depth(coordinates: list[Any]) -> int:
    return 0 if isinstance(coordinates[0], float) else 1 + depth(coordinates[0])


def test_every_feature_is_valid_and_every_ring_closed_and_counter_clockwise(result: RunResult) -> None:
    collection = results_geojson(result)
    assert collection["type"] == "FeatureCollection"
    for feature in collection["features"]:
        geometry = feature["geometry"]
        assert feature["type"] == "Feature"
        assert depth(geometry["coordinates"]) == DEPTH[geometry["type"]]
        if geometry["type"] == "Polygon":
            (ring,) = geometry["coordinates"]
            assert ring[0] == ring[-1]
            assert sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(ring)) > 0


def test_every_indication_has_a_point_and_a_zone(result: RunResult) -> None:
    features = results_geojson(result)["features"]
    points = [f for f in features if f["properties"]["kind"] == "indication"]
    assert [(f["properties"]["id"], f["geometry"]["coordinates"]) for f in points] == [(3, [1.0, 2.0]), (8, [2.0, 1.0])]
    assert [f["properties"]["detection"] for f in features if f["properties"]["kind"] == "keep-out zone"] == [3, 8]


def test_local_coordinates_say_so(result: RunResult) -> None:
    assert results_geojson(result)["rover:frame"]["units"] == "metre"
    assert results_geojson(result)["rover:simulated"] is True


# Lengths of a degree of latitude and of longitude on WGS 84, kilometres, as tables give them.
DEGREES = ((0.0, 110.574, 111.320), (15.0, 110.649, 107.551), (45.0, 111.132, 78.847), (60.0, 111.412, 55.800))


@pytest.mark.parametrize(("latitude", "latitude_km", "longitude_km"), DEGREES)
def test_metres_become_degrees_of_the_ellipsoid(latitude: float, latitude_km: float, longitude_km: float) -> None:
    project = projection(Georeference(latitude, 20.0))
    assert project(0.0, 0.0) == [20.0, latitude]
    longitude, same = project(100.0, 0.0)
    assert same == latitude
    assert 0.1 / (longitude - 20.0) == pytest.approx(longitude_km, rel=1e-5)
    assert 0.1 / (project(0.0, 100.0)[1] - latitude) == pytest.approx(latitude_km, rel=1e-5)


def test_a_run_with_an_origin_is_a_map_of_the_world_and_one_without_is_none(result: RunResult) -> None:
    placed = replace(result, site=Site(origin=Georeference(60.0, 20.0)))
    collection = results_geojson(placed)
    assert "rover:frame" not in collection
    longitude, latitude = collection["features"][0]["geometry"]["coordinates"]
    assert (longitude, latitude) == (pytest.approx(20.0, abs=1e-4), pytest.approx(60.0, abs=1e-4))
    assert (geojson_name(placed), geojson_name(result)) == ("detections.geojson", "detections.local.json")


def test_the_bearing_turns_the_map_clockwise() -> None:
    # Map +y points east, so map +x points south: (1, 2) lies 2 m east and 1 m south.
    longitude, latitude = projection(Georeference(0.0, 0.0, 90.0))(1.0, 2.0)
    assert longitude * 111_320.0 == pytest.approx(2.0, abs=1e-3)
    assert latitude * 110_574.0 == pytest.approx(-1.0, abs=1e-3)
