"""A port has one owner: a lock by the device behind its name, with a line about who holds it.

The lock is the system's (flock): it is gone with the process that held it, however that ended. What a file beside it
says is for people and for `rover status`, which asks the owner instead of the port.
"""

from __future__ import annotations

import fcntl
import json
import os
import re
import stat
import sys
import tempfile
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from pathlib import Path

from rover.errors import PreflightFailed
from rover.link.port import CanPort, parse_port

FOLDER = "rover-ports"
MAX_NOTE_BYTES = 4096
MAX_SHOWN = 120
# Buses within one process, for tests and rigs: nobody else can come in.
UNCLAIMED = ("virtual",)
# Major numbers of /dev/pts/N on Linux.
PSEUDO_TERMINALS = range(136, 144)


@dataclass(frozen=True)
class Holder:
    """Who drives what is behind a port. since: local time; run: the mission's folder, "" for anything else."""

    pid: int
    command: str
    since: str
    run: str = ""

    def __str__(self) -> str:
        return f"{self.command} (pid {self.pid}, since {self.since})"


class PortHeld(PreflightFailed):
    """Somebody else drives the rover on this port."""

    def __init__(self, port: str, holder: Holder | None) -> None:
        who = str(holder) if holder is not None else "another program"
        super().__init__(f"the port {port} is in use by {who}: end that first")
        self.holder = holder


class Claim:
    """Holds the device behind a port until it is released. Raises PortHeld."""

    def __init__(self, port: str) -> None:
        self._file: int | None = None
        identity = device_of(port)
        if identity is None:
            return
        try:
            self._file = _open(folder() / f"{identity}.lock")
        except OSError:  # nowhere to put a lock: the port itself is still opened exclusively
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            holder = _read(self._file)
            os.close(self._file)
            self._file = None
            raise PortHeld(port, holder) from None
        self._holder = Holder(os.getpid(), _command(), datetime.now().strftime("%Y-%m-%d %H:%M:%S"))
        self._write()
        _held[identity] = self
        self._identity = identity

    def of_run(self, run: Path) -> None:
        """The mission in that folder can be asked about the rover."""
        if self._file is not None:
            self._holder = replace(self._holder, run=str(run.resolve()))
            self._write()

    def release(self) -> None:
        """May be called twice."""
        if self._file is not None:
            _held.pop(self._identity, None)
            with suppress(OSError):
                os.ftruncate(self._file, 0)
                if re.fullmatch(r"serial-\d+-\d+-\d+", self._identity):  # a pseudo-terminal that will not come back
                    os.unlink(folder() / f"{self._identity}.lock")
            os.close(self._file)
            self._file = None

    def _write(self) -> None:
        assert self._file is not None
        with suppress(OSError):
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, json.dumps(asdict(self._holder)).encode(), 0)


_held: dict[str, Claim] = {}
"""This process's claims, by the device's identity."""


def mission_on(port: str, run: Path) -> None:
    """Who asks about a port of this process is told of the mission in that folder."""
    identity = device_of(port)
    claim = _held.get(identity) if identity is not None else None
    if claim is not None:
        claim.of_run(run)


def device_of(port: str) -> str | None:
    """What names the device behind a port, whatever link leads to it; None for what cannot be claimed."""
    parsed = parse_port(port)
    if isinstance(parsed, CanPort):
        if parsed.interface in UNCLAIMED:
            return None
        behind = device_of(parsed.channel)  # an slcan adapter is a serial port
        return behind or f"can-{re.sub(r'[^A-Za-z0-9]+', '-', f'{parsed.interface}-{parsed.channel}')}"
    try:
        found = os.stat(parsed)
    except (OSError, ValueError):
        return None
    if not stat.S_ISCHR(found.st_mode):
        return None
    name = f"serial-{os.major(found.st_rdev)}-{os.minor(found.st_rdev)}"
    # The number of a pseudo-terminal is given to another one as soon as it is gone: its birth tells them apart.
    return f"{name}-{found.st_ctime_ns}" if os.major(found.st_rdev) in PSEUDO_TERMINALS else name


def folder() -> Path:
    """Where the locks lie: the same for every user of the machine."""
    return Path(tempfile.gettempdir()) / FOLDER


def _open(path: Path) -> int:
    """The lock's file, made when it is not there; a link is not followed."""
    if not path.parent.is_dir():
        with suppress(FileExistsError):
            path.parent.mkdir()
            path.parent.chmod(0o1777)
    try:
        return os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
    except FileNotFoundError:
        made = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)
        with suppress(OSError):
            os.fchmod(made, 0o666)
        return made


def _read(file: int) -> Holder | None:
    try:
        content = json.loads(os.pread(file, MAX_NOTE_BYTES, 0))
        texts = {key: _printable(str(content[key])) for key in ("command", "since")}
        return Holder(int(content["pid"]), texts["command"], texts["since"], str(content["run"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _printable(text: str) -> str:
    return "".join(letter if letter.isprintable() else "?" for letter in text)[:MAX_SHOWN]


def _command() -> str:
    return " ".join([Path(sys.argv[0]).name, *sys.argv[1:]])[:MAX_SHOWN]
