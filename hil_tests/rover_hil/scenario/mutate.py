"""Takes one guard out at a time and shows that scenarios notice.

python -m rover_hil.scenario.mutate                       all guards, each against the scenarios that it names
python -m rover_hil.scenario.mutate --guard sonar         those whose name holds a word
python -m rover_hil.scenario.mutate --full                each guard against every scenario: the whole table

Each mutant is a copy of the sources in a folder of its own with one place changed; nothing here touches the originals.
Guards in the board's own code are taken out of the firmware of the emulated board, all others of rover-sitl.
Ends with 1 when a scenario passes that `mutations.toml` names for a guard, or is named for none.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rover.errors import BadInput, PreflightFailed, RoverError
from rover.toml_table import Table

from rover_hil.scenario.library import find, shipped
from rover_hil.scenario.reading import load_scenario

ROOT = Path(__file__).resolve().parents[3]
MUTATIONS = Path(__file__).with_name("mutations.toml")
EDIT = ("file", "find", "replace")
# What only the emulated board runs: those guards are tested on it.
BOARD = "firmware/pico"
TOOLCHAIN = "firmware/toolchain.sh"
RUST = ("protocol/rust", "firmware/core", "firmware/sitl", "firmware/long_arithmetic", "firmware/mcp2515")
PYTHON = ("companion/src/rover", "hil_tests/rover_hil")
# The companion looks for its model beside its sources' folder.
MODELS = "companion/models"
JOBS = 2
QUICK_BOARD = {"CARGO_PROFILE_RELEASE_LTO": "off", "CARGO_PROFILE_RELEASE_CODEGEN_UNITS": "16"}
# Mutants are built once and run for a minute: what building saves is worth more than their speed.
QUICK = {"CARGO_PROFILE_RELEASE_OPT_LEVEL": "0", "CARGO_PROFILE_RELEASE_DEBUG": "0", "RUSTFLAGS": "-Awarnings"}


@dataclass(frozen=True)
class Edit:
    """One place of one file, relative to the repository. `file` may be a folder: one of its files holds the place."""

    file: str
    find: str
    replace: str


@dataclass(frozen=True)
class Mutation:
    """A guard, and the edits that take it out."""

    guard: str
    noticed_by: tuple[str, ...]
    edits: tuple[Edit, ...]

    @property
    def in_rust(self) -> bool:
        """Needs a build of the firmware."""
        return any(not _is_python(edit) for edit in self.edits)

    @property
    def rig(self) -> str:
        """Where its scenarios are run."""
        return "emulator" if any(edit.file.startswith(BOARD) for edit in self.edits) else "sitl"


def load_mutations(path: Path = MUTATIONS) -> list[Mutation]:
    """All mutations of a file. Raises BadInput."""
    top = Table.of_file(path).only("mutation")
    known = [file.stem for file in shipped()]
    mutations = []
    for table in top.tables("mutation"):
        also = [entry.only(*EDIT) for entry in table.only("guard", "noticed_by", "also", *EDIT).tables("also")]
        edits = tuple(Edit(t.text("file"), t.text("find"), t.text("replace", "")) for t in (table, *also))
        mutations.append(Mutation(table.text("guard"), table.choices("noticed_by", known), edits))
    return mutations


def locate(root: Path, edit: Edit) -> Path:
    """The file that holds the place of an edit, once and only once. Raises BadInput."""
    given = root / edit.file
    files = [given] if given.is_file() else sorted(f for f in given.rglob("*.rs") if not f.stem.endswith("_tests"))
    counts = {file: file.read_text(encoding="utf-8").count(edit.find) for file in files}
    if sum(counts.values()) != 1:
        times = sum(counts.values())
        raise BadInput(f"{edit.file}: {edit.find.strip()!r} stands there {times} times; correct {MUTATIONS.name}")
    return next(file for file, count in counts.items() if count)


def check_places(mutations: Sequence[Mutation], root: Path = ROOT) -> list[str]:
    """One line for each edit whose place is not there any more."""
    missing = []
    for mutation in mutations:
        for edit in mutation.edits:
            try:
                locate(root, edit)
            except BadInput as error:
                missing.append(f"guard {mutation.guard!r}: {error}")
    return missing


class Workshop:
    """A folder with copies of the sources and a target directory of its own, so that building is incremental."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.rust = folder / "rust"
        self.python = folder / "python"
        for name in RUST:
            if (ROOT / name).is_dir():
                _copy(ROOT / name, self.rust / name)
        members = ", ".join(f'"{name}"' for name in RUST if (self.rust / name).is_dir())
        manifest = (ROOT / "Cargo.toml").read_text(encoding="utf-8")
        begin = manifest.index("members = [")
        end = manifest.index("]", begin)
        manifest = manifest[:begin] + f"members = [{members}" + manifest[end:]
        _write(self.rust / "Cargo.toml", manifest)
        shutil.copyfile(ROOT / "Cargo.lock", self.rust / "Cargo.lock")
        _copy(ROOT / BOARD, self.rust / BOARD)
        shutil.copyfile(ROOT / TOOLCHAIN, self.rust / TOOLCHAIN)
        for name in PYTHON:
            _copy(ROOT / name, self.python / Path(name).name)
        _copy(ROOT / MODELS, folder / Path(MODELS).name)

    def firmware(self, mutation: Mutation | None, rig: str) -> dict[str, str]:
        """The rig's firmware without the guard, or the sound one, as variables that name it to the rig.

        Raises PreflightFailed when it does not build.
        """
        edits = [edit for edit in mutation.edits if not _is_python(edit)] if mutation else []
        target = self.folder / "target"
        if rig == "emulator":
            # A path through rustup's toolchain or Debian's, as for the board itself.
            build = ["sh", "-c", f". {TOOLCHAIN}; thumb_build {BOARD} --quiet"]
            made = {"ROVER_ELF": str(target / "thumbv6m-none-eabi" / "release" / "rover-pico")}
            quick = QUICK_BOARD
        else:
            build = ["cargo", "build", "--release", "--quiet", "-p", "rover-sitl"]
            made = {"ROVER_SITL": str(target / "release" / "rover-sitl")}
            quick = QUICK
        with _Changed(self.rust, edits):
            environment = {**os.environ, **quick, "CARGO_TARGET_DIR": str(target)}
            built = subprocess.run(build, cwd=self.rust, env=environment, capture_output=True, text=True)
        if built.returncode != 0:
            guard = mutation.guard if mutation else "none"
            raise PreflightFailed(f"guard {guard!r} taken out: does not build: {' '.join(built.stderr.split())[-600:]}")
        return made

    def failing(self, mutation: Mutation | None, scenarios: Sequence[Path], rig: str) -> list[str]:
        """Names of the scenarios that fail without the guard."""
        in_python = [edit for edit in mutation.edits if _is_python(edit)] if mutation else []
        environment = {**os.environ, "PYTHONPATH": str(self.python)}
        environment |= self.firmware(mutation if mutation and mutation.in_rust else None, rig)
        with _Changed(self.python, in_python):
            parts = [list(scenarios[part::JOBS]) for part in range(JOBS)]
            running = [_start(part, environment, rig) for part in parts if part]
            return sorted(name for process in running for name in _failures(process))


