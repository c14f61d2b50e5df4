"""Hostile files over every command that takes one."""

from __future__ import annotations

import shlex
from pathlib import Path
from random import Random

from rover.record.manifest import MANIFEST, manifest_bytes

from tools.chaos.command_lines import FRAME, LINES, MISSION, WAY
from tools.chaos.hostile import hostile_file
from tools.chaos.process import run
from tools.chaos.trial import COMMAND_S, PICTURES_MB, Trial
from tools.chaos.verdict import complaints

# Names that a terminal or a parser may trip over.
NAMES = ("it", "it", "it", "a b", "it\x1b[31m", "täst", "it'\"$(x)", "-it", "it%s{0}", "it\n2")


def hostile_input(folder: Path, random: Random) -> Trial:
    line = random.choice(LINES)
    (folder / "picture.png").write_bytes(FRAME.read_bytes())
    (folder / "path.json").write_bytes(WAY)
    it = folder / (random.choice(NAMES) + random.choice(line.suffixes))
    kind = hostile_file(it, random.choice(line.right), random)
    a_run = folder / "run"
    a_run.mkdir()
    (a_run / MANIFEST).write_bytes(manifest_bytes(folder, ("picture.png", "path.json")))
    stand_for = {
        "IT": str(it),
        "PICTURE": str(folder / "picture.png"),
        "PATH": str(folder / "path.json"),
        "MISSION": str(MISSION),
        "RUN": str(a_run),
    }
    words = [
        str(folder / f"out{word[3:]}") if word.startswith("OUT") else stand_for.get(word, word) for word in line.words
    ]
    ended = run(*words, limit_s=COMMAND_S, cwd=folder)
    wrong = complaints(ended, COMMAND_S, PICTURES_MB)
    return Trial(f"rover {shlex.join(line.words)}, {kind} {it.name!r}", wrong)
