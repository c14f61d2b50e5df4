"""Results as JUnit XML, as continuous-integration servers read it."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence

from rover_hil.scenario.runner import Result


def junit_xml(results: Sequence[Result]) -> str:
    """One test suite for each rig, one test case for each scenario; times are wall seconds."""
    root = ElementTree.Element("testsuites")
    for rig in dict.fromkeys(result.rig for result in results):
        of_rig = [result for result in results if result.rig == rig]
        suite = ElementTree.SubElement(
            root,
            "testsuite",
            name=f"rover.hil.{rig}",
            tests=str(len(of_rig)),
            failures=str(sum(not result.passed for result in of_rig)),
            errors="0",
            time=f"{sum(result.wall for result in of_rig):.3f}",
        )
        for result in of_rig:
            _case(suite, result)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _case(suite: ElementTree.Element, result: Result) -> None:
    case = ElementTree.SubElement(
        suite,
        "testcase",
        classname=f"rover.hil.{result.rig}",
        name=result.scenario.path.stem,
        time=f"{result.wall:.3f}",
    )
    if not result.passed:
        failure = ElementTree.SubElement(case, "failure", message=result.failures[0], type="expectation")
        failure.text = "\n".join(result.failures)
    events = ElementTree.SubElement(case, "system-out")
    events.text = "\n".join(f"{time:8.3f} {what}" for time, what in result.track.events)
