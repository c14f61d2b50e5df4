"""docs/reference/planning.md shows what its program prints: the stages and figures of each algorithm, seed 0."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]


def test_the_program_prints_what_the_page_shows() -> None:
    page = (REPOSITORY / "docs/reference/planning.md").read_text(encoding="utf-8")
    shown = re.search(r"```python\n(.*?)```\n\nprints\n\n```text\n(.*?)```", page, re.DOTALL)
    assert shown is not None
    line = [sys.executable, "-c", shown[1]]
    ran = subprocess.run(line, cwd=REPOSITORY, capture_output=True, text=True, timeout=60.0, check=False)
    assert ran.stderr == ""
    assert ran.stdout == shown[2]
