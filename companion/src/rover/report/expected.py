"""What a rover with this detector finds, as measured on simulated fields: for the report, beside what it did find.

The figures lie beside the model (`tools.bench worlds --expected`) and name it by its hash: those of another are not
shown.
"""

from __future__ import annotations

import json
from typing import Any

from rover.detection.model_file import shipped
from rover.report.markup import NOTHING, Html, paragraph, section, table, text
from rover.report.result import RunResult

FILE = "landmine_ground_found.json"
BY = {"contrast": "Contrast at the surface", "depth": "Depth, by day and by night"}


def expected(result: RunResult) -> Html:
    """Probability of detection by contrast and by depth; nothing where another detector was at work."""
    known = _measured(result.identities.model_hash)
    if not known:
        return NOTHING
    tables = [
        table(
            (head, "Mines", "Found", "Probability of detection", "95 % interval"),
            [_row(row) for row in known["rows"] if row["by"] == by],
            (1, 2, 3, 4),
        )
        for by, head in BY.items()
    ]
    note = paragraph(
        f"Measured on {known['fields']} simulated fields in several soils, by day and by night, from the report "
        f"threshold {known['threshold']:g} on; there {known['false_per_m2']:.3f} indications per m² were false. Real "
        "ground is rougher: expect less, and more false indications.",
        "faint",
    )
    return section("What such a survey finds", "expected", *tables, note)


def _measured(model_hash: str) -> dict[str, Any]:
    """The file, or nothing where it is missing or tells of another model."""
    try:
        known: dict[str, Any] = json.loads(shipped(FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return known if model_hash and known["model"].startswith(model_hash.rstrip("…")) else {}


def _row(row: dict[str, Any]) -> tuple[Html, ...]:
    if not row["mines"]:
        return text(row["what"]), text(0), text(0), text("–"), text("–")
    share = 100.0 * row["found"] / row["mines"]
    interval = f"{100.0 * row['low']:.0f} to {100.0 * row['high']:.0f} %"
    return text(row["what"]), text(row["mines"]), text(row["found"]), text(f"{share:.0f} %"), text(interval)
