"""The drive that a board shows while its boot loader runs: where it is mounted, whose it is, and writing to it."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from rover.errors import BadInput, LinkLost
from rover.link.uf2 import RP2040, RP2350_ARM, RP2350_ARM_NON_SECURE, RP2350_RISCV, Uf2

INFO_FILE = "INFO_UF2.TXT"
MOUNT_PATTERNS = ("/media/*", "/media/*/*", "/run/media/*/*", "/Volumes/*", "/mnt", "/mnt/*")
# Names of the drives; on Linux an unmounted one shows under its name.
LABELS = ("RPI-RP2", "RP2350")

LABEL_FOLDER = Path("/dev/disk/by-label")
FAMILIES = {"RPI-RP2": frozenset({RP2040}), "RP2350": frozenset({RP2350_ARM, RP2350_RISCV, RP2350_ARM_NON_SECURE})}
CHUNK_BYTES = 64 * 512
# What is said of a drive that has gone: a board restarts as soon as it has the last block.
GONE = (errno.EIO, errno.ENODEV, errno.ENXIO, errno.ENOENT)


@dataclass(frozen=True)
class BootDrive:
    """A mounted drive, and what INFO_UF2.TXT says of its board."""

    folder: Path
    board_id: str
    model: str
    bootloader: str

    def takes(self, firmware: Uf2) -> bool:
        """True when the firmware is for this board. A board that is not known here is believed to know better."""
        known = FAMILIES.get(self.board_id)
        return known is None or bool(known & firmware.families)


def find_drives(patterns: Iterable[str] = MOUNT_PATTERNS) -> list[BootDrive]:
    """Drives of boot loaders that are mounted now, by folder. A drive that goes away while looked at is none."""
    folders = sorted({folder for pattern in patterns for folder in Path("/").glob(pattern.lstrip("/"))})
    return [drive for folder in folders if (drive := read_drive(folder)) is not None]


def read_drive(folder: Path) -> BootDrive | None:
    """The drive mounted at a folder; None when there is none."""
    try:
        lines = (folder / INFO_FILE).read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return None
    facts = dict(line.split(": ", 1) for line in lines if ": " in line)
    return BootDrive(
        folder, facts.get("Board-ID", "").strip(), facts.get("Model", "").strip(), lines[0] if lines else ""
    )


def unmounted(labels: Path = LABEL_FOLDER) -> Path | None:
    """A boot loader's drive that is plugged in; None when there is none or the system does not tell."""
    return next((labels / label for label in LABELS if (labels / label).exists()), None)


def write(drive: BootDrive, firmware: Uf2, on_progress: Callable[[int, int], None]) -> None:
    """Writes the firmware, each part down to the board. `on_progress(bytes written, bytes in all)`.

    Raises BadInput when the firmware is not for this board, LinkLost when the drive goes before its last block.
    """
    if not drive.takes(firmware):
        raise BadInput(
            f"{firmware.path} is for {firmware.family_names}, and the board on {drive.folder} is "
            f"{drive.model or drive.board_id}: build or choose the firmware for that board"
        )
    total, written = len(firmware.content), 0
    target = drive.folder / "rover.uf2"
    try:
        with target.open("wb", buffering=0) as file:
            while written < total:
                written += file.write(firmware.content[written : written + CHUNK_BYTES])
                os.fsync(file.fileno())
                on_progress(written, total)
    except OSError as error:
        if written < total or error.errno not in GONE:
            why = error.strerror or error
            raise LinkLost(f"{drive.folder}: {written} of {total} bytes written, then: {why}; try again") from error
