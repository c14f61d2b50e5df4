"""KML and CSV are read back by readers that are not ours, with the right places to a centimetre."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from pyproj import Proj
from rover.record.epoch import simulated_epoch
from rover.report.imsma import COLUMNS, LEFT_EMPTY, detections_csv
from rover.report.kml import NAMESPACE, results_kml
from rover.report.result import RunResult
from rover.report.site import Georeference, Site
from shapely.geometry import shape

BEARING = 30.0
ORIGIN = Georeference(50.1, 8.7, BEARING)
KML = {"kml": NAMESPACE}


@pytest.fixture
def placed(result: RunResult) -> RunResult:
    site = Site("=north", "Org", "N. N.", ORIGIN)
    return replace(result, site=site, epoch=simulated_epoch(None, 3600.0, None), mission="a <b> & \x01")


def metres(longitude: float, latitude: float) -> tuple[float, float]:
    """Map x, y by a library's azimuthal projection around the origin."""
    east, north = Proj(proj="aeqd", lat_0=ORIGIN.latitude, lon_0=ORIGIN.longitude, ellps="WGS84")(longitude, latitude)
    c, s = math.cos(math.radians(BEARING)), math.sin(math.radians(BEARING))
    return c * east - s * north, s * east + c * north


def test_places_in_kml_are_right_to_a_centimetre(placed):
    root = ElementTree.fromstring(results_kml(placed))
    found = {}
    for mark in root.iterfind(".//kml:Placemark", KML):
        name = mark.findtext("kml:name", namespaces=KML)
        at = mark.findtext("kml:Point/kml:coordinates", namespaces=KML)
        if at and name.startswith("indication"):
            longitude, latitude = map(float, at.split(","))
            found[int(name.split()[1])] = metres(longitude, latitude)
    assert found.keys() == {d.id for d in placed.detections}
    for detection in placed.detections:
        assert math.dist(found[detection.id], (detection.x, detection.y)) < 0.01


def test_polygons_in_kml_are_closed_and_hold_their_area(placed):
    root = ElementTree.fromstring(results_kml(placed))
    areas = []
    for ring in root.iterfind(".//kml:LinearRing/kml:coordinates", KML):
        corners = [metres(*map(float, point.split(","))) for point in ring.text.split()]
        assert corners[0] == corners[-1]
        polygon = shape({"type": "Polygon", "coordinates": [corners]})
        assert polygon.is_valid
        areas.append(polygon.area)
    assert max(areas) == pytest.approx(placed.area_width * placed.area_height, rel=1e-3)


def test_a_kml_without_a_place_on_earth_is_not_made(result):
    with pytest.raises(ValueError, match="origin"):
        results_kml(result)


def test_the_table_has_the_published_fields_and_leaves_what_nobody_knows_empty(placed):
    rows = list(csv.DictReader(io.StringIO(detections_csv(placed).decode())))
    assert len(rows) == len(placed.detections)
    for row, detection in zip(rows, placed.detections, strict=True):
        assert tuple(row) == COLUMNS
        assert all(row[name] == "" for name in LEFT_EMPTY)
        assert math.dist(metres(float(row["Longitude"]), float(row["Latitude"])), (detection.x, detection.y)) < 0.01
        assert row["Date"].startswith("2000-06-21T01:")
        # A spreadsheet must not take a name for a formula.
        assert row["Site"] == "'=north"


def test_the_table_of_a_local_survey_has_metres_only(result):
    row = next(csv.DictReader(io.StringIO(detections_csv(result).decode())))
    assert (row["Latitude"], row["Longitude"], row["Coordinate system"]) == ("", "", "local only")
    assert float(row["x_m"]) == pytest.approx(result.detections[0].x, abs=1e-4)
