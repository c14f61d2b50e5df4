"""What the report tells of the field: the indications, the goals, the ground without a survey, the limits kept."""

from __future__ import annotations

import math

from rover.record.epoch import NO_EPOCH
from rover.report.map_plot import png_bytes, thumbnail
from rover.report.markup import NOTHING, Html, bullets, join, pairs, paragraph, picture, section, table, tag, text
from rover.report.result import DetectionResult, GoalKind, GoalResult, RunResult

CLASS_WORDS = {"surface": "mine-like, on the surface", "buried": "mine-like, buried"}
GOAL_SETTERS = {GoalKind.OPERATOR: "operator", GoalKind.INSPECTION: "rover, to inspect an indication"}
# m²; differences of areas below this are rounding.
MIN_AREA = 0.005


def site(result: RunResult) -> Html:
    """When and where, for whom and by whom; what nobody said is left out, but for when and where."""
    known, epoch = result.site, result.epoch
    rows = [("Site", known.name), ("Organisation", known.organisation), ("Operator", known.operator)]
    began, ended = epoch.local(0.0), epoch.local(result.duration)
    rows.append(("Began", "not known" if epoch == NO_EPOCH else f"{began} ({epoch.utc(0.0)})"))
    rows.append(("Ended", "not known" if epoch == NO_EPOCH else f"{ended} ({epoch.utc(result.duration)})"))
    rows.append(("Time told by", epoch.source))
    rows.append(("Weather, as told by the operator", known.weather))
    if known.origin is not None:
        origin = known.origin
        place = f"{origin.latitude:.7f}, {origin.longitude:.7f} (latitude, longitude; WGS 84)"
        rows += [("Origin of the map", place), ("Bearing of map +y", f"{origin.bearing_deg:.6g}° from true north")]
    else:
        rows.append(("Origin of the map", "local only: the mission file gives no place on the earth"))
    if known.grid is not None:
        grid = known.grid
        given = f"EPSG:{grid.epsg}, {grid.easting:.3f} E {grid.northing:.3f} N"
        rows.append(("Origin, as the mission file gives it", given))
    told = [(name, text(value)) for name, value in rows if value]
    return section("When and where", "site", pairs(told))


def indications(result: RunResult) -> Html:
    """Every indication with its picture, or a sentence that there is none and what that means."""
    if not result.detections:
        return section(
            "Indications",
            "indications",
            paragraph(
                "No indication was found. That does not mean that there is no mine: see what this report does not say."
            ),
        )
    head = ("Id", "Picture", "Class", "Probability", "x", "y", "±1σ", "Views", "Inspected")
    rows = [_indication(detection) for detection in result.detections]
    note = paragraph(
        "x and y in metres from the lower left corner of the area. The pictures show 0.6 m of ground, the same way up "
        "as the map; each has its own colour scale. Probability is that of the class given.",
        "faint",
    )
    return section("Indications", "indications", table(head, rows, (3, 4, 5, 6, 7), "indications"), note)


def _indication(detection: DetectionResult) -> tuple[Html, ...]:
    image = NOTHING
    if detection.thumbnail is not None and detection.thumbnail.size:
        png = png_bytes(thumbnail(detection.thumbnail))
        image = picture(png, f"thermal picture of indication {detection.id}", "thumbnail")
    inspected = "yes" if detection.inspected else f"no: {detection.why_not}"
    return (
        tag("span", text(detection.id), "id"),
        image or text("none"),
        text(CLASS_WORDS.get(detection.kind, detection.kind)),
        text(f"{100.0 * detection.p:.0f} %"),
        text(f"{detection.x:.2f} m"),
        text(f"{detection.y:.2f} m"),
        text(centimetres(detection.sigma)),
        text(detection.views),
        text(inspected),
    )


def goals(result: RunResult) -> Html:
    """Goals of the operator and inspections that the rover set itself."""
    if not result.goals:
        return section("Goals", "goals", paragraph("The mission had no goals and made none."))
    rows = [_goal(goal) for goal in result.goals]
    return section("Goals", "goals", table(("Id", "Set by", "Place", "Reached"), rows))


def _goal(goal: GoalResult) -> tuple[Html, ...]:
    at = "" if goal.time is None else f", at {clock(goal.time)}"
    reached = text(f"yes{at}") if goal.reached else join((tag("b", text("no: ")), text(goal.reason)))
    return (
        text(f"G{goal.id}" if goal.kind is GoalKind.OPERATOR else goal.id),
        text(GOAL_SETTERS[goal.kind]),
        text(f"{goal.x:.2f}, {goal.y:.2f} m"),
        reached,
    )


