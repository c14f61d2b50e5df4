"""Whether every crate and package is under a licence that deny.toml allows, or is noted as an exception."""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterable
from pathlib import Path

from license_expression import get_spdx_licensing

from tools.supply_chain.component import Component
from tools.supply_chain.python_packages import installed, stated

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

SPDX = get_spdx_licensing()


def allowed(root: Path) -> list[str]:
    """SPDX identifiers, of deny.toml."""
    names: list[str] = tomllib.loads((root / "deny.toml").read_text())["licenses"]["allow"]
    return names


def may_be_used(expression: str, names: Collection[str]) -> bool:
    """One side of an OR has to be allowed, both sides of an AND. Raises ExpressionError for what is not SPDX."""
    parsed = SPDX.parse(expression, validate=True)

    def holds(part: object) -> bool:
        if isinstance(part, SPDX.OR):
            return any(holds(each) for each in part.args)
        if isinstance(part, SPDX.AND):
            return all(holds(each) for each in part.args)
        return str(part) in names

    return parsed is not None and holds(parsed)


def objections(components: Iterable[Component], names: Collection[str], notice: str) -> list[str]:
    """One line for each component that may not be used as it is. `notice`: the text of NOTICE."""
    noted = stated()["noted"]
    found = []
    for component in sorted(components):
        licence = component.licence
        if not licence:
            if component.name not in noted:
                found.append(f"{component}: tells no licence: state it in tools/supply_chain/stated.toml")
        elif may_be_used(licence, names):
            continue
        elif noted.get(component.name) != licence:
            found.append(f"{component}: {licence} is not among the licences of deny.toml")
        elif component.name not in notice:
            found.append(f"{component}: {licence} has to be noted in NOTICE")
    return found


def can_be_asked(component: Component) -> bool:
    """False for a package of an extra that is not installed here, and whose licence nobody has stated."""
    return bool(component.licence) or component.kind != "pypi" or installed(component.name)
