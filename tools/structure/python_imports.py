"""Which Python file of the project imports which: every import statement, also within functions and for types alone."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

# Folders that modules are imported from; the longest that fits a file counts.
ROOTS = ("protocol/python", "companion/src", "hil_tests", ".")

PROJECT = ("rover_protocol", "rover", "rover_hil", "tools")


def is_test(path: Path) -> bool:
    """Whether a file belongs to tests."""
    return "tests" in path.parts or path.name == "conftest.py"


def modules_of(files: Iterable[Path]) -> dict[str, Path]:
    """Names of the project's own modules, tests and examples apart; paths are relative to the repository."""
    named = {}
    for path in files:
        root = max((root for root in ROOTS if root == "." or path.is_relative_to(root)), key=len)
        parts = path.relative_to(root).with_suffix("").parts
        if parts[0] in PROJECT and not is_test(path):
            named[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return named


def imports_of(source: str, module: str, known: Mapping[str, Path]) -> set[str]:
    """The modules among `known` that a file names in its imports; a package stands for its `__init__.py`."""
    found = set()
    for name in _names(ast.parse(source), module):
        while name and name not in known:
            name = name.rpartition(".")[0]
        if name and name != module:
            found.add(name)
    return found


def _names(tree: ast.AST, module: str) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            # A relative import of a test: its own folder, which is none of the project's modules.
            base = node.module or "" if node.level == 0 else f"{module.rpartition('.')[0]}.{node.module or ''}"
            yield from (f"{base}.{alias.name}" for alias in node.names)


def cycles(graph: Mapping[str, Iterable[str]]) -> list[list[str]]:
    """Groups of nodes that reach each other, each in alphabetical order (Tarjan's strongly connected components)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    groups: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(graph.get(node, ())):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            at = stack.index(node)
            group = stack[at:]
            del stack[at:]
            if len(group) > 1:
                groups.append(sorted(group))

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return sorted(groups)


def unreached(graph: Mapping[str, Iterable[str]], entries: Sequence[str]) -> list[str]:
    """Nodes that none of the entries leads to."""
    seen: set[str] = set()
    waiting = list(entries)
    while waiting:
        node = waiting.pop()
        if node not in seen:
            seen.add(node)
            waiting += graph.get(node, ())
    return sorted(set(graph) - seen)
