"""The page of faults says what the table does."""

from __future__ import annotations

from pathlib import Path

import pytest
from rover.mission.fault_table import CHECKS, FIRMWARE, AtStart, Driving, Row

PAGE = (Path(__file__).parents[1] / "reference" / "faults.md").read_text(encoding="utf-8")
START = {
    AtStart.TAKEN_BACK: "sets off: arming ends it",
    AtStart.GOES: "sets off",
    AtStart.REFUSED: "refuses",
}
DRIVING = {
    Driving.NOTE: "told",
    Driving.SLOW: "half the speed while it lasts",
    Driving.WAIT: "stops and waits, {wait:g} s at most",
    Driving.HOME: "drives home",
    Driving.END: "ends where it stands, exit code {code}",
    Driving.REARM: "stopped by the firmware, armed again",
}
ROWS = {fault.value: row for fault, row in FIRMWARE.items()} | {check.value: row for check, row in CHECKS.items()}


@pytest.mark.parametrize("name", ROWS)
def test_every_row_stands_on_the_page(name: str) -> None:
    row: Row = ROWS[name]
    does = DRIVING[row.driving].format(wait=row.wait_s, code=row.status.exit_code)
    assert f"| {name} | {START[row.start]} | {does} | {row.line} |" in PAGE.splitlines()
