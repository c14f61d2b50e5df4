"""`python -m tools.results [PAGE…]`: writes what each block's command prints into the pages, or compares it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from tools.results import page
from tools.results.compare import first_difference
from tools.results.run import ROOT, CommandFailed, lacks_data, output

FOLDERS = ("docs", "companion/models")


def pages() -> list[Path]:
    """Every page of the project that may hold blocks, in the order of their paths."""
    return [file for folder in FOLDERS for file in sorted((ROOT / folder).rglob("*.md"))]


def differences(file: Path, all_blocks: bool = False) -> Iterator[str]:
    """One line for each block of the page that no longer holds; only the cheap ones unless `all_blocks`."""
    for block in page.blocks(file.read_text(encoding="utf-8")):
        if not (all_blocks or block.cheap) or lacks_data(block):
            continue
        print(f"{file}:{block.line}: {block.command}", file=sys.stderr)
        try:
            difference = first_difference(block.body, page.body_of(output(block), block), block.tolerance)
        except CommandFailed as error:
            difference = str(error)
        if difference is not None:
            yield f"{file}:{block.line}: {difference}"


def write(file: Path, cheap_only: bool) -> None:
    """Writes the page anew. Raises CommandFailed, with the page as it was."""

    def printed(block: page.Block) -> str | None:
        if lacks_data(block) or (cheap_only and not block.cheap):
            return None
        print(f"{file}:{block.line}: {block.command}", file=sys.stderr)
        return output(block)

    old = file.read_text(encoding="utf-8")
    new = page.filled(old, printed)
    if new != old:
        file.write_text(new, encoding="utf-8")


def main(arguments: list[str]) -> int:
    """1 when a page and what its commands print differ, or a command fails; 2 on bad input."""
    parser = argparse.ArgumentParser(prog="python -m tools.results", description=__doc__.partition(": ")[2])
    parser.add_argument("pages", nargs="*", type=Path, metavar="PAGE", help="all pages in docs if none is given")
    parser.add_argument("--check", action="store_true", help="compare the cheap blocks and write nothing")
    parser.add_argument("--all", action="store_true", help="with --check: the long ones, too")
    parser.add_argument("--cheap", action="store_true", help="write only the cheap blocks")
    options = parser.parse_args(arguments)
    status = 0
    try:
        for file in options.pages or pages():
            if not options.check:
                write(file, options.cheap)
                continue
            for line in differences(file, options.all):
                print(line)
                status = 1
    except (OSError, page.PageError) as error:
        print(f"{file}: {error}", file=sys.stderr)
        return 2
    except CommandFailed as error:
        print(f"{file}: {error}", file=sys.stderr)
        return 1
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
