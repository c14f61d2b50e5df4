"""Makes the tests the same on every run, keeps what they write out of the tree, and counts those of each rig."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator
from pathlib import Path

import hypothesis
import hypothesis.configuration
import pytest

# Property tests draw the same examples every time; what Hypothesis stores goes where `make clean` removes it.
hypothesis.configuration.set_hypothesis_home_dir(Path(__file__).parent / ".venv" / "hypothesis")
hypothesis.settings.register_profile("reproducible", derandomize=True, deadline=None)
hypothesis.settings.load_profile("reproducible")

_ran: Counter[str] = Counter()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if report.when == "call" and not report.skipped:
        marker = item.get_closest_marker("rig")
        _ran[str(marker.args[0]) if marker else "no rig"] += 1
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    counts = ", ".join(f"{name}: {_ran[name]}" for name in sorted(_ran))
    terminalreporter.write_line(f"tests by rig: {counts or 'none ran'}")
