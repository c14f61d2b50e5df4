"""One mission of a campaign: what is drawn for it, driven in a process of its own, and its row of figures."""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from rover.toml_file import read_toml
from scipy.stats import qmc

from rover_hil.campaign.file import Campaign

# Exit codes that no mission has that came to an end with a reason.
CRASHED = "crashed"
TIMED_OUT = "timed out"
COUNTS = ("collisions", "bumper_contacts", "keepout_violations", "wheel_over_mine")


@dataclass(frozen=True)
class Trial:
    """values: of the mission file, by "section.key"."""

    index: int
    seed: int
    values: dict[str, Any]


def draw(campaign: Campaign) -> list[Trial]:
    """All trials: the same for the same file, and the first ones for a larger `missions` too, where random."""
    rng = np.random.default_rng(campaign.seed)
    seeds = rng.integers(1, 2**31 - 1, campaign.missions)
    size = max(len(campaign.draw), 1)
    if campaign.sampling == "sobol":
        # Fewer than a power of two are the balanced ones' beginning.
        quantiles = qmc.Sobol(size, seed=campaign.seed).random_base2(max(campaign.missions - 1, 0).bit_length())
    else:
        quantiles = np.random.default_rng([campaign.seed, 1]).random((campaign.missions, size))
    below_one = np.minimum(quantiles, 1.0 - 1e-12)
    return [
        Trial(
            index,
            int(seeds[index]),
            {each.key: each.at(float(below_one[index, column])) for column, each in enumerate(campaign.draw)},
        )
        for index in range(campaign.missions)
    ]


def mission_text(campaign: Campaign, trial: Trial) -> bytes:
    """The mission file of a trial."""
    document = read_toml(campaign.mission)
    for key, value in trial.values.items():
        section, _, name = key.partition(".")
        document.setdefault(section, {})[name] = value
    return tomli_w.dumps(document).encode()


def drive(mission: Path, trial: Trial, folder: Path, time_limit_s: float) -> dict[str, Any]:
    """Drives it and leaves the run in `folder`. A worker that dies on the way leaves nothing there."""
    attempt = folder.with_name(f".{folder.name}.{uuid.uuid4().hex[:8]}")
    command = [sys.executable, "-m", "rover.cli.main", "run", str(mission), "--seed", str(trial.seed)]
    began, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    process = subprocess.Popen(
        [*command, "--out", str(attempt), "--quiet", "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )
    try:
        out, err = process.communicate(timeout=time_limit_s)
        code: int | None = process.returncode
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        out, err = process.communicate()
        code = None
    except BaseException:
        os.killpg(process.pid, signal.SIGKILL)
        raise
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if attempt.exists():
        shutil.rmtree(folder, ignore_errors=True)
        attempt.rename(folder)
    row = figures(trial, code, out, err)
    row["wall_s"] = round(time.monotonic() - began, 2)
    row["processor_s"] = round(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 2)
    return row


def figures(trial: Trial, code: int | None, out: bytes, err: bytes) -> dict[str, Any]:
    """The row of a mission. `code`: its exit code, None when it had to be killed."""
    row: dict[str, Any] = {"index": trial.index, "seed": trial.seed, "exit_code": code, **trial.values}
    try:
        summary = json.loads(out)
        localization, mines = summary["localization"], summary["mines"] or {}
    except (ValueError, KeyError, TypeError):
        last = (err.decode(errors="replace").strip().splitlines() or ["said nothing"])[-1]
        # What the mission file or the field refuses is an end with a reason; what nobody planned for is not.
        status = TIMED_OUT if code is None else "refused" if code in (2, 3, 4) else CRASHED
        return {**row, "status": status, "reason": last}
    return {
        **row,
        "status": summary["status"],
        "reason": summary["reason"],
        **{name: summary[name] for name in COUNTS},
        **{name: summary[name] for name in ("unseen_ground_m2", "coverage", "duration_s", "distance_m")},
        **{name: summary[name] for name in ("surveyed_m2", "area_m2", "fresh_wheel_m2", "min_clearance_m")},
        **{name: localization[name] for name in ("ate_rmse_m", "relative_rmse_m", "inside_95")},
        "home": None if summary["home"] is None else summary["home"]["reached"],
        **{f"mines_{name}": mines.get(name) for name in ("with_contrast", "with_contrast_found", "false")},
    }
