"""Counts the tests of each rig, so that the log of a run says what was really driven."""

from __future__ import annotations

from collections import Counter

import pytest

_ran: Counter[str] = Counter()


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]):
    outcome = yield
    report = outcome.get_result()
    if report.when == "call" and not report.skipped:
        marker = item.get_closest_marker("rig")
        _ran[str(marker.args[0]) if marker else "no rig"] += 1


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    counts = ", ".join(f"{name}: {_ran[name]}" for name in sorted(_ran))
    terminalreporter.write_line(f"tests by rig: {counts or 'none ran'}")
