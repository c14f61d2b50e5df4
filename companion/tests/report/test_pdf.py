"""The report on A4 pages, read back by a reader of PDF that is not ours."""

from __future__ import annotations

import io

import pypdf
import pytest
from rover.errors import BadInput
from rover.report.html import report_html
from rover.report.map_plot import draw_map, png_bytes
from rover.report.pdf import report_pdf, require_pdf
from rover.report.result import RunResult

try:
    require_pdf()
except BadInput as reason:
    pytest.skip(str(reason), allow_module_level=True)

A4_POINTS = (595.28, 841.89)


@pytest.fixture(scope="module")
def content(result: RunResult) -> bytes:
    return report_pdf(report_html(result, png_bytes(draw_map(result))))


def test_every_page_is_a4_and_says_which_it_is(content):
    pages = pypdf.PdfReader(io.BytesIO(content)).pages
    for number, page in enumerate(pages, start=1):
        assert (float(page.mediabox.width), float(page.mediabox.height)) == pytest.approx(A4_POINTS, abs=0.1)
        assert f"{number} / {len(pages)}" in page.extract_text()


def test_it_holds_what_the_report_says(content, result):
    text = " ".join(page.extract_text() for page in pypdf.PdfReader(io.BytesIO(content)).pages)
    for section in ("When and where", "Indications", "What this report does not say", "Timeline", "Identities"):
        assert section in text
    for detection in result.detections:
        assert f"{detection.x:.2f} m" in text
    assert result.timeline[-1].text.split()[0] in text


def test_the_same_run_gives_the_same_bytes(content, result):
    assert report_pdf(report_html(result, png_bytes(draw_map(result)))) == content


def test_nothing_is_fetched_from_elsewhere(tmp_path):
    secret = tmp_path / "secret.svg"
    secret.write_text('<svg xmlns="http://www.w3.org/2000/svg"><text>never shown</text></svg>')
    pages = pypdf.PdfReader(io.BytesIO(report_pdf(f'<p>here</p><img src="{secret.as_uri()}">'))).pages
    assert "never shown" not in pages[0].extract_text()
