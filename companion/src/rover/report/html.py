"""The report of a run: one HTML file that needs nothing else, made to be understood within a minute."""

from __future__ import annotations

from rover.outcome import RunStatus
from rover.report import machine, sections
from rover.report.expected import expected
from rover.report.markup import NOTHING, Html, details, join, pairs, paragraph, picture, section, tag, text
from rover.report.result import RunResult
from rover.report.style import STYLE
from rover.report.two_visits import two_visits

ALARM = "status alarm"
# How a status reads, and how loud it is. Done is no green: a finished survey says nothing good about the ground.
STATUS_WORDS = {
    RunStatus.DONE: ("Done", "status"),
    RunStatus.PARTIAL: ("Partly done", "status warn"),
    RunStatus.NO_PATH: ("No path", "status warn"),
    RunStatus.ABORTED: ("Aborted", "status warn"),
    RunStatus.SAFETY_STOP: ("Safety stop", ALARM),
    RunStatus.LINK_LOST: ("Link lost", ALARM),
}


def report_html(result: RunResult, map_png: bytes) -> str:
    """The whole document. `map_png`: the map as PNG, embedded. The same input gives the same text."""
    title = f"Survey report: {result.mission}"
    body = (
        _headline(result),
        _figures(result),
        section("Map", "map", picture(map_png, _map_in_words(result), "map")),
        sections.site(result),
        sections.indications(result),
        two_visits(result),
        sections.not_surveyed(result),
        sections.limits(result),
        expected(result),
        sections.goals(result),
        sections.invariants(result),
        machine.localisation(result),
        machine.link(result),
        section("Timeline", "timeline", details(f"{len(result.timeline)} entries", sections.timeline(result))),
        machine.identities(result),
        machine.wall_clock(result),
    )
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{text(title)}</title>\n<style>{STYLE}</style>\n</head>\n"
        f"<body>\n<main>\n{join(body, chr(10))}\n</main>\n</body>\n</html>\n"
    )


def _headline(result: RunResult) -> Html:
    words, css = STATUS_WORDS[result.status]
    simulated = NOTHING
    if result.identities.simulated:
        simulated = paragraph("Simulated field: no real ground was surveyed.", "simulated")
    sentence = result.reason.strip().rstrip(".")
    reason = text(sentence[0].upper() + sentence[1:])
    broken = sections.broken(result)
    alarm = NOTHING
    if broken:
        alarm = tag("div", Html(f"<b>Safety invariants broken</b><span>{text('; '.join(broken))}.</span>"), ALARM)
    return join(
        (
            tag("h1", Html(f"Survey report · mission <strong>{text(result.mission)}</strong>")),
            simulated,
            tag("div", Html(f"<b>{text(words)}</b><span>{reason}.</span>"), css),
            alarm,
        ),
        "\n",
    )


def _figures(result: RunResult) -> Html:
    area = result.area_m2
    inspected = sum(detection.inspected for detection in result.detections)
    reached = sum(goal.reached for goal in result.goals)
    sigma = result.localization.max_sigma
    truth = [] if result.found is None else [("mines found (the referee knows)", text(result.found))]
    seen, stands = result.coverage, result.home
    home = [] if stands is None else [("back at the launch", text("yes" if stands.reached else f"no: {stands.reason}"))]
    coverage = [] if seen is None else [(f"coverage: {seen}", text(f"{100.0 * seen.required:g} % required"))]
    figures = (
        (f"indications, {inspected} of them inspected", text(len(result.detections))),
        (f"surveyed: {result.surveyed_area:.1f} of {area:.1f} m²", text(sections.share(result.surveyed_area, area))),
        ("not surveyed", text(f"{max(0.0, area - result.surveyed_area):.1f} m²")),
        *coverage,
        ("goals reached", text(f"{reached} of {len(result.goals)}")),
        *truth,
        ("ground under the wheels", text(f"{result.fresh_wheel:.2f} m²")),
        (f"driven in {sections.clock(result.duration)} min", text(f"{result.distance:.1f} m")),
        *home,
        ("position ±1σ, largest", text("unknown" if sigma is None else sections.centimetres(sigma))),
    )
    return pairs(figures, "figures")


def _map_in_words(result: RunResult) -> str:
    return (
        f"Map of {result.area_width:g} by {result.area_height:g} metres with {len(result.detections)} indications, "
        "keep-out zones around them, obstacles, the driven path and the ground that was not surveyed, hatched"
    )
