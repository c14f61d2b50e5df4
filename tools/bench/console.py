"""What the console costs a mission, and how fast its emergency stop is: `python -m tools.bench console`.

Cost: a mission on a rig in real time (`rover hil serve`), once with nobody looking and once with `--viewers` browsers'
worth of connections. Counted are the mission's own processor time by second and the cycles that began late. Stops: a
browser clicks, as often as `--stops`, each time on a new mission while its rover turns; measured in the page from the
click to the mission's answer, which it gives once the word has gone to the firmware.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from rover.errors import BadInput
from rover_hil.testing.served import ServedRig
from websockets.asyncio.client import connect
from websockets.typing import Origin

from companion.tests.console.browser_page import Console, browser
from companion.tests.console.served import Served, serving

if TYPE_CHECKING:
    import psutil

MISSION = Path(__file__).resolve().parents[2] / "hil_tests" / "tests" / "missions" / "small.toml"
PATIENCE_S = 120.0


def main(arguments: list[str]) -> int:
    """Prints both; exit code 0."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench console", description=__doc__)
    parser.add_argument("--viewers", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=30.0, help="of the mission that is measured")
    parser.add_argument("--stops", type=int, default=50)
    options = parser.parse_args(arguments)
    if options.seconds > 0.0:
        print(
            "| viewers | processor time of the mission, ms/s | cycles | began late | longest, ms | messages a viewer |"
        )
        print("|---|---|---|---|---|---|")
        for viewers in (0, options.viewers):
            print(cost(viewers, options.seconds), flush=True)
    if options.stops:
        times = sorted(stops(options.stops))
        print(
            f"emergency stop, click to firmware, {len(times)} clicks: median {median(times):.0f} ms, "
            f"95 % {times[int(0.95 * len(times))]:.0f} ms, worst {times[-1]:.0f} ms"
        )
    return 0


def cost(viewers: int, seconds: float) -> str:
    """One mission in real time with so many who look on; a row of the table."""
    with tempfile.TemporaryDirectory() as name, serving(Path(name) / "runs") as served:
        cookie = seated(served)
        rig = ServedRig(str(MISSION), "--seed", "503", "--free-run")
        try:
            content = {"mission": "small", "rig": "device", "port": rig.port, "camera_source": rig.camera_source}
            run, process = started(served, cookie, content)
            began = process.cpu_times()
            told = asyncio.run(look_on(served, cookie, run, viewers, seconds))
            spent = process.cpu_times()
            served.ask("POST", f"/api/runs/{run}/tell", {"op": "stop"}, cookie)
            summary = ended(served, run)
        finally:
            rig.stop()
    busy = (spent.user + spent.system - began.user - began.system) / seconds
    kept = summary["real_time"]
    return (
        f"| {viewers} | {1e3 * busy:.0f} | {kept['cycles']} | {kept['overruns']} | {kept['longest_cycle_ms']:.0f} "
        f"| {min(told, default=0)} to {max(told, default=0)} |"
    )


def stops(count: int) -> list[float]:
    """Milliseconds of each."""
    times = []
    with tempfile.TemporaryDirectory() as name, serving(Path(name)) as served, browser() as opened:
        cookie = seated(served)
        console = Console(opened, served.url)
        console.pair(served.codes["pairing_code"], "bench")
        for number in range(count):
            run, _ = started(served, cookie, {"mission": "small", "rig": "sitl", "seed": 500 + number})
            console.headline("look")
            console.page.evaluate("delete document.querySelector('.emergency').dataset.ms")
            console.button("Emergency stop").click()
            console.page.locator(".emergency[data-ms]").wait_for()
            times.append(float(console.page.locator(".emergency").get_attribute("data-ms") or "nan"))
            ended(served, run)
            console.headline("Ended")
    return times


def seated(served: Served) -> str:
    """The cookie of an operator, whose console has the mission."""
    cookie = served.pair()
    for path, content in (
        ("/api/seat", {"wish": "take"}),
        ("/api/missions", {"name": "small", "text": MISSION.read_text()}),
    ):
        status, told, _ = served.ask("POST", path, content, cookie)
        if status != 200:
            raise BadInput(str(told))
    return cookie


def started(served: Served, cookie: str, content: dict[str, Any]) -> tuple[str, psutil.Process]:
    """A mission that drives, and its process."""
    import psutil  # of the development packages alone: the help works without

    status, told, _ = served.ask("POST", "/api/runs", content, cookie)
    if status != 200:
        raise BadInput(str(told))
    deadline = time.monotonic() + PATIENCE_S
    while not (served.runs / told["run"] / "tell.sock").exists():
        if time.monotonic() > deadline:
            raise BadInput(str(served.ask("GET", f"/api/runs/{told['run']}", cookie=cookie)[1]["process"]))
        time.sleep(0.05)
    children = psutil.Process(served.process.pid).children()
    return told["run"], next(each for each in children if told["run"] in " ".join(each.cmdline()))


async def look_on(served: Served, cookie: str, run: str, viewers: int, seconds: float) -> list[int]:
    """How many messages each was sent."""

    async def one() -> int:
        told = 0
        address = f"ws://{served.host}/api/live?run={run}"
        async with connect(
            address, additional_headers={"cookie": cookie}, origin=Origin(f"http://{served.host}"), max_size=None
        ) as live:
            deadline = time.monotonic() + seconds
            while (left := deadline - time.monotonic()) > 0.0:
                try:
                    await asyncio.wait_for(live.recv(), left)
                except asyncio.TimeoutError:
                    break
                told += 1
        return told

    if not viewers:
        await asyncio.sleep(seconds)
        return []
    return list(await asyncio.gather(*(one() for _ in range(viewers))))


def ended(served: Served, run: str) -> dict[str, Any]:
    """The summary of a mission that is ending."""
    path, deadline = served.runs / run / "summary.json", time.monotonic() + PATIENCE_S
    while not path.exists():
        if time.monotonic() > deadline:
            raise BadInput(f"{run} does not end")
        time.sleep(0.1)
    summary: dict[str, Any] = json.loads(path.read_text())
    return summary


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
