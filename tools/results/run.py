"""Runs a block's command."""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path

from tools.results.page import Block

ROOT = Path(__file__).resolve().parents[2]

# One thread, no colours and one width: the same text on every machine.
ENVIRONMENT = {"NO_COLOR": "1", "COLUMNS": "120", "LC_ALL": "C.UTF-8", "OMP_NUM_THREADS": "1"}


class CommandFailed(RuntimeError):
    """A command ended with another exit code than 0, or printed nothing."""


def lacks_data(block: Block) -> bool:
    """True for a command on real data where there is none."""
    return "ROVER_DATA" in block.command and not os.environ.get("ROVER_DATA")


def output(block: Block) -> str:
    """What the command prints on stdout. Raises CommandFailed."""
    with tempfile.TemporaryDirectory() as scratch:
        done = subprocess.run(
            ["bash", "-o", "pipefail", "-c", block.command],
            cwd=ROOT,
            env=os.environ | ENVIRONMENT | {"SCRATCH": scratch},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
    if done.returncode != 0 or not done.stdout.strip():
        last = (done.stderr.strip().splitlines() or ["nothing was printed"])[-1]
        raise CommandFailed(f"`{block.command}` ended with exit code {done.returncode}: {last}")
    return done.stdout
