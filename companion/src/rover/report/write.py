"""Puts the results of a run into its folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rover.record.strict_json import document
from rover.report.geojson import geojson_name, results_geojson
from rover.report.html import report_html
from rover.report.imsma import FILE as CSV_FILE
from rover.report.imsma import detections_csv
from rover.report.kml import WORLD_FILE as KML_FILE
from rover.report.kml import results_kml
from rover.report.map_plot import draw_map, png_bytes
from rover.report.pdf import FILE as PDF_FILE
from rover.report.pdf import report_pdf
from rover.report.result import RunResult
from rover.report.summary import summary
from rover.whole_file import write_whole


def write_run(result: RunResult, out: Path, pdf: bool = False) -> tuple[str, ...]:
    """Writes map, results for a GIS, report.html and, last, summary.json into the folder `out`, made if missing.

    `pdf`: report.pdf, too.

    A file is there complete or not at all, and who sees summary.json may rely on the others but for those that could
    not be written: each of these is returned as one line with the reason. The log and the trajectory are written by
    who ran the mission.
    """
    out.mkdir(parents=True, exist_ok=True)
    map_png = png_bytes(draw_map(result))
    files: dict[str, Callable[[], bytes]] = {
        "map.png": lambda: map_png,
        geojson_name(result): lambda: document(results_geojson(result), indent=1).encode("utf-8"),
        **({} if result.site.origin is None else {KML_FILE: lambda: results_kml(result)}),
        CSV_FILE: lambda: detections_csv(result),
        "report.html": lambda: report_html(result, map_png).encode("utf-8"),
        **({PDF_FILE: lambda: report_pdf(report_html(result, map_png))} if pdf else {}),
        "summary.json": lambda: document(summary(result)).encode("utf-8"),
    }
    lost = (write_or_tell(out / name, content()) for name, content in files.items())
    return tuple(line for line in lost if line is not None)


def write_or_tell(path: Path, data: bytes) -> str | None:
    """Writes one file; one line that says why when it cannot be written."""
    try:
        write_whole(path, data)
    except OSError as error:
        return f"{path} was not written: {error.strerror or error}"
    return None
