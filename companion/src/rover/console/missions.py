"""Mission files that the page makes: read by the reader of `rover run`, and kept beside the runs."""

from __future__ import annotations

import re
import sys
from datetime import date
from datetime import time as clock
from pathlib import Path
from typing import Any

import tomli_w

from rover.console.estimate import estimate
from rover.console.sessions import Refused
from rover.errors import BadInput, NoPath
from rover.mission.config import SECTIONS, SHIPPED, Mission, from_document
from rover.record.strict_json import finite
from rover.whole_file import write_whole

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

NAME = re.compile(r"[^\W_][\w-]{0,63}")
MAX_BYTES = 256 * 1024
MAX_FILES = 500
# Keys whose values are names of files: those beside the mission file, and no others.
FILES = (("rover", "vehicle"), ("rover", "camera"), ("detector", "model"))


class Missions:
    """Those of one folder, and the ones that ship."""

    def __init__(self, folder: Path, runs: Path) -> None:
        """`runs`: whose pace tells what a mission will take."""
        self.folder = folder
        self._runs = runs

    def names(self) -> dict[str, Any]:
        """What there is to choose from, and the sections and keys that a mission file may have."""
        own = sorted(path.stem for path in self.folder.glob("*.toml") if NAME.fullmatch(path.stem))
        return {
            "own": own[:MAX_FILES],
            "shipped": sorted(path.stem for path in SHIPPED.glob("*.toml")),
            "sections": SECTIONS,
        }

    def path(self, name: str) -> Path:
        """The file of a mission. Raises Refused where there is none."""
        if NAME.fullmatch(name):
            for path in (self.folder / f"{name}.toml", SHIPPED / f"{name}.toml"):
                if path.is_file() and not path.is_symlink():
                    return path
        raise Refused("there is no such mission", 404)

    def read(self, name: str) -> dict[str, Any]:
        """A mission as `check` tells of it."""
        return self.check(self.path(name).read_text(encoding="utf-8"), name)

    def check(self, text: str, name: str) -> dict[str, Any]:
        """What `rover run` would make of a mission file: `problem` is its one line, "" when all is well."""
        told: dict[str, Any] = {"name": name, "text": text, "document": {}, "problem": "", "mission": None}
        try:
            content = document(text)
            told["document"] = _plain(content)
            mission = self._mission(content, name)
            told["mission"], told["estimate"] = summary(mission), estimate(mission, self._runs)
        except (BadInput, NoPath) as error:
            told["problem"] = str(error).replace(f"{self.folder}/", "")
        return told

    def save(self, text: str, name: str) -> dict[str, Any]:
        """Writes it where `rover run` can read it. Raises Refused for what it would not."""
        if not NAME.fullmatch(name):
            raise Refused("a mission's name has letters, digits and - only, 64 at most", 400)
        told = self.check(text, name)
        if told["problem"]:
            raise Refused(told["problem"], 400)
        self.folder.mkdir(parents=True, exist_ok=True)
        if len(list(self.folder.glob("*.toml"))) >= MAX_FILES and not (self.folder / f"{name}.toml").exists():
            raise Refused("too many missions; delete some", 400)
        write_whole(self.folder / f"{name}.toml", text.encode("utf-8"))
        return told

    def _mission(self, content: dict[str, Any], name: str) -> Mission:
        for section, key in FILES:
            table = content.get(section)
            value = table.get(key) if isinstance(table, dict) else None
            if isinstance(value, str) and (Path(value).name != value or (self.folder / value).is_symlink()):
                raise BadInput(f"[{section}] {key}: {value!r} must lie beside the mission file, in {self.folder.name}")
        return from_document(content, self.folder / f"{name if NAME.fullmatch(name) else 'mission'}.toml")


def document(text: str) -> dict[str, Any]:
    """The content of a mission file. Raises BadInput."""
    if len(text.encode("utf-8", "replace")) > MAX_BYTES:
        raise BadInput(f"the file is larger than {MAX_BYTES // 1024} kB")
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadInput(f"not TOML: {error}") from None


def _plain(value: Any) -> Any:
    """The same as JSON has it: dates and times as text, numbers that are none as null."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_plain(entry) for entry in value]
    if isinstance(value, date | clock):
        return value.isoformat()
    return finite(value)


def rendered(content: dict[str, Any]) -> str:
    """A mission file of that content. Raises Refused for what TOML cannot hold."""
    try:
        return tomli_w.dumps(content)
    except (TypeError, ValueError, RecursionError) as error:
        raise Refused(f"this is no mission: {error}", 400) from None


def summary(mission: Mission) -> dict[str, Any]:
    """What the page needs of a mission to draw and to reckon with it."""
    area, launch, vehicle = mission.area, mission.launch, mission.rover.vehicle
    origin = mission.site.origin
    return {
        "name": mission.name,
        "area": {
            "width_m": area.width,
            "height_m": area.height,
            "polygon": [list(point) for point in area.polygon],
            "exclude": [[list(point) for point in hole] for hole in area.exclude],
            "obstacles": [list(disc) for disc in area.obstacles],
        },
        "goals": [list(goal) for goal in mission.goals],
        "launch": {"x": launch.pose.x, "y": launch.pose.y, "heading": launch.pose.heading},
        "origin": None if origin is None else [origin.latitude, origin.longitude],
        "bearing_deg": None if origin is None else origin.bearing_deg,
        "robot_radius_m": vehicle.radius,
        "max_duration_s": mission.max_duration_s,
        "required_coverage": mission.required_coverage,
    }
