"""Trials one after the other, each from the campaign's seed and its own number, and their counts."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from random import Random
from threading import Lock

from tools.chaos import real_time, simulated
from tools.chaos.damaged_runs import damaged_run
from tools.chaos.inputs import hostile_input
from tools.chaos.process import run
from tools.chaos.trial import Run, Trial

# A small field for a short while: most of a trial is what happens to it.
MISSION = """
[mission]
name = "chaos"
time_of_day = "13:00"
max_duration_s = 45.0

[area]
width_m = 1.6
height_m = 1.8

[launch]
x_m = 0.4
y_m = 0.4
heading_deg = 45.0

[field]
soil = "loam"
rocks = 1
grass = 0
surface_mines = 1
buried_mine_depths_cm = [1.0]
"""
# How many of a hundred trials are of each kind.
SHARES = {
    "hostile file": 74,
    "damaged run": 12,
    "kill -9": 4,
    "told to end": 2,
    "disk full": 2,
    "frozen": 2,
    "port pulled": 2,
    "second client": 2,
}


@dataclass(frozen=True)
class Done:
    """One trial of a campaign. seconds: on the wall."""

    number: int
    kind: str
    trial: Trial
    seconds: float


class Campaign:
    """In a folder of its own, which goes when it is closed; what went wrong stays in `keep`."""

    def __init__(self, seed: int, keep: Path | None = None) -> None:
        self._seed = seed
        self._keep = keep
        self._folder = tempfile.TemporaryDirectory(prefix="chaos-")
        root = Path(self._folder.name)
        mission = root / "chaos.toml"
        mission.write_text(MISSION)

        first = Lock()

        @lru_cache(maxsize=1)
        def made() -> Path:
            ended = run("run", mission, "--seed", seed % 1000, "--out", root / "finished", "--quiet", limit_s=900.0)
            if ended.code not in (0, 8):
                raise RuntimeError(f"the mission to damage did not end: {ended.err}")
            return root / "finished"

        def finished() -> Path:
            with first:
                return made()

        self._kinds: Mapping[str, Run] = {
            "hostile file": hostile_input,
            "damaged run": damaged_run(finished, mission),
            "kill -9": simulated.killed(mission),
            "told to end": simulated.told_to_end(mission),
            "disk full": simulated.without_disk(mission),
            "frozen": real_time.frozen(mission),
            "port pulled": real_time.pulled(mission),
            "second client": real_time.second_client(mission),
        }

    def __enter__(self) -> Campaign:
        return self

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()

    def one(self, number: int, kind: str | None = None) -> Done:
        """The trial of this number; of another kind than its own when one is named."""
        random = Random(f"{self._seed}/{number}")
        drawn = random.choices(list(SHARES), list(SHARES.values()))[0]
        name = kind or drawn
        folder = Path(self._folder.name) / f"{number}"
        folder.mkdir()
        began = time.monotonic()
        trial = self._kinds[name](folder, random)
        if trial.wrong and self._keep is not None:
            shutil.copytree(folder, self._keep / f"{number}", symlinks=True, ignore=_no_file, dirs_exist_ok=True)
        shutil.rmtree(folder, ignore_errors=True)
        return Done(number, name, trial, time.monotonic() - began)

    def trials(self, many: int, minutes: float, first: int, kind: str | None, jobs: int) -> Iterator[Done]:
        """`many` of them, or as many as so many minutes allow, `jobs` at a time; as they end."""
        end = time.monotonic() + 60.0 * minutes

        def in_time(number: int) -> Done | None:
            return self.one(number, kind) if time.monotonic() < end else None

        with ThreadPoolExecutor(jobs) as pool:
            for each in as_completed([pool.submit(in_time, number) for number in range(first, first + many)]):
                done = each.result()
                if done is not None:
                    yield done


def _no_file(folder: str, names: list[str]) -> list[str]:
    """Pipes and sockets are not copied."""
    paths = [(name, Path(folder, name)) for name in names]
    return [name for name, path in paths if not path.is_symlink() and not path.is_file() and not path.is_dir()]


def table(done: list[Done]) -> str:
    """Counts by kind, as Markdown."""
    lines = ["| kind | trials | wrong | longest, s |", "|---|--:|--:|--:|"]
    for kind in SHARES:
        of = [each for each in done if each.kind == kind]
        if of:
            wrong = sum(bool(each.trial.wrong) for each in of)
            lines.append(f"| {kind} | {len(of)} | {wrong} | {max(each.seconds for each in of):.0f} |")
    lines.append(f"| all | {len(done)} | {sum(bool(each.trial.wrong) for each in done)} | |")
    lost = [each.trial.loss_s for each in done if each.trial.loss_s is not None]
    if lost:
        lines += ["", f"Mission time lost to kill -9, of {len(lost)}: {max(lost):.1f} s at most."]
    powered = [each.trial.powered_s for each in done if each.trial.powered_s is not None]
    if powered:
        lines += ["", f"Motors powered behind a frozen companion, of {len(powered)}: {max(powered):.2f} s at most."]
    return "\n".join(lines)
