"""The firmware's parameters, from protocol/parameters.toml: its table, the names in Python, the table in the docs."""

from __future__ import annotations

import itertools
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

RUST_HEADER = """//! Every number that may differ from one rover to the next: identifier, name, unit, default, range.
//!
//! Written by `python -m tools.generate`: change protocol/parameters.toml, not this file.

/// Name, unit, default and range of one parameter.
#[derive(Clone, Copy, Debug)]
pub struct Definition {
    pub parameter: Parameter,
    pub name: &'static str,
    pub unit: &'static str,
    pub default: i32,
    pub minimum: i32,
    pub maximum: i32,
}

/// A parameter's identifier on the wire is its discriminant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Parameter {
"""

PYTHON_HEADER = '''"""The firmware's parameters: names, units and ranges, in the order of their identifiers.

Written by `python -m tools.generate`: change protocol/parameters.toml, not this file.
"""

from rover_protocol.parameter import Parameter
'''

BEGIN = "<!-- written by python -m tools.generate -->"
END = "<!-- /written -->"
COLUMNS = "| id | name | unit | default | least | most | |\n|--:|---|---|--:|--:|--:|---|"


@dataclass(frozen=True)
class Described:
    """One parameter. start: within which a rover may set off; safety: a difference may let it hurt somebody."""

    identifier: int
    name: str
    variant: str
    unit: str
    default: int
    minimum: int
    maximum: int
    help: str
    safety: bool = False
    start: tuple[int, int] | None = None


def load(path: Path) -> tuple[Described, ...]:
    """Raises ValueError for what is missing, doubled or out of order."""
    document = tomllib.loads(path.read_text(encoding="utf-8"))
    try:
        described = tuple(_described(row) for row in document["parameter"])
    except TypeError as error:
        raise ValueError(f"{path}: {error}") from None
    for before, after in itertools.pairwise(described):
        if before.identifier >= after.identifier:
            raise ValueError(f"{path}: {after.name}: identifiers must rise")
    for each in described:
        least, most = each.start or (each.minimum, each.maximum)
        if not each.minimum <= least <= each.default <= most <= each.maximum:
            raise ValueError(f"{path}: {each.name}: minimum, start, default and maximum must not cross")
    for names in ([each.name for each in described], [each.variant for each in described]):
        if len(set(names)) != len(names):
            raise ValueError(f"{path}: a name stands twice")
    return described


def _described(row: dict[str, Any]) -> Described:
    start = row.pop("start", None)
    return Described(**row, start=None if start is None else (start[0], start[1]))


def render_rust(described: tuple[Described, ...]) -> str:
    """firmware/core/src/parameter_table.rs."""
    lines = [f"    {each.variant} = {each.identifier}," for each in described]
    lines += ["}", "", f"pub const COUNT: usize = {len(described)};", ""]
    lines += ["/// In the order of the identifiers.", "pub const DEFINITIONS: [Definition; COUNT] = ["]
    for each in described:
        lines += [
            "    Definition {",
            f"        parameter: Parameter::{each.variant},",
            f'        name: "{each.name}",',
            f'        unit: "{each.unit}",',
            f"        default: {each.default:_},",
            f"        minimum: {each.minimum:_},",
            f"        maximum: {each.maximum:_},",
            "    },",
        ]
    return RUST_HEADER + "\n".join([*lines, "];"]) + "\n"


def render_python(described: tuple[Described, ...]) -> str:
    """protocol/python/rover_protocol/parameters.py."""
    lines = [PYTHON_HEADER, "# fmt: off", "PARAMETERS = ("]
    for each in described:
        numbers = f"{each.identifier}, {each.default}, {each.minimum}, {each.maximum}"
        least, most = each.start or (each.minimum, each.maximum)
        lines += [
            f'    Parameter("{each.name}", "{each.unit}", {numbers}, {least}, {most}, {each.safety},',
            f'              "{each.help}"),',
        ]
    lines += [")", "# fmt: on", "", "BY_NAME = {parameter.name: parameter for parameter in PARAMETERS}"]
    return "\n".join(lines) + "\n"


def render_document(described: tuple[Described, ...], before: str) -> str:
    """docs/reference/protocol.md with its table anew. Raises ValueError when it has no place for one."""
    rows = [
        f"| {each.identifier} | {each.name} | {each.unit} | {each.default} | {each.minimum} | {each.maximum} "
        f"| {each.help} |"
        for each in described
    ]
    table = "\n".join([BEGIN, "", COLUMNS, *rows, "", END])
    text, count = re.subn(rf"{re.escape(BEGIN)}.*?{re.escape(END)}", lambda _: table, before, flags=re.DOTALL)
    if count != 1:
        raise ValueError(f"docs/reference/protocol.md: one {BEGIN} … {END} is expected, not {count}")
    return text
