"""`rover` as a process that is watched: how it ended, what it said, how long it took, how much memory."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

ROVER = Path(sys.executable).with_name("rover")
# More is taken from nobody else on this computer, whatever a command does.
ADDRESS_SPACE = 16 * 2**30


@dataclass(frozen=True)
class Ended:
    """code: exit code, negative for a signal, None when it had to be ended; peak memory in MB.

    seconds: on the wall, without those that it stood in the queue for a processor.
    """

    command: tuple[str, ...]
    code: int | None
    out: str
    err: str
    seconds: float
    memory_mb: float


@dataclass
class Running:
    """One command on its way. Call `end` once."""

    command: tuple[str, ...]
    process: subprocess.Popen[bytes]
    began: float
    folder: tempfile.TemporaryDirectory[str]
    _ended: Ended | None = field(default=None, repr=False)

    @property
    def runs(self) -> bool:
        return self._ended is None and not _gone(self.process.pid)

    def signal(self, number: int) -> None:
        """Nothing for a process that is gone."""
        if self.runs:
            os.kill(self.process.pid, number)

    def end(self, limit_s: float) -> Ended:
        """Waits for so long of its own time at most, and ends it by force then."""
        begin = time.monotonic()
        queued = waited = _queued(self.process.pid)
        late, memory_mb = False, 0.0
        while (found := os.wait4(self.process.pid, os.WNOHANG))[0] == 0:
            waited, memory_mb = _queued(self.process.pid), max(memory_mb, _most_memory_mb(self.process.pid))
            if time.monotonic() - begin - (waited - queued) > limit_s and not late:
                late = True
                os.kill(self.process.pid, signal.SIGKILL)
            time.sleep(0.01)
        _, status, _ = found
        seconds = time.monotonic() - self.began - waited
        self.process.returncode = code = os.waitstatus_to_exitcode(status)
        out, err = (Path(self.folder.name, name).read_bytes().decode("utf-8", "replace") for name in ("out", "err"))
        self.folder.cleanup()
        self._ended = Ended(self.command, None if late else code, out, err, seconds, memory_mb)
        return self._ended


def start(*arguments: object, cwd: Path | None = None, before: Callable[[], None] | None = None) -> Running:
    """`rover` with these arguments; `before` runs in the new process."""

    def prepare() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
        if before is not None:
            before()

    command = tuple(str(each) for each in (ROVER, *arguments))
    folder = tempfile.TemporaryDirectory(prefix="chaos-said-")
    with open(Path(folder.name, "out"), "wb") as out, open(Path(folder.name, "err"), "wb") as err:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=err,
            cwd=cwd,
            preexec_fn=prepare,
            start_new_session=True,
        )
    return Running(command, process, time.monotonic(), folder)


def run(*arguments: object, limit_s: float, cwd: Path | None = None) -> Ended:
    """To its end."""
    return start(*arguments, cwd=cwd).end(limit_s)


def _queued(pid: int) -> float:
    """Seconds that a process was ready to run and had no processor: how busy others keep the computer."""
    try:
        return int(Path(f"/proc/{pid}/schedstat").read_text().split()[1]) * 1e-9
    except (OSError, ValueError, IndexError):
        return 0.0


def _gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


def _most_memory_mb(pid: int) -> float:
    """The most that the program has held so far; what rusage tells has the memory of who started it in it."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0.0
    lines = (line.split() for line in status.splitlines() if line.startswith("VmHWM:"))
    return next((int(words[1]) / 1024 for words in lines), 0.0)
