"""The runs in a folder: what each is, how it stands, and which of its files may be fetched."""

from __future__ import annotations

import json
import re
from contextlib import suppress
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from rover.console.sessions import Refused
from rover.mission.ear import SOCKET, connect
from rover.mission.former_run import can_go_on_from
from rover.mission.run_folder import RUN_FILES

LOG = "mission.mcap"
SUMMARY = "summary.json"
NAME = re.compile(r"[^\W_][\w.-]{0,127}")
MAX_RUNS = 500
# What nobody needs to fetch.
KEPT = frozenset({SOCKET, "rig.json", "rig.log", "truth_seen.npz"})
MEDIA = {
    ".html": "text/html; charset=utf-8",
    ".json": "application/json",
    ".jsonl": "application/x-ndjson",
    ".geojson": "application/geo+json",
    ".kml": "application/vnd.google-earth.kml+xml",
    ".csv": "text/csv; charset=utf-8",
    ".pdf": "application/pdf",
    ".png": "image/png",
    ".yaml": "application/yaml",
    ".tum": "text/plain; charset=utf-8",
}


def run_folder(runs: Path, name: str) -> Path:
    """The folder of a run. Raises Refused for any other, however it is spelt."""
    folder = runs / name
    if not NAME.fullmatch(name) or folder.is_symlink() or not folder.is_dir() or not _is_run(folder):
        raise Refused("there is no such run", 404)
    return folder


def run_file(runs: Path, name: str, file: str) -> Path:
    """A file that a run has left for people. Raises Refused for any other."""
    path = run_folder(runs, name) / file
    if file not in RUN_FILES or file in KEPT or path.is_symlink() or not path.is_file():
        raise Refused("there is no such file", 404)
    return path


def list_folders(runs: Path) -> list[Path]:
    """Folders of runs, the newest first."""
    if not runs.is_dir():
        return []
    folders = [each for each in runs.iterdir() if NAME.fullmatch(each.name) and not each.is_symlink() and _is_run(each)]
    return sorted(folders, key=lambda each: each.stat().st_mtime, reverse=True)[:MAX_RUNS]


def list_runs(runs: Path) -> list[dict[str, Any]]:
    """What the list shows of them."""
    return [run_document(each) for each in list_folders(runs)]


def run_document(folder: Path) -> dict[str, Any]:
    """What the list shows of one run."""
    summary = read_summary(folder)
    began = summary.get("started_utc") or _utc((folder / LOG).stat().st_mtime if (folder / LOG).exists() else 0.0)
    state = "over" if summary else "running" if is_running(folder) else "interrupted"
    files = [name for name in RUN_FILES if name not in KEPT and (folder / name).is_file()]
    return {
        "name": folder.name,
        "state": state,
        "utc": began,
        "mission": summary.get("mission", ""),
        "site": summary.get("site") or {},
        "status": summary.get("status", ""),
        "reason": summary.get("reason", ""),
        "duration_s": summary.get("duration_s"),
        "coverage": summary.get("coverage"),
        "indications": len(summary.get("detections", [])),
        "simulated": summary.get("rig") in ("sitl", "emulator"),
        "can_go_on": state != "running" and summary.get("status") != "done" and can_go_on_from(folder),
        "files": files,
    }


def read_summary(folder: Path) -> dict[str, Any]:
    """summary.json, or nothing where it is not there or damaged."""
    with suppress(OSError, ValueError):
        read = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        if isinstance(read, dict):
            return read
    return {}


def is_running(folder: Path) -> bool:
    """True when a mission listens there."""
    try:
        connect(folder).close()
    except OSError:
        return False
    return True


def media_type(name: str) -> str:
    """What a browser is told a file is."""
    return MEDIA.get(Path(name).suffix, "application/octet-stream")


def _is_run(folder: Path) -> bool:
    return any((folder / name).exists() for name in (LOG, SUMMARY, SOCKET))


def _utc(stamp: float) -> str:
    return datetime.fromtimestamp(stamp, timezone.utc).isoformat(timespec="seconds").replace("+00:00", "Z")