def not_surveyed(result: RunResult) -> Html:
    """Area and share of the ground without a survey, reason by reason, and all of it."""
    area = result.area_m2
    missing = max(0.0, area - result.surveyed_area)
    parts = [(part.area, part.reason) for part in result.unsurveyed]
    unexplained = missing - sum(size for size, _ in parts)
    if unexplained > MIN_AREA:
        parts.append((unexplained, "at the border, where no whole cell of the map fits"))
    rows = [(text(reason), text(f"{size:.2f} m²"), text(share(size, area))) for size, reason in parts]
    total = (tag("b", text("Together")), tag("b", text(f"{missing:.2f} m²")), tag("b", text(share(missing, area))))
    return section(
        "What was not surveyed, and why",
        "not-surveyed",
        table(("Reason", "Area", "Share of the area"), [*rows, total], (1, 2)),
        paragraph("This ground is hatched on the map. Nothing is known about it.", "faint"),
    )


def invariants(result: RunResult) -> Html:
    """What must never happen, with how often it did; on a real field nobody counts."""
    safety = result.safety
    simulated = result.identities.simulated
    absent = "nobody counted (the rig was gone at the end)" if simulated else "nobody counted (a real field)"
    unseen, clearance = safety.unseen_ground, safety.min_clearance
    rows = (
        _count("Collisions", safety.collisions, absent),
        _count("Touches of up to 0.1 m/s, and what the bumper felt", safety.bumper_contacts, absent),
        _count("Keep-out violations", safety.keepout_violations, absent),
        _invariant("Unseen ground driven on", _square(unseen), absent, None if unseen is None else unseen == 0.0),
        _count("Wheel over a mine (truth)", safety.wheel_over_mine, absent),
        _invariant("Smallest clearance", _length(clearance), absent, None if clearance is None else clearance > 0.0),
    )
    who = (
        "Counted by the referee of the simulated field, who knows what lies where; the rover does not."
        if simulated
        else "On a real field no referee watches: the rover cannot count its own violations."
    )
    return section(
        "Safety invariants", "invariants", table(("Invariant", "Counted", "Kept"), rows, (1,)), paragraph(who, "faint")
    )


def broken(result: RunResult) -> list[str]:
    """The invariants that the referee saw broken, in words; empty when none was or nobody counted."""
    safety = result.safety
    counts = (
        (safety.collisions, "collisions"),
        (safety.bumper_contacts, "bumper contacts"),
        (safety.keepout_violations, "keep-out violations"),
        (safety.wheel_over_mine, "times a wheel over a mine"),
    )
    found = [f"{count} {words}" for count, words in counts if count]
    if safety.unseen_ground:
        found.append(f"{_square(safety.unseen_ground)} of unseen ground driven on")
    return found


def _count(name: str, count: int | None, absent: str) -> tuple[Html, ...]:
    return _invariant(name, str(count), absent, None if count is None else count == 0)


def _square(area: float | None) -> str:
    return "" if area is None else f"{area:.4f} m²"


def _length(length: float | None) -> str:
    if length is None:
        return ""
    return "nothing was near" if math.isinf(length) else centimetres(length)


def _invariant(name: str, shown: str, absent: str, kept: bool | None) -> tuple[Html, ...]:
    if kept is None:
        return text(name), text("–"), text(absent)
    return text(name), text(shown), tag("span", text("kept"), "good") if kept else tag("span", text("VIOLATED"), "bad")


def limits(result: RunResult) -> Html:
    """What must not be read into the report."""
    sentences = [
        "Mines without a thermal contrast to the ground around them are not seen. Depth, moisture, shade and "
        "vegetation all take contrast away.",
        "The contrast vanishes twice a day, when mine and ground are equally warm: in the morning and in the evening.",
        "An indication is not a confirmation: roots, stones and debris can look alike. A person has to decide.",
        "Ground without an indication and without hatching on the map is surveyed, nothing more. It may hold mines.",
        "Positions are the rover's own estimate; ±1σ covers about two errors out of three per axis.",
    ]
    if result.identities.simulated:
        sentences.insert(0, "This field was simulated: nothing in this report describes real ground.")
    return section("What this report does not say", "limits", tag("div", bullets(sentences), "limits"))


def timeline(result: RunResult) -> Html:
    """What happened, in order."""
    entries = join(
        (Html(f'<tr><td class="number">{clock(e.time)}</td><td>{text(e.text)}</td></tr>') for e in result.timeline),
        "\n",
    )
    if not entries:
        return paragraph("Nothing was recorded.")
    return Html(f'<div class="scroll"><table class="timeline"><tbody>{entries}</tbody></table></div>')


def clock(seconds: float) -> str:
    """Mission time as minutes and seconds."""
    whole = round(seconds)
    return f"{'−' if whole < 0 else ''}{abs(whole) // 60}:{abs(whole) % 60:02d}"


def centimetres(metres: float) -> str:
    """A small length."""
    return f"{100.0 * metres:.1f} cm" if math.isfinite(metres) else "unknown"


def share(part: float, whole: float) -> str:
    """A share in percent; a remainder that rounds to nothing is not shown as nothing."""
    percent = 100.0 * part / whole if whole > 0.0 else 0.0
    return "< 0.1 %" if 0.0 < percent < 0.05 else f"{percent:.1f} %"
