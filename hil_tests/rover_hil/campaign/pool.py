"""Trials on Ray, as many at once as there are cores; what a worker leaves undone is done again."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rover.errors import BadInput, PreflightFailed

from rover_hil.campaign.file import Campaign
from rover_hil.campaign.trial import Trial, drive

# A worker may be killed at any moment; a trial that takes five of them with it is a failure of the trial.
MAX_RETRIES = 5
# Tasks handed over per core: enough that none waits, few enough that a cluster's head holds little.
IN_FLIGHT = 2


def run_all(
    campaign: Campaign,
    trials: Sequence[Trial],
    out: Path,
    address: str | None,
    workers: int | None,
    on_row: Callable[[dict[str, Any]], None],
) -> None:
    """Each trial's row goes to `on_row` as it comes. On a cluster `out` has to be a folder that all nodes share.

    Raises BadInput when there is no cluster, PreflightFailed without Ray.
    """
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        import ray
        from ray.exceptions import RayError
    except ImportError:
        raise PreflightFailed("a campaign takes the extra [campaign]: run 'make setup-campaign'") from None
    try:
        if address is None:
            ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False, logging_level=logging.ERROR)
        else:
            ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR)
    except (ConnectionError, ValueError, RuntimeError) as error:
        why = (str(error).splitlines() or ["no answer"])[0]
        raise BadInput(f"--address {address}: no cluster answers there: {why}") from None

    remote = ray.remote(num_cpus=1, max_retries=MAX_RETRIES)(drive)
    waiting = list(reversed(trials))
    running: dict[Any, Trial] = {}
    try:
        resources = ray.cluster_resources()  # type: ignore[no-untyped-call]
        cores = max(1, int(resources.get("CPU", 1)))
        while waiting or running:
            while waiting and len(running) < IN_FLIGHT * cores:
                trial = waiting.pop()
                mission = mission_file(out, trial)
                task = remote.remote(mission, trial, run_folder(out, trial), campaign.time_limit_s)
                running[task] = trial
            done, _ = ray.wait(list(running), num_returns=1)
            for task in done:
                trial = running.pop(task)
                try:
                    on_row(ray.get(task))
                except RayError as error:
                    reason = (str(error).splitlines() or ["no reason"])[0]
                    row = {"index": trial.index, "seed": trial.seed, "exit_code": None, **trial.values}
                    on_row({**row, "status": "worker lost", "reason": reason})
    finally:
        ray.shutdown()


def mission_file(out: Path, trial: Trial) -> Path:
    """Where the mission of a trial lies."""
    return (out / "missions" / f"{trial.index:06d}.toml").resolve()


def run_folder(out: Path, trial: Trial) -> Path:
    """Where its run lies, if it is kept."""
    return (out / "runs" / f"{trial.index:06d}").resolve()
