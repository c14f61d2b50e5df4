"""Results as one HTML file that needs nothing else, in the style of a survey's report."""

from __future__ import annotations

from collections.abc import Sequence

from rover.report.markup import NOTHING, Html, details, join, pairs, paragraph, section, table, tag, text
from rover.report.style import STYLE

from rover_hil.scenario.plot import plot
from rover_hil.scenario.runner import Result

PLOT_STYLE = """
.plot { display: block; width: 100%; height: auto; margin: .6rem 0; border: 1px solid var(--line);
  border-radius: .4rem; }
"""


def html_page(results: Sequence[Result]) -> str:
    """The whole document: an overview, then each scenario with its plot, what was asked for and what happened."""
    title = "Fault scenarios"
    body = (_headline(results), _overview(results), *(_scenario(result) for result in results))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>{STYLE}{PLOT_STYLE}</style>\n</head>\n"
        f"<body>\n<main>\n{join(body, chr(10))}\n</main>\n</body>\n</html>\n"
    )


def _headline(results: Sequence[Result]) -> Html:
    failed = sum(not result.passed for result in results)
    words = f"{failed} of {len(results)} failed" if failed else f"All {len(results)} passed"
    rigs = ", ".join(dict.fromkeys(result.rig for result in results))
    simulated = sum(result.simulated for result in results)
    wall = sum(result.wall for result in results)
    figures = (
        ("scenarios", text(len(results))),
        ("failed", text(failed)),
        ("rig", text(rigs)),
        ("simulated", text(f"{simulated:.1f} s")),
        ("times real time", text(f"{simulated / wall:.1f}" if wall > 0.0 else "-")),
    )
    css = "status alarm" if failed else "status"
    return join(
        (
            tag("h1", Html("Fault scenarios of the <strong>rover</strong>")),
            paragraph("Simulated world: motors, wheels, battery and sensors are models.", "simulated"),
            tag("div", Html(f"<b>{text(words)}</b>"), css),
            pairs(figures, "figures"),
        ),
        "\n",
    )


def _overview(results: Sequence[Result]) -> Html:
    rows = [
        (
            Html(f'<a href="#{text(_anchor(result))}">{text(result.scenario.name)}</a>'),
            text(result.rig),
            text(_outcome(result)),
            tag("span", text("passed" if result.passed else "failed"), "good" if result.passed else "bad"),
        )
        for result in results
    ]
    return section("Overview", "overview", table(("scenario", "rig", "end", "result"), rows))


def _scenario(result: Result) -> Html:
    scenario = result.scenario
    verdicts = [
        (
            text(verdict.name),
            text(verdict.asked),
            text("" if verdict.at is None else f"{verdict.at:.3f} s"),
            tag("span", text("yes" if verdict.passed else verdict.detail), "good" if verdict.passed else "bad"),
        )
        for verdict in result.verdicts
    ]
    events = [(text(f"{time:.3f}"), text(what)) for time, what in result.track.events]
    reason = paragraph(f"The companion's last word: {result.reason}.", "faint") if result.reason else NOTHING
    return section(
        scenario.name,
        _anchor(result),
        paragraph(scenario.description),
        plot(result.track, scenario.name),
        table(("what", "asked", "after", "held"), verdicts, numeric=(2,)),
        reason,
        details(f"{len(events)} events", table(("s", "event"), events, numeric=(0,))),
    )


def _anchor(result: Result) -> str:
    return f"{result.rig}-{result.scenario.path.stem}"


def _outcome(result: Result) -> str:
    values = result.track.last.values
    cause = f", {values['cause']}" if values["cause"] != "None" else ""
    return f"{values['state']}{cause}"
