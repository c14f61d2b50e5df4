"""The console as its operator uses it: a survey planned, driven, judged and looked at again, on the simulated rig.

The pictures of docs/guide/console.md come from here: ROVER_SCREENSHOTS=docs/figures makes them anew.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_binary

from companion.tests.console.browser_page import Console, browser
from companion.tests.console.served import Served, serving

pytestmark = [pytest.mark.rig("sitl"), pytest.mark.slow]

ROVER = str(Path(sys.executable).with_name("rover"))
OUTLINE = ((0.0, 0.0), (1.6, 0.0), (1.6, 1.8), (0.0, 1.8))
FIELD = """
[field]
soil = "loam"
rocks = 1
grass = 0
surface_mines = 1
buried_mine_depths_cm = [1.0]
"""
SCREENSHOTS = os.environ.get("ROVER_SCREENSHOTS")


@pytest.fixture(scope="module")
def opened() -> Iterator[Browser]:
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    with browser() as found:
        yield found


def picture(console: Console, name: str) -> None:
    """For the guide, when somebody asks for it."""
    if SCREENSHOTS:
        console.page.evaluate("window.scrollTo(0, 0)")
        console.page.wait_for_timeout(600)
        console.page.screenshot(path=str(Path(SCREENSHOTS) / f"console-{name}.png"))


def plan(console: Console) -> None:
    console.go("Plan")
    console.says("rover run accepts this mission").wait_for()
    at = console.places_on_map()
    console.button("Area").click()
    for x, y in OUTLINE:
        console.page.mouse.click(*at(x, y))
        console.page.wait_for_timeout(300)  # two clicks in quick succession are a double click
    console.page.mouse.dblclick(*at(*OUTLINE[-1]))
    console.button("Area").click()
    text = console.field("Mission file (TOML)")
    drawn = console.until(text.input_value, lambda told: "polygon" in told)
    text.fill(drawn + FIELD)
    console.says("rover run accepts this mission").wait_for()
    console.field("Time limit, s").fill("400")
    console.field("Time limit, s").press("Tab")
    console.until(text.input_value, lambda told: "400" in told and "[field]" in told)
    console.says("rover run accepts this mission").wait_for()
    console.field("File name").fill("drawn")
    console.button("Save").click()
    console.says("Saved drawn").wait_for()
    picture(console, "plan")


def start(console: Console) -> None:
    console.go("Drive")
    console.field("Mission to drive").select_option("drawn")
    console.field("Seed").fill("2")
    console.button("Start").click()


def tell(served: Served, run: str, word: str) -> dict[str, object]:
    done = subprocess.run([ROVER, "tell", str(served.runs / run), word, "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told: dict[str, object] = json.loads(done.stdout)
    return told


def run_of(served: Served) -> str:
    [run] = [each.name for each in served.runs.iterdir() if (each / "mission.mcap").exists()]
    return run


def test_a_survey_is_planned_driven_judged_and_looked_at_again(opened: Browser, tmp_path: Path) -> None:
    with serving(tmp_path) as served:
        ada = Console(opened, served.url)
        assert ada.faults() == []
        ada.pair(served.codes["pairing_code"], "Ada")
        ada.button("Operate").click()
        ada.says("You are the operator").wait_for()
        plan(ada)
        assert ada.faults() == []
        kept = (tmp_path / "missions" / "drawn.toml").read_text()

        start(ada)
        ada.headline("drive")
        ada.button("Pause").click()
        ada.headline("paused: paused by the operator")
        run = run_of(served)
        assert ada.faults() == []
        picture(ada, "drive")
        phone = Console(opened, served.url, 390, 780)
        phone.pair(served.codes["viewer_code"], "Eve")
        phone.headline("paused")
        assert phone.page.get_by_role("button", name="Pause").is_disabled()
        assert not phone.page.get_by_role("button", name="Emergency stop").is_visible()
        assert phone.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        assert phone.faults() == []
        picture(phone, "phone")
        complaints = [*ada.complaints, *phone.complaints]
        ada.context.close()
        phone.context.close()
        served.process.kill()

    # Neither a browser nor a console that is gone has changed anything.
    assert tell(served, run, "state")["state"] == "paused"

    with serving(tmp_path) as served:
        bob = Console(opened, served.url)
        bob.pair(served.codes["pairing_code"], "Bob")
        bob.button("Operate").click()
        bob.headline("paused")
        bob.go("Judge")
        bob.page.locator(".indications button").first.click()
        bob.field("Note").fill("<b>a can</b>")
        bob.button("Reject: looks like something else").click()
        bob.says("rejected, stays keep-out").wait_for()
        bob.page.locator(".views figure").first.wait_for()
        assert bob.faults() == []
        picture(bob, "judge")
        [said] = [json.loads(line) for line in (tmp_path / run / "judgements.jsonl").read_text().splitlines()]
        assert (said["author"], said["verdict"], said["note"]) == ("Bob", "rejected", "<b>a can</b>")

        bob.go("Drive")
        goal = bob.until(lambda: bob.field("Goal to skip").input_value(), lambda told: told != "")
        bob.button("Skip").click()
        bob.until(lambda: bob.field("Goal to skip").inner_text(), lambda told: goal not in told)
        bob.button("Go on").click()
        bob.headline("drive", "decide", "inspect", "look")
        bob.button("Come home").click()
        bob.headline("Ended: aborted, called home by the operator")
        summary = json.loads((tmp_path / run / "summary.json").read_text())
        # What a person rejects stays in the record, and its ground is not driven on.
        assert said["place"] in [found["id"] for found in summary["detections"]]
        assert summary["keepout_violations"] == 0
        assert summary["home"]["reached"]

        bob.go("Review")
        bob.says("Ended: aborted, called home by the operator").wait_for()
        slider = bob.field("Time in the mission")
        bob.until(lambda: float(slider.get_attribute("max") or 0.0), lambda end: end > 5.0)
        slider.fill("5")
        assert bob.faults() == []
        picture(bob, "review")
        with bob.context.expect_page() as shown:
            bob.page.get_by_role("link", name="Report", exact=True).click()
        report = shown.value
        report.wait_for_load_state()
        assert "called home by the operator" in report.inner_text("body")
        with bob.page.expect_download() as fetched:
            bob.page.get_by_role("link", name="detections.local.json").click()
        features = json.loads(Path(fetched.value.path()).read_text())["features"]
        places = {f["properties"]["id"]: f["geometry"]["coordinates"] for f in features
                  if f["properties"]["kind"] == "indication"}  # fmt: skip
        assert places == {
            found["id"]: pytest.approx([found["x"], found["y"]], abs=0.01) for found in summary["detections"]
        }
        assert "polygon = [" in kept
        words = [line["what"] for line in served.audit()]
        assert {"save", "start", "pause", "go", "home", f"skip {goal}"} <= set(words)
        # The report may run no script, and says so; nothing else went wrong in any of the pages.
        assert [line for line in [*complaints, *bob.complaints] if "report.html" not in line] == []


def test_the_emergency_stop_is_in_reach_on_every_page_and_latches_the_firmware(opened: Browser, tmp_path: Path) -> None:
    with serving(tmp_path) as served:
        console = Console(opened, served.url)
        console.pair(served.codes["pairing_code"], "Ada")
        console.button("Operate").click()
        for page in ("Plan", "Judge", "Review", "Drive"):
            console.go(page)
            assert console.button("Emergency stop").is_visible()
        console.field("Mission to drive").select_option("demo")
        console.button("Start").click()
        console.headline("look")
        # Without the seat, from another page, by the keyboard.
        console.button("Leave the seat").click()
        console.go("Review")
        console.page.keyboard.press("Shift+Escape")
        console.page.locator(".emergency[data-ms]").wait_for()
        milliseconds = float(console.page.locator(".emergency").get_attribute("data-ms") or "inf")
        print(f"from the key to the firmware: {milliseconds:.0f} ms")
        console.go("Drive")
        console.headline("Ended: aborted, emergency stop by the operator; the motors are off, the firmware is latched")
        assert console.complaints == []
        # `tools.bench console` measures fifty; a computer that runs other tests beside this one may take its time.
        assert milliseconds < 1000.0
