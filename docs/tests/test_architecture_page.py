"""docs/reference/architecture.md names the types whose methods are split over files, and the folders that exist."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
PAGE = (REPOSITORY / "docs/reference/architecture.md").read_text(encoding="utf-8")
CRATES = (
    "firmware/core/src",
    "firmware/pico/src",
    "firmware/sitl/src",
    "firmware/mcp2515/src",
    "companion/native/src",
    "hil_tests/plant/src",
)


def split_types() -> dict[tuple[str, str], set[str]]:
    """(type, crate) to the files of its methods, where there are several; two types of one name do not count."""
    files: dict[tuple[str, str], set[str]] = defaultdict(set)
    defined: dict[tuple[str, str], int] = defaultdict(int)
    for crate in CRATES:
        for file in (REPOSITORY / crate).rglob("*.rs"):
            text = file.read_text(encoding="utf-8")
            for name in re.findall(r"^impl(?:<[^>]*>)?\s+([A-Z]\w*)(?:<[^>]*>)?\s*\{", text, re.MULTILINE):
                files[name, crate].add(file.relative_to(REPOSITORY / crate).as_posix())
            for name in re.findall(r"^(?:pub(?:\([^)]*\))? )?(?:struct|enum) (\w+)", text, re.MULTILINE):
                defined[name, crate] += 1
    return {key: where for key, where in files.items() if len(where) > 1 and defined[key] == 1}


def test_every_type_with_split_methods_is_listed_with_its_files() -> None:
    rows = re.findall(r"^\| `(\w+)` of `([\w/]+)` \| (.+) \|$", PAGE, re.MULTILINE)
    assert {(name, crate): set(re.findall(r"`([^`]+)`", files)) for name, crate, files in rows} == split_types()


def test_the_folders_of_the_companion_are_in_the_order_that_lint_checks() -> None:
    row = re.search(r"^\| `companion/src/rover` \| ([^|]+) \|", PAGE, re.MULTILINE)
    assert row is not None
    contract = (REPOSITORY / ".importlinter").read_text(encoding="utf-8")
    layers = contract[contract.index("containers = rover") :].split("layers =", 1)[1].split("\n\n", 1)[0].split("\n")
    listed = [layer.strip() for layer in layers if layer.strip() and ":" not in layer]
    assert row[1].split(" → ") == list(reversed(listed))
