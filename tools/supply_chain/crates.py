"""The crates that Cargo.lock files name, as cargo tells them."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import Any

from tools.supply_chain.component import Component

WORKSPACES = (".", "firmware/pico", "firmware/no_panic")
CHECKSUM = re.compile(r'name = "([^"]+)"\nversion = "([^"]+)"\nsource = "[^"]+"\nchecksum = "([0-9a-f]{64})"')


def crates(root: Path) -> set[Component]:
    """Of every workspace below `root`, without our own. Raises RuntimeError with what cargo said when it fails."""
    return {crate for workspace in WORKSPACES for crate in _of_workspace(root / workspace)}


def _of_workspace(folder: Path) -> list[Component]:
    command = ["cargo", "metadata", "--locked", "--format-version", "1"]
    told = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if told.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} in {folder}: {told.stderr.strip()}")
    checksums = {
        (name, version): checksum for name, version, checksum in CHECKSUM.findall((folder / "Cargo.lock").read_text())
    }
    packages: list[dict[str, Any]] = json.loads(told.stdout)["packages"]
    return [_component(package, checksums) for package in packages if package["source"] is not None]


def _component(package: dict[str, Any], checksums: dict[tuple[str, str], str]) -> Component:
    name, version = package["name"], package["version"]
    # Before SPDX expressions crates wrote "MIT/Apache-2.0" for a choice.
    licence = (package["license"] or "").replace("/", " OR ")
    checksum = checksums.get((name, version))
    return Component("cargo", name, version, licence, (checksum,) if checksum else ())
