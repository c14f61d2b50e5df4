"""One crate or package of a lock."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, order=True)
class Component:
    """kind: "cargo" or "pypi"; licence: SPDX expression, or ""; sha256: of each file that the lock takes."""

    kind: str
    name: str
    version: str
    licence: str
    sha256: tuple[str, ...] = ()

    @property
    def package_url(self) -> str:
        return f"pkg:{self.kind}/{self.name}@{self.version}"

    def __str__(self) -> str:
        return f"{self.name} {self.version} ({self.kind})"
