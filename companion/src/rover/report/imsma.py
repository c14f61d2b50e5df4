"""Indications as CSV with the fields of GICHD's minimum data requirements for devices found, for import into IMSMA.

What a survey with a camera cannot know is left empty: `LEFT_EMPTY`. Our own figures follow behind.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from rover.record.epoch import NO_EPOCH
from rover.report.geojson import projection
from rover.report.result import DetectionResult, RunResult

FILE = "detections.csv"

# The published requirements: coordinates, category, model, condition and depth of each device, its benchmark and who
# found it when.
COLUMNS = (
    *("Local ID", "Date", "Organisation", "Operator", "Site", "Type of activity"),
    *("Latitude", "Longitude", "Coordinate system"),
    *("Device category", "Device model", "Device condition", "Depth (cm)", "Status"),
    *("x_m", "y_m", "sigma_m", "class", "p", "zone_radius_m", "inspected"),
)
LEFT_EMPTY = ("Device model", "Device condition", "Depth (cm)")

CATEGORIES = {"surface": "mine-like, on the surface", "buried": "mine-like, buried"}


def detections_csv(result: RunResult) -> bytes:
    """A row an indication, UTF-8. Latitude and longitude are empty without an origin on the earth."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(COLUMNS)
    for detection in result.detections:
        writer.writerow([_harmless(cell) for cell in _row(result, detection)])
    return text.getvalue().encode()


def _row(result: RunResult, detection: DetectionResult) -> Sequence[object]:
    site, on_earth = result.site, result.site.origin is not None
    longitude, latitude = projection(site.origin)(detection.x, detection.y)
    activity = "Simulated survey" if result.identities.simulated else "Survey by thermal camera"
    return (
        detection.id,
        "" if result.epoch == NO_EPOCH else result.epoch.utc(detection.first_seen),
        *(site.organisation, site.operator, site.name, activity),
        f"{latitude:.9f}" if on_earth else "",
        f"{longitude:.9f}" if on_earth else "",
        "EPSG:4326" if on_earth else "local only",
        CATEGORIES.get(detection.kind, detection.kind),
        *("" for _ in LEFT_EMPTY),
        "indication, not confirmed",
        *(f"{value:.4f}" for value in (detection.x, detection.y, detection.sigma)),
        *(detection.kind, f"{detection.p:.4f}", f"{detection.zone_radius:.4f}", "yes" if detection.inspected else "no"),
    )


def _harmless(cell: object) -> object:
    """A text that a spreadsheet would run as a formula, behind an apostrophe."""
    return f"'{cell}" if isinstance(cell, str) and cell[:1] in ("=", "+", "@", "\t", "\r") else cell