class _Changed:
    """Copies with some edits in them, put right again at the end."""

    def __init__(self, copies: Path, edits: Sequence[Edit]) -> None:
        self._sound: dict[Path, str] = {}
        self._changed: dict[Path, str] = {}
        for edit in edits:
            file = locate(copies, Edit(str(_place(edit.file)), edit.find, edit.replace))
            text = self._changed.get(file, file.read_text(encoding="utf-8"))
            self._sound.setdefault(file, text)
            self._changed[file] = text.replace(edit.find, edit.replace)

    def __enter__(self) -> None:
        for file, text in self._changed.items():
            file.write_text(text, encoding="utf-8")

    def __exit__(self, *_: object) -> None:
        for file, text in self._sound.items():
            file.write_text(text, encoding="utf-8")


def _is_python(edit: Edit) -> bool:
    return edit.file.endswith(".py")


def _place(file: str) -> Path:
    for name in PYTHON:
        if file.startswith(name + "/"):
            return Path(name).name / Path(file).relative_to(name)
    return Path(file)


def _start(scenarios: Sequence[Path], environment: dict[str, str], rig: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "rover_hil.scenario.verdicts", "--rig", rig, *map(str, scenarios)]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def _failures(process: subprocess.Popen[str]) -> list[str]:
    said, error = process.communicate()
    if process.returncode != 0:
        raise PreflightFailed(f"the scenarios did not run: {error.strip().splitlines()[-1:]}")
    return [name for name, passed in json.loads(said).items() if not passed]


