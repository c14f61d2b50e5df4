"""Results as GeoJSON, for a GIS.

GeoJSON means WGS 84 longitude and latitude. A mission without a surveyed origin has none: its coordinates are then
metres in the local frame of the mission, and the document says so in a foreign member, so that nobody takes x for a
longitude unawares. With the geographic position of the map's origin the coordinates are what the format promises.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rover.record.strict_json import document
from rover.report.result import DetectionResult, GoalResult, RunResult, detection_json, goal_json

EARTH_RADIUS = 6_371_008.8
"""Mean radius in metres; over the tens of metres of a field the sphere is off by millimetres."""

CIRCLE_SIDES = 48
Project = Callable[[float, float], list[float]]


@dataclass(frozen=True)
class Georeference:
    """Where the map's origin lies: degrees; `bearing`: the compass bearing of map +y in radians (0: +y is north)."""

    latitude: float
    longitude: float
    bearing: float = 0.0


def projection(reference: Georeference | None) -> Project:
    """Function from map x, y to GeoJSON coordinates."""
    if reference is None:
        return lambda x, y: [round(x, 4), round(y, 4)]
    cos_latitude = math.cos(math.radians(reference.latitude))
    c, s = math.cos(reference.bearing), math.sin(reference.bearing)

    def project(x: float, y: float) -> list[float]:
        east, north = c * x + s * y, -s * x + c * y
        latitude = reference.latitude + math.degrees(north / EARTH_RADIUS)
        longitude = reference.longitude + math.degrees(east / (EARTH_RADIUS * cos_latitude))
        return [round(longitude, 9), round(latitude, 9)]

    return project


def results_geojson(result: RunResult, reference: Georeference | None = None) -> dict[str, Any]:
    """FeatureCollection of detections, keep-out zones, goals, the area and the driven path."""
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


def write_geojson(path: Path, result: RunResult, reference: Georeference | None = None) -> None:
    """Writes the results of a run."""
    path.write_text(document(results_geojson(result, reference), indent=1), encoding="utf-8")


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
