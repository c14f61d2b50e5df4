"""The report tells an operator everything, claims nothing about the ground, and needs nothing but itself."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from rover.outcome import RunStatus
from rover.record.epoch import Epoch
from rover.report.html import report_html
from rover.report.result import Found, Identities, RunResult, Safety, WallClock
from rover.report.site import Georeference, Site
from rover.report.summary import summary

from companion.tests.report.sample_run import make_result

PNG = b"\x89PNG not drawn"
VOID = {"meta", "img", "br"}


class Reader(HTMLParser):
    """Text and references of a document; complains when elements are not closed in order."""

    def __init__(self, document: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.words: list[str] = []
        self.names: list[str] = []
        self.references: list[str] = []
        self.feed(document)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.append(tag)
        self.references += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] != "style":
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def reader(result: RunResult) -> Reader:
    return Reader(report_html(result, PNG))


def part(result: RunResult, identifier: str) -> str:
    """Text of one section of the report."""
    found = re.search(rf'<section id="{identifier}">.*?</section>', report_html(result, PNG), re.DOTALL)
    assert found, identifier
    return Reader(found.group()).text


def test_the_status_comes_first_with_its_reason(reader: Reader, result: RunResult) -> None:
    start = reader.text[: reader.text.index("Map")]
    assert "Partly done" in start
    assert result.reason[1:] in start


@pytest.mark.parametrize("status", RunStatus)
def test_every_status_has_words(status: RunStatus) -> None:
    text = Reader(report_html(make_result(status=status, reason="so it was"), PNG)).text
    assert "So it was." in text
    assert "_" not in text[: text.index("Map")]


def test_every_indication_has_a_row_with_its_figures(result: RunResult) -> None:
    document = report_html(result, PNG)
    for detection in result.detections:
        assert f'<span class="id">{detection.id}</span>' in document
        assert f'alt="thermal picture of indication {detection.id}"' in document
    text = part(result, "indications")
    assert "mine-like, buried 81 % 2.22 m 2.90 m 3.4 cm 12 no: no way to a place to look from" in text
    assert "mine-like, on the surface 97 % 1.12 m 1.62 m 2.1 cm 31 yes" in text


def test_an_indication_without_a_picture_is_listed_too(result: RunResult) -> None:
    bare = replace(result.detections[0], thumbnail=None)
    assert "none mine-like" in part(replace(result, detections=(bare,)), "indications")


def test_no_indication_is_said_in_words(result: RunResult) -> None:
    assert "No indication was found" in part(replace(result, detections=()), "indications")


def test_goals_are_told_with_the_reason_where_one_was_not_reached(result: RunResult) -> None:
    text = part(result, "goals")
    assert "G1 operator 2.00, 2.30 m yes, at 1:20" in text
    assert "G3 operator 2.75, 3.40 m no: no way leads to it past the keep-out zones" in text


def test_ground_without_a_survey_is_told_by_reason_and_in_all(result: RunResult) -> None:
    text = part(result, "not-surveyed")
    for entry in result.unsurveyed:
        assert f"{entry.reason} {entry.area:.2f} m²" in text
    assert "Together 1.03 m² 8.6 %" in text


def test_missing_ground_without_a_reason_is_not_hidden(result: RunResult) -> None:
    text = part(replace(result, unsurveyed=result.unsurveyed[:1]), "not-surveyed")
    assert "at the border, where no whole cell of the map fits 0.87 m²" in text


def test_invariants_are_counted_and_a_broken_one_is_told_at_the_top(result: RunResult) -> None:
    kept = part(result, "invariants")
    for line in ("Collisions 0 kept", "Keep-out violations 0 kept", "Wheel over a mine (truth) 0 kept", "8.3 cm kept"):
        assert line in kept
    broken = replace(result, safety=Safety(2, 0, 0.0125, 0.0, 0))
    text = Reader(report_html(broken, PNG)).text
    assert "Safety invariants broken 2 collisions; 0.0125 m² of unseen ground driven on." in text[: text.index("Map")]
    assert "Collisions 2 VIOLATED" in text
    assert "Keep-out violations 0 kept" in text
    assert "Smallest clearance 0.0 cm VIOLATED" in text


def test_on_a_real_field_nobody_counted_and_nothing_is_called_simulated(result: RunResult) -> None:
    real = replace(result, identities=Identities("device", None, "0.1.0"), safety=Safety())
    text = Reader(report_html(real, PNG)).text
    assert text.count("nobody counted (a real field)") == 5
    assert "truth (ATE" not in text
    assert not re.search(r"simulated", text, re.IGNORECASE)


def test_a_simulated_field_is_named_before_everything_else(reader: Reader) -> None:
    assert reader.text.index("Simulated field") < reader.text.index("Partly done")


def test_position_error_stands_beside_the_wheels_alone(result: RunResult) -> None:
    text = part(result, "localisation")
    assert "RMS) 2.1 cm The same from the wheels alone 14.3 cm" in text
    assert "rejected 9" in text


def test_what_the_report_does_not_say_is_said(result: RunResult) -> None:
    text = part(result, "limits")
    for words in ("without a thermal contrast", "vanishes twice a day", "not a confirmation", "is surveyed"):
        assert words in text


def test_ground_is_never_called_cleared_nor_safe(reader: Reader) -> None:
    for document in (reader, Reader(report_html(make_result(status=RunStatus.DONE, detections=()), PNG))):
        assert not re.search(r"\b(clear|cleared|clearing|safe|safely|free of mines|mine-free)\b", document.text, re.I)


def test_text_from_outside_is_escaped(result: RunResult) -> None:
    evil = '<script>alert("x")</script>'
    loud = replace(
        result,
        mission=evil,
        reason=evil,
        detections=(replace(result.detections[0], why_not=evil, inspected=False, kind=evil),),
        goals=(replace(result.goals[2], reason=evil),),
        unsurveyed=(replace(result.unsurveyed[0], reason=evil),),
        timeline=(replace(result.timeline[0], text=evil),),
        identities=replace(result.identities, firmware_version=evil, board=evil),
        link={evil: 1.0},
    )
    reader = Reader(report_html(loud, PNG))
    assert "script" not in reader.names
    assert reader.text.count('alert("x")') >= 9


def test_the_file_needs_nothing_but_itself(reader: Reader, result: RunResult) -> None:
    assert all(reference.startswith("data:image/png;base64,") for reference in reader.references)
    assert len(reader.references) == 1 + len(result.detections)
    assert "script" not in reader.names
    assert "link" not in reader.names
    assert not re.search(r"https?://|url\(|@import", report_html(result, PNG))


def test_only_the_marked_place_differs_from_run_to_run(result: RunResult) -> None:
    first = report_html(result, PNG)
    assert first == report_html(make_result(), PNG)
    again = report_html(replace(result, wall_clock=WallClock(99.0, 1.5), out="elsewhere"), PNG)
    differing = [line for line in again.splitlines() if line not in first.splitlines()]
    assert len(differing) == 1
    assert differing[0].startswith('<p class="wall">')


def test_what_the_referee_knows_of_the_mines_is_told_of_simulated_fields_only(result: RunResult) -> None:
    told = "mines found (the referee knows)"
    assert told not in Reader(report_html(result, PNG)).text
    judged = replace(result, found=Found(mines=5, found=5, with_contrast=5, with_contrast_found=5, false=1))
    assert "5 of 5, 1 false" in Reader(report_html(judged, PNG)).text
    assert summary(judged)["mines"]["found"] == 5


def test_mines_that_do_not_show_are_told_apart() -> None:
    assert str(Found(mines=6, found=4, with_contrast=5, with_contrast_found=4, false=0)) == (
        "4 of 6 (4 of 5 that show), 0 false"
    )


def test_the_site_stands_in_the_report_when_the_mission_file_names_it(result: RunResult) -> None:
    assert "local only" in part(result, "site")
    placed = replace(result, site=Site("north <meadow>", "", "N. N.", Georeference(50.1, 8.7, 30.0)))
    text = part(placed, "site")
    for value in ("north <meadow>", "N. N.", "50.1000000, 8.7000000", "30° from true north"):
        assert value in text
    assert "Organisation" not in text


def test_a_report_has_its_date_in_both_times_and_says_who_told_it(result: RunResult) -> None:
    assert "not known" in part(result, "site")
    epoch = Epoch(1_777_896_000 * 10**9, 7200, "system clock, not synchronised")
    text = part(replace(result, epoch=epoch, site=Site(weather="dry, light wind")), "site")
    for value in ("2026-05-04T14:00:00+02:00 (2026-05-04T12:00:00Z)", "not synchronised", "dry, light wind"):
        assert value in text


def test_identities_are_complete(result: RunResult) -> None:
    text = part(result, "identities")
    for value in ("sitl (simulated field)", "Seed 7", "00abcdef", "db53905e", "a" * 12, "b" * 12):
        assert value in text
