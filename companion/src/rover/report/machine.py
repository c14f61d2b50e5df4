"""What the report tells of the machine: where it thought it was, how the link did, what exactly was at work."""

from __future__ import annotations

import math

from rover.report.markup import NOTHING, Html, details, pairs, paragraph, section, text
from rover.report.result import RunResult
from rover.report.sections import centimetres

# The link's figures that an operator asks for, in order; the others are folded away.
LINK_NAMES = (
    ("quality", "Frames that arrived", "percent"),
    ("lost", "Frames lost on the way to the companion", "count"),
    ("firmware_lost", "Frames lost on the way to the firmware", "count"),
    ("checksum_errors", "Checksum errors at the companion", "count"),
    ("firmware_checksum_errors", "Checksum errors at the firmware", "count"),
    ("segments_sent", "Motion segments sent", "count"),
    ("segments_repeated", "Motion segments repeated", "count"),
    ("segments_rejected", "Motion segments rejected", "count"),
    ("round_trip_median", "Round trip, median", "milliseconds"),
    ("round_trip_p99", "Round trip, 99 of 100 below", "milliseconds"),
    ("clock_error_bound", "Clock error, at most", "milliseconds"),
)


def localisation(result: RunResult) -> Html:
    """How well the rover knew where it was."""
    figures = result.localization
    rows: list[tuple[str, Html]] = []
    if result.identities.simulated:
        rows += [
            ("Position error against the truth (ATE, RMS)", _error(figures.ate_rmse)),
            ("The same from the wheels alone", _error(figures.odometry_only_ate_rmse)),
        ]
    rows += [
        ("Camera fixes used", text(figures.fixes)),
        ("Camera fixes rejected", text(figures.rejected)),
        ("Position ±1σ at the end", _error(figures.final_sigma)),
        ("Position ±1σ, largest", _error(figures.max_sigma)),
        ("Position among the ground around ±1σ, largest", _error(figures.max_relative_sigma)),
        ("Position measured from", text(figures.held_by)),
    ]
    rows += [
        (f"Plate at ({plate.x:g}, {plate.y:g})", text(_sight(plate.seen, plate.off))) for plate in figures.plates
    ]
    note = NOTHING
    if not result.identities.simulated:
        note = paragraph("On a real field the true path is not known: σ is the rover's own estimate.", "faint")
    return section("Localisation", "localisation", pairs(rows), note)


def _sight(seen: bool, off: float | None) -> str:
    if not seen:
        return "not seen"
    return "seen in an earlier run" if off is None else f"seen, the map was {100.0 * off:.1f} cm off at first sight"


def link(result: RunResult) -> Html:
    """How the link between companion and firmware did."""
    if not result.link:
        return section("Link", "link", paragraph("No figures were recorded."))
    named = {key for key, _, _ in LINK_NAMES}
    rows = [(name, _figure(result.link[key], unit)) for key, name, unit in LINK_NAMES if key in result.link]
    rest = [(key.replace("_", " "), _figure(result.link[key], "")) for key in sorted(result.link) if key not in named]
    return section("Link", "link", pairs(rows), details("All other link figures", pairs(rest)) if rest else NOTHING)


def identities(result: RunResult) -> Html:
    """Versions, hashes, seed and rig: enough to trace and repeat the run."""
    known = result.identities
    rows = (
        ("Rig", f"{known.rig} (simulated field)" if known.simulated else known.rig),
        ("Seed", "–" if known.seed is None else known.seed),
        ("Rover software", f"{known.rover_version}, sources {known.source_hash or 'unknown'}"),
        ("Firmware", known.firmware_version),
        ("Firmware source", known.firmware_git_hash),
        ("Board", known.board),
        ("Link schema", known.schema_hash),
        ("Detector model", known.model_hash),
        ("Mission file", known.mission_hash),
        ("Camera and its calibration", " ".join(filter(None, (known.camera, known.camera_hash)))),
        ("Vehicle file", known.vehicle_hash),
        ("Goes on from", known.after or "no earlier run"),
    )
    return section("Identities", "identities", pairs((name, text(value or "unknown")) for name, value in rows))


def wall_clock(result: RunResult) -> Html:
    """The one place with figures that differ from run to run; on a real rover, how well time was kept."""
    if result.real_time is not None:
        kept = result.real_time
        return paragraph(
            f"Real time: {kept.overruns} of {kept.cycles} cycles began late, the longest took "
            f"{1e3 * kept.longest_cycle:.0f} ms; {kept.frames_dropped} pictures were not looked at.",
            "wall",
        )
    if result.wall_clock is None:
        return NOTHING
    wall = result.wall_clock
    return paragraph(
        f"Wall clock: {wall.duration:.1f} s on this computer, {wall.speed_factor:.1f} times as fast as the mission. "
        "Only these two figures change when the same mission runs again with the same seed.",
        "wall",
    )


def _error(metres: float | None) -> Html:
    return text("unknown" if metres is None else centimetres(metres))


def _figure(value: float, unit: str) -> Html:
    if not math.isfinite(value):
        return text("unknown")
    if unit == "percent":
        # Rounded down: one lost frame in a million is not "all".
        return text(f"{math.floor(1e4 * value) / 100.0:.2f} %")
    if unit == "milliseconds":
        return text(f"{1e3 * value:.2f} ms")
    return text(f"{value:,.0f}".replace(",", " ") if float(value).is_integer() else f"{value:.3g}")
