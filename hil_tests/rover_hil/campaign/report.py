"""The report of a campaign: rates with their bounds first, then what they depend on, then the worst missions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rover.report.markup import Html, join, paragraph, section, table, tag, text
from rover.report.style import STYLE

HEAD = ("", "Counted", "Of", "Rate", "95 % interval", "Below, with 95 % confidence")


def document(told: Mapping[str, Any]) -> str:
    """The HTML page. `told`: the JSON of `rover campaign`."""
    body = [
        tag("h1", Html(f"Campaign · <strong>{text(told['name'])}</strong>")),
        paragraph("Simulated fields: no real ground was surveyed.", "simulated"),
        paragraph(f"{told['missions']} missions, {told['failed']} of them broke an invariant or came to no end."),
        section("Rates", "rates", _rates(told["rates"])),
    ]
    for name, rates in told["strata"].items():
        body.append(section(name, f"stratum-{len(body)}", _rates(rates)))
    if told["against"]:
        body.append(section("Against another build, the same missions", "against", _against(told["against"])))
    body.append(section("What the outcomes depend on", "sensitivity", _sensitivity(told["sensitivity"])))
    body.append(section("The worst missions", "worst", _worst(told["worst"])))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>Campaign: {text(told['name'])}</title>\n<style>{STYLE}</style>\n</head>\n"
        f"<body>\n<main>\n{join(body, chr(10))}\n</main>\n</body>\n</html>\n"
    )


def lines(told: Mapping[str, Any]) -> str:
    """For a terminal."""
    rows = [f"{told['name']}: {told['missions']} missions, {told['failed']} failed"]
    for name, rate in told["rates"].items():
        interval = f"{_number(rate['low'])} to {_number(rate['high'])}"
        rows.append(f"  {name}: {rate['count']} of {rate['of']}, 95 % {interval}")
    rows += [f"  worst: {entry['repeat']}  ({entry['status']})" for entry in told["worst"][:5]]
    return "\n".join([*rows, f"{told['out']}/report.html"])


def _rates(rates: Mapping[str, Mapping[str, Any]]) -> Html:
    rows = [
        (
            text(name),
            text("–" if rate["count"] is None else f"{rate['count']:g}"),
            text(f"{rate['of']:g}"),
            text(_number(rate["count"] / rate["of"]) if rate["of"] and rate["count"] is not None else "–"),
            text(f"{_number(rate['low'])} to {_number(rate['high'])}"),
            text(_number(rate.get("below"))),
        )
        for name, rate in rates.items()
    ]
    return table(HEAD, rows, (1, 2, 3, 4, 5))


def _against(found: Mapping[str, Mapping[str, Any]]) -> Html:
    rows = [
        [text(name), *(text(each[key]) for key in ("pairs", "gone", "new", "p")), text("yes" if each["real"] else "no")]
        for name, each in found.items()
    ]
    return table(("", "Missions of both", "No more", "New", "p (McNemar)", "A real difference"), rows, (1, 2, 3, 4))


def _sensitivity(found: Sequence[Mapping[str, Any]]) -> Html:
    if not found:
        return paragraph("Too few missions, or nothing was drawn.")
    rows = [[text(each[key]) for key in ("outcome", "key", "effect", "p")] for each in found]
    note = paragraph(
        "Effect: rank correlation for numbers, share of the variance of ranks for words. With so many pairs one in "
        "twenty has p below 0.05 by chance.",
        "faint",
    )
    return join((table(("Outcome", "What was drawn", "Effect", "p"), rows, (2, 3)), note))


def _worst(found: Sequence[Mapping[str, Any]]) -> Html:
    rows = [
        (
            *(text(entry["status"]), text(entry["reason"])),
            *(text(_number(entry["coverage"])), tag("code", text(entry["repeat"]))),
        )
        for entry in found
    ]
    return table(("Status", "Reason", "Coverage", "Repeats it bit for bit"), rows, (2,))


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"
