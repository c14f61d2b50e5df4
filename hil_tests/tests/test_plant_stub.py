"""rover_plant.pyi names and describes exactly what the compiled module has."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
import rover_plant

STUB = Path(__file__).resolve().parents[1] / "plant" / "rover_plant.pyi"
TREE = ast.parse(STUB.read_text(encoding="utf-8"))
CLASSES = {node.name: node for node in TREE.body if isinstance(node, ast.ClassDef)}


def members(node: ast.ClassDef) -> set[str]:
    functions = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
    variables = {
        item.target.id for item in node.body if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name)
    }
    return (functions | variables) - {"__init__"}


def test_the_stub_has_every_class() -> None:
    assert set(CLASSES) == {name for name, value in vars(rover_plant).items() if isinstance(value, type)}


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_the_stub_has_every_member_with_a_word_about_it(name: str) -> None:
    compiled = {member for member in dir(getattr(rover_plant, name)) if not member.startswith("_")}
    assert members(CLASSES[name]) == compiled
    for item in ast.walk(CLASSES[name]):
        if isinstance(item, (ast.FunctionDef, ast.ClassDef)):
            assert ast.get_docstring(item), item.name
