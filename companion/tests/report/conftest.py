"""Shares the sample run between the tests of the report."""

from __future__ import annotations

import pytest
from rover.report.result import RunResult

from companion.tests.report.sample_run import make_result


@pytest.fixture(scope="session")
def result() -> RunResult:
    return make_result()
