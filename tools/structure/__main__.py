"""Files a folder, import cycles, modules that only tests import. Exit code 1 when there is a cycle or such a module.

    python -m tools.structure

Entries are what is started from outside: commands, entry points of packages, files that run as a program, tools. Rust
modules that one type's `impl` blocks are divided into on purpose name each other; they stand in SPLIT_TYPES.
"""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from pathlib import Path

from tools.structure import python_imports, rust_uses

ROOT = Path(__file__).resolve().parents[2]
CRATES = (
    "protocol/rust", "firmware/core", "firmware/mcp2515", "firmware/sitl", "firmware/pico", "companion/native",
    "hil_tests/plant",
)  # fmt: skip

# By crate: groups of modules that hold the `impl` blocks of one type, see docs/reference/architecture.md.
SPLIT_TYPES: dict[str, tuple[frozenset[str], ...]] = {
    "firmware/core": (frozenset({"crate::controller", "crate::parameter_service", "crate::test_mode"}),),
    "hil_tests/plant": (frozenset({"crate::chip::core", "crate::chip::exceptions"}),),
}

# Modules that are kept for what is to come; what they import counts as needed.
STAYS = (
    "rover.planning.planner",  # the interface to planning on exact circles, for missions of scale
    "rover.motion.trajectory.checked",
)

# A folder with more is worth a thought; printed with a mark.
MANY_FILES = 15


def tracked(*patterns: str) -> list[Path]:
    """Files under version control, and new ones, relative to the repository."""
    line = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *patterns]
    listed = subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    return [Path(name) for name in listed if (ROOT / name).is_file()]


def folders() -> list[str]:
    """A line for each folder of sources."""
    counts = Counter(path.parent for path in tracked("*.py", "*.rs") if path.name != "__init__.py")
    width = max(len(str(folder)) for folder in counts)
    return [
        f"{folder!s:{width}} {count:3}{' *' if count > MANY_FILES else ''}" for folder, count in sorted(counts.items())
    ]


def python_graph() -> tuple[dict[str, set[str]], dict[str, Path]]:
    """Who imports whom among the project's modules."""
    modules = python_imports.modules_of(tracked("*.py"))
    return {
        name: python_imports.imports_of((ROOT / path).read_text(encoding="utf-8"), name, modules)
        for name, path in modules.items()
    }, modules


def python_entries(modules: dict[str, Path]) -> list[str]:
    """What is started from outside."""
    entries = [name for name in modules if name.startswith("tools.") or name in STAYS]
    for name, path in modules.items():
        text = (ROOT / path).read_text(encoding="utf-8")
        if name.startswith("rover.cli.") or 'if __name__ == "__main__":' in text or path.name == "__main__.py":
            entries.append(name)
    for file in tracked("*pyproject.toml"):  # "module" or "module:object", behind the = of an entry point
        for line in (ROOT / file).read_text(encoding="utf-8").splitlines():
            value = line.partition("=")[2].strip().strip('"').partition(":")[0]
            if value in modules:
                entries.append(value)
    public = [path for path in tracked("docs/examples/*.py", "firmware/*.py") if not python_imports.is_test(path)]
    for path in public:
        entries += python_imports.imports_of((ROOT / path).read_text(encoding="utf-8"), path.stem, modules)
    return entries


def rust_cycles(crate: str) -> list[list[str]]:
    """Cycles of a crate that are not split on purpose."""
    sources = [path.relative_to(f"{crate}/src") for path in tracked(f"{crate}/src/*.rs")]
    modules = rust_uses.modules_of(sources)
    graph = {
        name: rust_uses.uses_of((ROOT / crate / "src" / path).read_text(encoding="utf-8"), name, modules)
        for name, path in modules.items()
    }
    return [group for group in python_imports.cycles(graph) if frozenset(group) not in SPLIT_TYPES.get(crate, ())]


def main() -> int:
    """Prints everything; returns the exit code."""
    print("\n".join(folders()))
    graph, modules = python_graph()
    found = [" <-> ".join(group) for group in python_imports.cycles(graph)]
    found += [f"{crate}: " + " <-> ".join(group) for crate in CRATES for group in rust_cycles(crate)]
    lonely = [
        name
        for name in python_imports.unreached(graph, python_entries(modules))
        if modules[name].name != "__init__.py" and not name.startswith("rover_hil.testing")
    ]
    print(f"\nimport cycles: {len(found)}", *found, sep="\n  ")
    print(f"\nmodules that only tests import: {len(lonely)}", *lonely, sep="\n  ")
    return 1 if found or lonely else 0


if __name__ == "__main__":
    sys.exit(main())
