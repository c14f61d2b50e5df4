"""The blocks of a page: text in, blocks and new text out."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from tools.results.compare import EXACT, Tolerance, read_tolerance

OPENING = re.compile(r"<!--\s*results\b(?P<options>[^:]*):(?P<command>.*?)-->")
CLOSING = re.compile(r"<!--\s*/results\s*-->")
FENCE = re.compile(r"^\s*(```|~~~)")


class PageError(ValueError):
    """A marker that cannot be read; says the line."""


@dataclass(frozen=True)
class Block:
    """One command and what the page says that it prints; `line` counts from 1, that of the opening marker."""

    line: int
    command: str
    cheap: bool
    text: bool
    tolerance: Tolerance
    body: str


def blocks(page: str) -> list[Block]:
    """The blocks of a page, in its order. Raises PageError."""
    return [part for part in _parts(page) if isinstance(part, Block)]


def filled(page: str, output: Callable[[Block], str | None]) -> str:
    """The page with what `output` gives for each block in its place; None leaves a block as it is."""
    new = []
    for part in _parts(page):
        if isinstance(part, str):
            new.append(part)
        else:
            printed = output(part)
            new.append(part.body if printed is None else body_of(printed, part))
    return "".join(new)


def body_of(printed: str, block: Block) -> str:
    """What stands between a block's markers when its command prints `printed`."""
    lines = [line.rstrip() for line in printed.strip("\n").split("\n")]
    if block.text:
        return "\n".join(["", "```text", *lines, "```", "", ""])
    return "\n".join(["", *lines, "", ""])


def _parts(page: str) -> list[str | Block]:
    """Text and blocks by turns; joined, with a block's body for the block, they are the page."""
    parts: list[str | Block] = []
    outside: list[str] = []
    opening: tuple[int, re.Match[str]] | None = None
    inside: list[str] = []
    fence: str | None = None
    for number, line in enumerate(page.splitlines(keepends=True), start=1):
        if opening is None:
            outside.append(line)
            mark = FENCE.match(line)
            if mark and fence in (None, mark[1]):
                fence = mark[1] if fence is None else None
            found = OPENING.search(line)
            if fence is None and found:
                opening, inside = (number, found), []
                parts.append("".join(outside))
                outside = []
        elif CLOSING.search(line):
            parts.append(_block(*opening, "".join(inside)))
            outside, opening = [line], None
        elif OPENING.search(line):
            raise PageError(f"line {number}: a block begins before the one of line {opening[0]} has ended")
        else:
            inside.append(line)
    if opening is not None:
        raise PageError(f"line {opening[0]}: the block has no <!-- /results -->")
    return [*parts, "".join(outside)]


def _block(line: int, marker: re.Match[str], body: str) -> Block:
    cheap, text, tolerance = False, False, EXACT
    for option in marker["options"].split():
        name, _, value = option.partition("=")
        if option == "cheap":
            cheap = True
        elif option == "text":
            text = True
        elif name == "tolerance":
            try:
                tolerance = read_tolerance(value)
            except ValueError as error:
                raise PageError(f"line {line}: {error}") from error
        else:
            raise PageError(f"line {line}: `{option}` is none of cheap, text and tolerance=…")
    command = marker["command"].strip()
    if not command:
        raise PageError(f"line {line}: the block has no command")
    return Block(line, command, cheap, text, tolerance, body)
