"""Small pieces of HTML. Text is escaped here and nowhere else: `Html` is trusted, `str` is not."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Sequence
from typing import NewType

# Finished markup.
Html = NewType("Html", str)

NOTHING = Html("")


def text(value: object) -> Html:
    """Escaped text."""
    return Html(html.escape(str(value), quote=True))


def join(parts: Iterable[Html], between: str = "") -> Html:
    """Pieces one after the other."""
    return Html(between.join(parts))


def tag(name: str, content: Html, css: str = "", identifier: str = "") -> Html:
    """An element around finished markup."""
    marks = (f' id="{html.escape(identifier)}"' if identifier else "") + (f' class="{html.escape(css)}"' if css else "")
    return Html(f"<{name}{marks}>{content}</{name}>")


def paragraph(content: str, css: str = "") -> Html:
    """A paragraph of plain text."""
    return tag("p", text(content), css)


def section(title: str, identifier: str, *content: Html) -> Html:
    """A headed part of the document."""
    return tag("section", join([tag("h2", text(title)), *content], "\n"), identifier=identifier)


def table(head: Sequence[str], rows: Iterable[Sequence[Html]], numeric: Sequence[int] = (), css: str = "") -> Html:
    """A table that scrolls sideways on a narrow screen; `numeric`: columns that align right."""

    header = join(Html(f"<th{_aligned(column, numeric)}>{text(title)}</th>") for column, title in enumerate(head))
    body = join(
        (
            tag(
                "tr",
                join(
                    # The title travels with the cell: on a telephone there is no room for a head row.
                    Html(f'<td{_aligned(column, numeric)} data-title="{text(title)}">{entry}</td>')
                    for column, (title, entry) in enumerate(zip(head, row, strict=True))
                ),
            )
            for row in rows
        ),
        "\n",
    )
    start = f'<div class="scroll"><table class="{html.escape(css)}">' if css else '<div class="scroll"><table>'
    return Html(f"{start}\n<thead><tr>{header}</tr></thead>\n<tbody>{body}</tbody></table></div>")


def _aligned(column: int, numeric: Sequence[int]) -> str:
    return ' class="number"' if column in numeric else ""


def pairs(rows: Iterable[tuple[str, Html]], css: str = "pairs") -> Html:
    """Names with their values."""
    entries = (Html(f"<div><dt>{text(name)}</dt><dd>{value}</dd></div>") for name, value in rows)
    return tag("dl", join(entries, "\n"), css)


def bullets(entries: Iterable[str]) -> Html:
    """A list of sentences."""
    return tag("ul", join((tag("li", text(entry)) for entry in entries), "\n"))


def details(summary: str, *content: Html) -> Html:
    """A part that is folded away on the screen and open on paper."""
    return Html(f"<details><summary>{text(summary)}</summary>\n{join(content)}</details>")


def picture(png: bytes, alternative: str, css: str = "") -> Html:
    """An embedded PNG."""
    data = base64.b64encode(png).decode("ascii")
    return Html(f'<img class="{html.escape(css)}" alt="{text(alternative)}" src="data:image/png;base64,{data}">')
