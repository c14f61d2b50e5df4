"""Results as GeoJSON, for a GIS.

GeoJSON means WGS 84 longitude and latitude. A mission without a surveyed origin has none: its coordinates are then
metres in the local frame of the mission, and the document says so in a foreign member, so that nobody takes x for a
longitude unawares. With the geographic position of the map's origin the coordinates are what the format promises.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from rover.report.result import DetectionResult, GoalResult, RunResult
from rover.report.site import Georeference
from rover.report.summary import detection_json, goal_json

# The ellipsoid of WGS 84: semi-major axis in metres, and the square of the first eccentricity.
SEMI_MAJOR_AXIS_M = 6_378_137.0
ECCENTRICITY_SQUARED = 6.694_379_990_14e-3

# Corners of the polygon that stands for a circle.
CIRCLE_SIDES = 48

WORLD_FILE = "detections.geojson"
LOCAL_FILE = "detections.local.json"

Project = Callable[[float, float], list[float]]


def projection(reference: Georeference | None, digits: int = 9) -> Project:
    """Function from map x, y to GeoJSON coordinates, degrees rounded to `digits` (9: a tenth of a millimetre).

    A field is a plane that touches the ellipsoid at the map's origin: over 100 m that is exact to a millimetre.
    """
    if reference is None:
        return lambda x, y: [round(x, 4), round(y, 4)]
    latitude_rad, bearing = math.radians(reference.latitude), math.radians(reference.bearing_deg)
    # Radii of curvature in the meridian and across it.
    squeeze = 1.0 - ECCENTRICITY_SQUARED * math.sin(latitude_rad) ** 2
    along = SEMI_MAJOR_AXIS_M * (1.0 - ECCENTRICITY_SQUARED) / squeeze**1.5
    across = SEMI_MAJOR_AXIS_M / math.sqrt(squeeze)
    c, s = math.cos(bearing), math.sin(bearing)

    def project(x: float, y: float) -> list[float]:
        east, north = c * x + s * y, -s * x + c * y
        latitude = reference.latitude + math.degrees(north / along)
        longitude = reference.longitude + math.degrees(east / (across * math.cos(latitude_rad)))
        return [round(longitude, digits), round(latitude, digits)]

    return project


def results_geojson(result: RunResult) -> dict[str, Any]:
    """FeatureCollection of detections, keep-out zones, goals, the area and the driven path."""
    reference = result.site.origin
    project = projection(reference)
    features: list[dict[str, Any]] = []
    for detection in result.detections:
        features.append(_detection(detection, project))
        features.append(_zone(detection, project))
    features.extend(_goal(goal, project) for goal in result.goals)
    path = [project(x, y) for _, x, y in result.path.tolist()]
    if len(path) >= 2:
        features.append(_feature("LineString", path, {"kind": "path", "length_m": round(result.distance, 4)}))
    corners = [(0.0, 0.0), (result.area_width, 0.0), (result.area_width, result.area_height), (0.0, result.area_height)]
    features.append(_feature("Polygon", [_ring(corners, project)], {"kind": "area", "mission": result.mission}))
    collection: dict[str, Any] = {"type": "FeatureCollection", "features": features}
    if reference is None:
        collection["rover:frame"] = {
            "name": "map",
            "units": "metre",
            "axes": "x right, y up, origin at the lower left corner of the area",
            "note": "local coordinates, not longitude and latitude: the mission gave no geographic origin",
        }
    collection["rover:simulated"] = result.identities.simulated
    return collection


def geojson_name(result: RunResult) -> str:
    """Name of the file of results: one that holds metres must not be taken for a map of the world."""
    return LOCAL_FILE if result.site.origin is None else WORLD_FILE


def _detection(detection: DetectionResult, project: Project) -> dict[str, Any]:
    properties = {"kind": "indication", **detection_json(detection)}
    return _feature("Point", project(detection.x, detection.y), properties)


def _zone(detection: DetectionResult, project: Project) -> dict[str, Any]:
    points = [
        (
            detection.x + detection.zone_radius * math.cos(2.0 * math.pi * k / CIRCLE_SIDES),
            detection.y + detection.zone_radius * math.sin(2.0 * math.pi * k / CIRCLE_SIDES),
        )
        for k in range(CIRCLE_SIDES)
    ]
    properties = {"kind": "keep-out zone", "detection": detection.id, "radius_m": round(detection.zone_radius, 4)}
    return _feature("Polygon", [_ring(points, project)], properties)


def _goal(goal: GoalResult, project: Project) -> dict[str, Any]:
    properties = goal_json(goal)
    return _feature("Point", project(goal.x, goal.y), {**properties, "kind": "goal", "goal_kind": properties["kind"]})


def _ring(points: Sequence[tuple[float, float]], project: Project) -> list[list[float]]:
    """A closed ring, counter-clockwise (RFC 7946, 3.1.6)."""
    ring = [project(x, y) for x, y in points]
    return [*ring, ring[0]]


def _feature(kind: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": properties}
