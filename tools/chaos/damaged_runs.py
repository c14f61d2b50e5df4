"""A finished run with one of its files damaged, read by every command that reads runs."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from random import Random

from tools.chaos.damage import DAMAGES
from tools.chaos.process import run
from tools.chaos.trial import ARCHIVES_MB, COMMAND_S, Trial
from tools.chaos.verdict import complaints

LOG = "mission.mcap"
# A replay or a recovery does the mission's work again; a resumed one drives it.
MISSION_S = 300.0
READERS = (
    ("recover", "RUN", "--out", "OUT", "--quiet"),
    ("recover", "RUN/mission.mcap", "--out", "OUT", "--quiet"),
    ("replay", "RUN/mission.mcap", "--rig", "sitl"),
    ("run", "MISSION", "--resume", "RUN", "--out", "OUT", "--quiet"),
    ("track", "RUN/mission.mcap?count=5", "--camera", "lepton-160", "--map", "RUN"),
    ("capture", "RUN/mission.mcap", "--out", "OUT", "--count", "2"),
    ("tell", "RUN", "state"),
    ("compare", "WHOLE", "RUN"),
    ("compare", "RUN", "WHOLE", "--json"),
    ("verify", "RUN"),
    ("pdf", "RUN", "--out", "OUT.pdf"),
)
# What a command needs most, where it is not survey and keyframes.
NEEDED = {
    "verify": ["manifest.json"],
    "pdf": ["summary.json", "report.html"],
    "compare": ["summary.json", "survey.npz"],
}
SHORT = ("tell", "capture", "track", "compare", "verify", "pdf")


def damaged_run(finished: Callable[[], Path], mission: Path) -> Callable[[Path, Random], Trial]:
    """`finished`: the folder of a run of `mission`, made when it is first asked for."""

    def trial(folder: Path, random: Random) -> Trial:
        copy = folder / "run"
        shutil.copytree(finished(), copy, ignore=lambda _, names: [name for name in names if name.endswith(".sock")])
        reader = random.choice(READERS)
        names = sorted(path.name for path in copy.iterdir() if path.is_file())
        # Half of the time what the command needs most, else any of them.
        reads_log = f"RUN/{LOG}" in " ".join(reader) or reader[0] == "recover"
        liked = [LOG] if reads_log else NEEDED.get(reader[0], ["survey.npz", "keyframes.npz"])
        name = random.choice(liked if random.random() < 0.6 else names)
        damage = random.choice(DAMAGES)
        file = copy / name
        before = file.read_bytes()
        file.write_bytes(damage(before, random))
        stand_for = {
            "MISSION": str(mission),
            "OUT": str(folder / "out"),
            "OUT.pdf": str(folder / "out.pdf"),
            "WHOLE": str(finished()),
        }
        words = [stand_for.get(word, word).replace("RUN", str(copy)) for word in reader]
        limit = COMMAND_S if reader[0] in SHORT else MISSION_S
        ended = run(*words, limit_s=limit, cwd=folder)
        result = Trial(f"rover {' '.join(reader)}, {damage.__name__} {name}", complaints(ended, limit, ARCHIVES_MB))
        if reader[0] == "recover" and ended.code == 0:
            result.wrong += _whole(folder / "out")
        return result

    return trial


def _whole(out: Path) -> list[str]:
    try:
        summary = json.loads((out / "summary.json").read_text())
    except (OSError, ValueError) as error:
        return [f"what was recovered cannot be read: {error}"]
    return [] if summary.get("recovered_until_s") is not None else ["recovered, and no word until when"]
