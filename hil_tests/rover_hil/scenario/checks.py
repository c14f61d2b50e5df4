"""The keys of `[[expect]]`, `[[never]]` and `[end]` that say what must hold, each as a condition."""

from __future__ import annotations

from rover.errors import BadInput
from rover.toml_table import Table

from rover_hil.scenario.condition import parse_condition
from rover_hil.scenario.language import Check
from rover_hil.scenario.observation import WORDS, known_counter

# Slower than one count of an encoder in 30 ms.
STILL = "speed < 0.004 and turn_rate < 0.04"

ABOVE_AND_BELOW = {
    "speed_below": "speed < {}",
    "speed_above": "speed > {}",
    "collisions": "collisions == {}",
    "bumper_contacts": "bumper_contacts == {}",
    "keepout_violations": "keepout_violations == {}",
    "mines_driven_over": "mines_driven_over == {}",
    "mines_with_contrast_found": "mines_with_contrast_found == {}",
    "false_indications": "false_indications == {}",
    "unseen_below_m2": "unseen_m2 < {}",
    "clearance_above_m": "clearance_m > {}",
    "moved_more_than_m": "travelled_m > {}",
    "turned_more_than_deg": "turned_deg > {}",
    "cause_detail": "cause_detail == {}",
    "rejected_at_least": "rejected >= {}",
}


FAULT_CHECKS = {"fault": "fault.{}", "no_fault": "not fault.{}", "counted": "count.{} > 0"}


def check_keys(moved: bool) -> tuple[str, ...]:
    """All keys that `read_checks` knows."""
    keys = (*WORDS, *ABOVE_AND_BELOW, *FAULT_CHECKS, "stopped", "powered", "condition")
    return (*keys, "moved_less_than_m") if moved else keys


def read_checks(table: Table, moved: bool) -> tuple[Check, ...]:
    """All checks of a table. `moved`: distances since the reference event have a meaning there. Raises BadInput."""
    checks: list[Check] = []
    for key, words in WORDS.items():
        if table.has(key):
            checks.append(_check(f"{key} == {table.choice(key, words)}"))
    for key, template in ABOVE_AND_BELOW.items():
        if table.has(key):
            checks.append(_check(template.format(f"{table.number(key, 0.0, 1e6):g}")))
    checks += _faults(table)
    if table.has("stopped"):
        still = _check(STILL if table.flag("stopped") else f"not ({STILL})")
        checks.append(Check("stopped" if table.flag("stopped") else "moving", still.condition))
    if table.has("powered"):
        checks.append(_check("powered" if table.flag("powered") else "not powered"))
    if table.has("condition"):
        try:
            checks.append(_check(table.text("condition")))
        except BadInput as error:
            raise table.error("condition", str(error)) from error
    if moved and table.has("moved_less_than_m"):
        most = table.number("moved_less_than_m", 0.0001, 1e3)
        checks.append(Check(f"moved less than {most:g} m", lambda seen: True, most))
    return tuple(checks)


def _faults(table: Table) -> list[Check]:
    checks = []
    for key, template in FAULT_CHECKS.items():
        if table.has(key):
            name = table.text(key)
            if not known_counter(name):
                raise table.error(key, f"{name!r}: the protocol has no fault of that name")
            checks.append(_check(template.format(name)))
    return checks


def _check(text: str) -> Check:
    return Check(text, parse_condition(text))
