"""What is served was built from the sources that lie beside it, and takes nothing from any network."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

from rover.console.app import BUILT

PAGE = BUILT.parent / "page"
SOURCES = ("index.html", "package-lock.json", "package.json", "src", "tsconfig.json", "vite.config.ts")


def files() -> list[tuple[str, Path]]:
    found = [file for name in SOURCES for file in [PAGE / name, *(PAGE / name).rglob("*")] if file.is_file()]
    return sorted((file.relative_to(PAGE).as_posix(), file) for file in found)


def test_the_page_was_built_from_its_sources() -> None:
    digest = hashlib.sha256()
    for name, file in files():
        digest.update(name.encode() + b"\0" + file.read_bytes() + b"\0")
    assert (BUILT / "SOURCES").read_text().strip() == digest.hexdigest(), "run 'make console'"


def test_the_lock_has_hashes_and_no_host() -> None:
    text = (PAGE / "package-lock.json").read_text()
    packages = {name: entry for name, entry in json.loads(text)["packages"].items() if name}
    assert [name for name, entry in packages.items() if "integrity" not in entry] == []
    assert '"resolved"' not in text


def test_the_page_asks_no_other_host_for_anything() -> None:
    assert not re.search(r"""(src|href)=["'](https?:)?//""", (BUILT / "index.html").read_text())
    assert not re.search(r"@import|url\((?!data:)", (BUILT / "assets/index.css").read_text())


def test_the_licences_of_what_is_bundled_lie_beside_it() -> None:
    text = (BUILT / "LICENCES.txt").read_text()
    names = re.findall(r"^([@\w/.-]+) \d[\w.]*, (.+)$", text, re.MULTILINE)
    assert {"ol", "uplot"} <= {name for name, _ in names}
    assert {licence for _, licence in names} <= {"MIT", "BSD-2-Clause", "BSD-3-Clause", "ISC", "Apache-2.0"}


def test_every_word_of_the_page_is_in_the_catalogue() -> None:
    catalogue = (PAGE / "src/strings.ts").read_text()
    known = set(re.findall(r"(\w+): \"", catalogue))
    asked = set()
    for name, file in files():
        if name.endswith(".ts") and name != "src/strings.ts":
            text = file.read_text()
            asked |= set(re.findall(r"\bt\(\"(\w+)\"", text))
            # A sentence in quotes would not be in the catalogue.
            quoted = re.findall(r"\"([A-Z][a-z]+ [a-z][^\"\n]*)\"", text)
            assert quoted == [] or name == "vite.config.ts", (name, quoted)
    assert asked <= known, asked - known
