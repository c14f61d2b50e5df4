"""Puts the results of a run into its folder."""

from __future__ import annotations

import os
from pathlib import Path

from rover.record.strict_json import document
from rover.report.geojson import geojson_name, write_geojson
from rover.report.html import report_html
from rover.report.map_plot import draw_map, png_bytes
from rover.report.result import RunResult


def write_run(result: RunResult, out: Path) -> None:
    """Writes map, results for a GIS, report.html and, last, summary.json into the folder `out`, made if missing.

    A file is there complete or not at all, and who sees summary.json may rely on the others. The log and the
    trajectory are written by who ran the mission. Raises OSError.
    """
    out.mkdir(parents=True, exist_ok=True)
    map_png = png_bytes(draw_map(result))
    _replace(out / "map.png", map_png)
    geojson = out / geojson_name(result)
    write_geojson(_temporary(geojson), result)
    os.replace(_temporary(geojson), geojson)
    _replace(out / "report.html", report_html(result, map_png).encode("utf-8"))
    _replace(out / "summary.json", document(result.summary()).encode("utf-8"))


def _replace(path: Path, data: bytes) -> None:
    temporary = _temporary(path)
    temporary.write_bytes(data)
    os.replace(temporary, path)


def _temporary(path: Path) -> Path:
    """Beside the file itself: a rename is atomic only within a file system."""
    return path.with_name(f".{path.name}.part")
