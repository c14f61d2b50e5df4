"""The Python packages that requirements/*.lock name, with the licences that the installed ones tell of themselves."""

from __future__ import annotations

import importlib.metadata
import re
import sys
from collections.abc import Mapping
from email.message import Message
from pathlib import Path
from typing import Any, cast

from tools.supply_chain.component import Component

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

STATED = Path(__file__).with_name("stated.toml")
# The lock of tests and lint: nothing of it is on a rover.
DEVELOPMENT = "dev"
ENTRY = re.compile(r"^([\w.-]+)==([^ ;\\]+)(.*(?:\n[ \t]+.*)*)", re.M)
HASH = re.compile(r"--hash=sha256:([0-9a-f]{64})")
CLASSIFIERS = {
    "License :: OSI Approved :: MIT License": "MIT",
    "License :: OSI Approved :: Apache Software License": "Apache-2.0",
    "License :: OSI Approved :: ISC License (ISCL)": "ISC",
}


def packages(root: Path, lock: str) -> set[Component]:
    """Of requirements/LOCK.lock."""
    said = stated()["licences"]
    text = (root / "requirements" / f"{lock}.lock").read_text()
    return {
        Component("pypi", name, version, said.get(name) or _licence(name), tuple(HASH.findall(rest)))
        for name, version, rest in ENTRY.findall(text)
    }


def locks(root: Path) -> list[str]:
    """Those whose packages may be on a rover or beside it."""
    return sorted(path.stem for path in (root / "requirements").glob("*.lock") if path.stem != DEVELOPMENT)


def installed(name: str) -> bool:
    return _metadata(name) is not None


def stated() -> Mapping[str, Mapping[str, str]]:
    """The content of STATED."""
    content: dict[str, dict[str, str]] = tomllib.loads(STATED.read_text())
    return content


def _metadata(name: str) -> Message | None:
    try:
        return cast(Message, cast(Any, importlib.metadata.metadata(name)))
    except importlib.metadata.PackageNotFoundError:
        return None


def _licence(name: str) -> str:
    """An SPDX expression; "" for a package that does not tell one, or is not installed."""
    metadata = _metadata(name)
    if metadata is None:
        return ""
    expression = metadata["License-Expression"]
    if expression:
        return str(expression)
    told = [CLASSIFIERS[each] for each in metadata.get_all("Classifier") or [] if each in CLASSIFIERS]
    return " AND ".join(sorted(set(told)))
