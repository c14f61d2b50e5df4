"""The rows of a campaign on disk: a line a mission as it ends, so that nothing is lost; Parquet when all have ended."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow
import pyarrow.parquet
from rover.errors import BadInput
from rover.record.strict_json import document
from rover.whole_file import write_whole

from rover_hil.campaign.file import Campaign

ROWS = "rows.jsonl"
PARQUET = "missions.parquet"
IDENTITY = "campaign.json"


def identity(campaign: Campaign) -> dict[str, str]:
    """What the rows belong to."""
    digest = hashlib.sha256(campaign.path.read_bytes() + b"\0" + campaign.mission.read_bytes()).hexdigest()
    return {"name": campaign.name, "sha256": digest}


def begin(out: Path, campaign: Campaign, go_on: bool) -> list[dict[str, Any]]:
    """The rows that are there already. Raises BadInput for a folder that holds something else."""
    marker = out / IDENTITY
    mine = document(identity(campaign)).encode()
    if out.exists() and not out.is_dir():
        raise BadInput(f"--out {out}: cannot be made a folder: a file is there")
    if out.is_dir() and any(out.iterdir()):
        if not go_on:
            raise BadInput(f"--out {out}: is not empty; name a new folder, or go on with it by --continue")
        if not marker.is_file() or marker.read_bytes() != mine:
            raise BadInput(f"--out {out}: holds no rows of this campaign file; name another folder")
        return read_rows(out)
    try:
        (out / "missions").mkdir(parents=True, exist_ok=True)
        (out / "runs").mkdir(exist_ok=True)
        write_whole(marker, mine)
    except OSError as error:
        raise BadInput(f"--out {out}: cannot be made a folder: {error.strerror or error}") from error
    return []


def read_rows(out: Path) -> list[dict[str, Any]]:
    """Every whole line; the last may have been cut off. Raises BadInput."""
    file = out / ROWS
    if not (out / IDENTITY).is_file():
        raise BadInput(f"{out}: not the folder of a campaign")
    rows = {}
    for line in file.read_text(encoding="utf-8").splitlines() if file.is_file() else ():
        try:
            row = json.loads(line)
            rows[int(row["index"])] = row
        except (ValueError, KeyError, TypeError):
            continue
    return [rows[index] for index in sorted(rows)]


def append(out: Path, row: dict[str, Any]) -> None:
    """One row more."""
    with (out / ROWS).open("a", encoding="utf-8") as file:
        file.write(json.dumps(row) + "\n")


def write_parquet(out: Path, rows: Sequence[dict[str, Any]]) -> None:
    """A row a mission, by index. What was drawn as words in some missions and numbers in others is kept as words."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    columns = {name: [row.get(name) for row in rows] for name in names}
    try:
        table = pyarrow.table(columns)
    except pyarrow.ArrowInvalid:
        table = pyarrow.table({name: _alike(values) for name, values in columns.items()})
    part = out / f".{PARQUET}.part"
    pyarrow.parquet.write_table(table, part)
    part.replace(out / PARQUET)


def _alike(values: list[Any]) -> list[Any]:
    kinds = {type(value) for value in values if value is not None}
    return values if len(kinds) <= 1 or kinds <= {int, float} else [None if v is None else str(v) for v in values]
