"""Finds the board to be flashed, brings it into its boot loader, and finds it again when its new firmware runs."""

from __future__ import annotations

import contextlib
import shutil
import subprocess
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

from serial.tools import list_ports

from rover.errors import BadInput, LinkLost, PreflightFailed
from rover.link.baud import DEFAULT_BAUD
from rover.link.boot_drive import MOUNT_PATTERNS, BootDrive, find_drives, read_drive, unmounted
from rover.link.clock import WallClock
from rover.link.opening import open_frames
from rover.link.session import STEP_S, Link

# Vendor and product of the firmware's own USB port (firmware/pico).
USB_IDENTITY = (0x2E8A, 0x000A)

INTO_BOOTLOADER = 0x424F_4F54
# Seconds from the reboot until the drive is mounted; a desktop takes two or three.
DRIVE_TIMEOUT_S = 20.0

PORT_TIMEOUT_S = 20.0
POLL_PERIOD_S = 0.2
NOTHING_FOUND = (
    "no board found. Hold its BOOTSEL button while you plug it in: a drive named RPI-RP2 or RP2350 appears; or name "
    "the port of a running rover with --port; or connect a debug probe and install probe-rs"
)

Say = Callable[[str], None]
Found = TypeVar("Found")


def rover_ports() -> list[str]:
    """Serial ports that a rover's firmware shows over USB."""
    return sorted(port.device for port in list_ports.comports() if (port.vid, port.pid) == USB_IDENTITY)


def choose_drive(folder: Path | None, patterns: Iterable[str] = MOUNT_PATTERNS) -> BootDrive | None:
    """The boot loader's drive that is there now. Raises BadInput when there are several to choose from."""
    if folder is not None:
        return read_drive(folder)
    drives = find_drives(patterns)
    if len(drives) > 1:
        raise BadInput(f"more than one board waits: choose with --drive {' or '.join(str(d.folder) for d in drives)}")
    return drives[0] if drives else None


def choose_port() -> str | None:
    """The running rover, when exactly one is connected by USB. Raises BadInput when there are several."""
    ports = rover_ports()
    if len(ports) > 1:
        raise BadInput(f"more than one rover is connected: choose with --port {' or '.join(ports)}")
    return ports[0] if ports else None


def into_bootloader(port: str, baud: int = DEFAULT_BAUD) -> None:
    """Tells a running rover to start its boot loader. Raises PreflightFailed when it does not answer or is armed."""
    clock = WallClock()
    link = Link(open_frames(port, baud, clock), clock)
    try:
        link.connect()
        assert link.state is not None  # connect waits for it
        if link.state.powered:
            raise PreflightFailed(f"the rover on {port} is {link.state.state.lower()}: it restarts only when disarmed")
        with contextlib.suppress(LinkLost):  # a port that goes away is what was asked for
            for _ in range(3):
                link.wire.send("Reboot", clock.now(), magic=INTO_BOOTLOADER, session=link.session_number)
                clock.advance(clock.now() + STEP_S)
    finally:
        link.close()


def wait_for_drive(folder: Path | None, patterns: Iterable[str], timeout: float = DRIVE_TIMEOUT_S) -> BootDrive:
    """The drive of a board that was told to show it. Raises PreflightFailed that says what to do."""
    drive = _wait(lambda: choose_drive(folder, patterns), timeout)
    if drive is not None:
        return drive
    raise PreflightFailed(
        not_mounted() or f"the board shows no drive within {timeout:g} s: is its USB plugged in here?"
    )


def not_mounted() -> str | None:
    """What to do about a drive that the system has seen and not mounted; None when there is none."""
    device = unmounted()
    if device is None:
        return None
    return f"the board's drive is not mounted: mount {device} somewhere and name the folder with --drive"


def wait_for_port(port: str | None, timeout: float = PORT_TIMEOUT_S) -> str | None:
    """The port on which the new firmware is to be asked; None when none comes up."""
    if port is None:
        return _wait(lambda: next(iter(rover_ports()), None), timeout)
    if port.startswith("can:"):
        return port  # a bus is there whether or not the board is
    return port if _wait(lambda: Path(port).exists() or None, timeout) else None


def has_probe() -> bool:
    """True when probe-rs is installed and a debug probe is connected."""
    if shutil.which("probe-rs") is None:
        return False
    listed = subprocess.run(["probe-rs", "list"], capture_output=True, text=True, timeout=15.0, check=False)
    return listed.returncode == 0 and "[0]" in listed.stdout


def flash_by_probe(firmware: Path, chip: str, say: Say) -> None:
    """Writes a UF2 file through a debug probe. Raises LinkLost with what probe-rs said."""
    for line in (
        ["probe-rs", "download", "--chip", chip, "--binary-format", "uf2", str(firmware)],
        ["probe-rs", "reset", "--chip", chip],
    ):
        say(" ".join(line))
        done = subprocess.run(line, capture_output=True, text=True, timeout=120.0, check=False)
        if done.returncode:
            said = (done.stderr or done.stdout).strip().splitlines()
            raise LinkLost(f"probe-rs: {said[-1] if said else f'exit code {done.returncode}'}")


def _wait(look: Callable[[], Found | None], timeout: float) -> Found | None:
    """What `look` finds, as soon as it finds something; None after `timeout` seconds."""
    deadline = time.monotonic() + timeout
    while (found := look()) is None and time.monotonic() < deadline:
        time.sleep(POLL_PERIOD_S)
    return found