def _copy(source: Path, target: Path) -> None:
    """A fresh copy, its files dated now: cargo must never take the last mutant for the sound firmware."""
    ignored = shutil.ignore_patterns("target", "__pycache__", "*.pyc")
    fresh = target.with_name(target.name + ".new")
    shutil.rmtree(fresh, ignore_errors=True)
    shutil.copytree(source, fresh, ignore=ignored, copy_function=shutil.copyfile)
    shutil.rmtree(target, ignore_errors=True)
    target.parent.mkdir(parents=True, exist_ok=True)
    fresh.rename(target)


def _write(path: Path, content: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content, encoding="utf-8")


def markdown(found: dict[str, list[str]]) -> str:
    """The table of docs/results/scenarios.md."""
    rows = [f"| {guard} | {', '.join(names) or '**none**'} |" for guard, names in found.items()]
    return "\n".join(["| guard taken out | scenarios that fail |", "|---|---|", *rows]) + "\n"


def run(wanted: Sequence[Mutation], folder: Path, full: bool) -> dict[str, list[str]]:
    """Guard to failing scenarios. Raises BadInput, PreflightFailed."""
    missing = check_places(wanted)
    if missing:
        raise BadInput("; ".join(missing))
    workshop = Workshop(folder)
    for rig in sorted({mutation.rig for mutation in wanted}):
        names = _on(rig) if full else _named([mutation for mutation in wanted if mutation.rig == rig])
        if broken := workshop.failing(None, find(names), rig):
            raise PreflightFailed(f"with all guards in place these fail already on {rig}: {', '.join(broken)}")
    found: dict[str, list[str]] = {}
    for number, mutation in enumerate(wanted, 1):
        try:
            tried = _on(mutation.rig) if full else mutation.noticed_by
            failing = workshop.failing(mutation, find(tried), mutation.rig)
        except PreflightFailed as error:  # the others are worth running all the same
            print(error, file=sys.stderr)
            failing = []
        found[mutation.guard] = failing
        passed = [name for name in mutation.noticed_by if name not in failing]
        print(f"{number}/{len(wanted)} {mutation.guard}: {', '.join(failing) or 'none'}", end="")
        print(f"; NOT NOTICED BY {', '.join(passed)}" if passed else "", flush=True)
    return found


def complaints(mutations: Sequence[Mutation], found: dict[str, list[str]]) -> list[str]:
    """One line for each scenario that did not notice, or that no guard names."""
    lines = [
        f"{name} passes without the guard {mutation.guard!r}"
        for mutation in mutations
        for name in mutation.noticed_by
        if name not in found.get(mutation.guard, [name])
    ]
    idle = [file.stem for file in shipped() if file.stem not in _named(mutations)]
    return lines + [f"{name} is named for no guard" for name in idle]


def _on(rig: str) -> list[str]:
    """Names of the scenarios that can exist on a rig."""
    return [file.stem for file in shipped() if rig in load_scenario(file).rigs]


def _named(mutations: Sequence[Mutation]) -> list[str]:
    return sorted({name for mutation in mutations for name in mutation.noticed_by})


def main(argv: list[str] | None = None) -> int:
    """Returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--guard", action="append", default=[], help="only guards whose name holds this")
    parser.add_argument("--full", action="store_true", help="every scenario, not only those that a guard names")
    parser.add_argument("--table", type=Path, help="write the table here, as Markdown")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "mutants", help="where mutants are built")
    given = parser.parse_args(argv)
    try:
        mutations = load_mutations()
        wanted = [m for m in mutations if not given.guard or any(word in m.guard for word in given.guard)]
        if not wanted:
            raise BadInput(f"--guard {' '.join(given.guard)}: no guard's name holds that")
        found = run(wanted, given.folder.resolve(), given.full)
    except RoverError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    if given.table is not None:
        given.table.write_text(markdown(found), encoding="utf-8")
    lines = complaints(mutations, found)
    print("\n".join(lines), file=sys.stderr)
    return 1 if lines else 0


if __name__ == "__main__":
    raise SystemExit(main())
