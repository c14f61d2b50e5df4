"""The process of `rover run`, on a rig that is there already in the place of the one that it would start.

python -m rover_hil.scenario.companion_process PORT CONTROL MISSION [OPTION…]

Everything else is what the installed command does. A killed one leaves nothing behind.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

from rover.cli.main import invoke

from rover_hil.client import process

# Announces the rig as its server would, and stays for as long as the companion lives.
STAND_IN = """
import os, sys, time
parent = os.getppid()
print(sys.argv[1], flush=True)
while os.getppid() == parent:
    time.sleep(0.2)
"""

WORDS = {0: "Done", 3: "PreflightFailed", 4: "NoPath", 5: "Aborted", 6: "SafetyStop", 7: "LinkLost", 8: "Partial"}
# Seconds for a mission that is over to write its report.
END_TIMEOUT_S = 60.0


class CompanionProcess:
    """`rover run` from outside. `word` and `reason` say how it fares, see `observation.py`."""

    def __init__(self, mission: Path, rig: str, seed: int, out: Path, port: str, control: Path) -> None:
        self.word = "Starting"
        self.reason = ""
        self.armed_at: float | None = None
        self.out = out
        command = [sys.executable, "-m", __name__, port, str(control), str(mission)]
        command += ["--rig", rig, "--seed", str(seed), "--out", str(out), "--force", "--quiet"]
        self._log = out / "companion.log"
        with self._log.open("wb") as said:
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True
            )

    @property
    def driving(self) -> bool:
        """False once it has ended."""
        return self.word in ("Starting", "Driving")

    @property
    def ended(self) -> bool:
        """Whether the process is gone."""
        return self._process.poll() is not None

    @property
    def last_line(self) -> str:
        """What it has said last."""
        lines = self._log.read_text(encoding="utf-8", errors="replace").split("\n")
        return next((line for line in reversed(lines) if line.strip()), "it said nothing")

    def signal(self, number: int) -> None:
        """SIGSTOP, SIGCONT, SIGINT, SIGKILL: what a terminal, a scheduler or a lack of memory would do."""
        self._process.send_signal(number)

    def kill(self) -> None:
        """Gone, without a word."""
        self._process.kill()
        self._process.wait()
        self.word = "Killed"

    def wait(self) -> None:
        """Until it has written its report; `word` and `reason` are then those of its end."""
        try:
            code = self._process.wait(END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self.kill()
            self.word, self.reason = "Failed", f"it had not ended {END_TIMEOUT_S:g} s after its mission"
            return
        self.word = WORDS.get(code, "Failed")
        try:
            self.reason = str(json.loads((self.out / "summary.json").read_text())["reason"])
        except (OSError, ValueError, KeyError):
            self.reason = self.last_line

    def close(self) -> None:
        """Ends it by force if need be."""
        if not self.ended:
            self._process.kill()
            self._process.wait()


def main(arguments: list[str]) -> int:
    """Returns the exit code of `rover run`."""
    port, control, *options = arguments
    announcement = json.dumps({"port": port, "control": control})
    process.rig_command = lambda *_: [sys.executable, "-c", STAND_IN, announcement]
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ.setdefault("NO_COLOR", "1")
    return invoke(["run", *options])


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
