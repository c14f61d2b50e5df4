"""A whole campaign: what is missing is driven, then all of it is told."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rover.record.strict_json import document as json_document
from rover.whole_file import write_whole

from rover_hil.campaign import rates, report, store
from rover_hil.campaign.file import Campaign
from rover_hil.campaign.pool import mission_file, run_all, run_folder
from rover_hil.campaign.trial import Trial, draw, mission_text


def conduct(
    campaign: Campaign,
    out: Path,
    go_on: bool = False,
    address: str | None = None,
    workers: int | None = None,
    against: Path | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> dict[str, Any]:
    """The JSON of `rover campaign`; rows, report and kept runs are in `out`. Raises BadInput, PreflightFailed."""
    former = None if against is None else store.read_rows(against)
    rows = {row["index"]: row for row in store.begin(out, campaign, go_on)}
    trials = draw(campaign)
    missing = [trial for trial in trials if trial.index not in rows]
    for trial in missing:
        write_whole(mission_file(out, trial), mission_text(campaign, trial))
    on_progress(len(rows), len(trials))

    def take(row: dict[str, Any]) -> None:
        store.append(out, row)
        rows[row["index"]] = row
        on_progress(len(rows), len(trials))

    if missing:
        run_all(campaign, missing, out, address, workers, take)
    ordered = [rows[index] for index in sorted(rows)]
    store.write_parquet(out, ordered)
    told = tell(campaign, trials, ordered, former, out)
    _clear(campaign, trials, ordered, told, out)
    write_whole(out / "report.json", json_document(told).encode())
    write_whole(out / "report.html", report.document(told).encode())
    return told


def tell(
    campaign: Campaign, trials: list[Trial], rows: list[dict[str, Any]], former: list[dict[str, Any]] | None, out: Path
) -> dict[str, Any]:
    """The document of a campaign's rows; `former`: those of another build."""
    seeds = {trial.index: trial.seed for trial in trials}
    keys = [each.key for each in campaign.draw]
    return {
        "name": campaign.name,
        "missions": len(rows),
        "failed": sum(map(rates.failed, rows)),
        "rates": rates.rates(rows),
        "strata": rates.by_stratum(rows, campaign.strata),
        "sensitivity": rates.sensitivity(rows, keys),
        "against": None if former is None else rates.against(rows, former),
        "worst": [
            {
                "index": row["index"],
                "status": row["status"],
                "reason": row["reason"],
                "coverage": row.get("coverage"),
                "repeat": f"rover run {out}/missions/{row['index']:06d}.toml --seed {seeds[row['index']]}",
            }
            for row in rates.worst(rows, campaign.worst_share)
        ],
        "processor_s": round(sum(row.get("processor_s") or 0.0 for row in rows), 1),
        "out": str(out),
    }


def _clear(
    campaign: Campaign, trials: list[Trial], rows: list[dict[str, Any]], told: dict[str, Any], out: Path
) -> None:
    """Runs that no rule keeps go, and what a lost worker left of one."""
    if "all" not in campaign.keep:
        kept = {row["index"] for row in rows if "failed" in campaign.keep and rates.failed(row)}
        if "worst" in campaign.keep:
            kept |= {entry["index"] for entry in told["worst"]}
        for trial in trials:
            if trial.index not in kept:
                shutil.rmtree(run_folder(out, trial), ignore_errors=True)
    for left in (out / "runs").glob(".*"):
        shutil.rmtree(left, ignore_errors=True)
