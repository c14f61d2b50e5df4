"""Makes the tests the same on every run, keeps what they write out of the tree, and counts those of each rig."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import hypothesis
import hypothesis.configuration
import pytest

# Property tests draw the same examples every time; what Hypothesis stores goes where `make clean` removes it.
hypothesis.configuration.set_hypothesis_home_dir(Path(__file__).parent / ".venv" / "hypothesis")
hypothesis.settings.register_profile("reproducible", derandomize=True, deadline=None)
hypothesis.settings.load_profile("reproducible")

_ran: Counter[str] = Counter()


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Writes the rig into the test's report, which is all that comes back from a worker process (`-n`)."""
    marker = item.get_closest_marker("rig")
    item.user_properties.append(("rig", str(marker.args[0]) if marker else "no rig"))


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if report.when == "call" and not report.skipped:
        _ran[str(dict(report.user_properties)["rig"])] += 1


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    counts = ", ".join(f"{name}: {_ran[name]}" for name in sorted(_ran))
    terminalreporter.write_line(f"tests by rig: {counts or 'none ran'}")
