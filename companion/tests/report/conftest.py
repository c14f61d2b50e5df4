"""Puts this folder on the path and shares the sample run between the tests of the report."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from rover.report.result import RunResult

sys.path.insert(0, str(Path(__file__).parent))

from sample_run import make_result


@pytest.fixture(scope="session")
def result() -> RunResult:
    return make_result()
