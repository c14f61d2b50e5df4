"""The console's page in Debian's browser, by what a person sees of it."""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Locator, Page, sync_playwright

BROWSER = shutil.which("chromium")
AXE = Path(__file__).parent / "axe_core" / "node_modules" / "axe-core" / "axe.min.js"
PATIENCE_MS = 300_000.0
SERIOUS = ("serious", "critical")


@contextmanager
def browser() -> Iterator[Browser]:
    """Skips the test where there is none."""
    if BROWSER is None:
        pytest.skip("no chromium: apt-get install chromium")
    with sync_playwright() as playwright:
        # As root a browser has no sandbox.
        sandbox = [] if os.geteuid() else ["--no-sandbox"]
        opened = playwright.chromium.launch(executable_path=BROWSER, args=sandbox)
        yield opened
        opened.close()


class Console:
    """One browser's page. `complaints`: what went wrong in it, scripts and security policy alike."""

    def __init__(self, browser: Browser, url: str, width: int = 1280, height: int = 900) -> None:
        self.context = browser.new_context(viewport={"width": width, "height": height})
        self.page: Page = self.context.new_page()
        self.page.set_default_timeout(PATIENCE_MS)
        self.complaints: list[str] = []
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("console", lambda line: self.complaints.append(line.text) if line.type == "error" else None)
        self.url = url
        self.page.goto(url)

    def pair(self, code: str, name: str) -> None:
        self.page.get_by_label("Pairing code").fill(code)
        self.page.get_by_label("Your name").fill(name)
        self.button("Pair").click()
        self.page.get_by_role("navigation").wait_for()

    def go(self, name: str) -> None:
        self.page.get_by_role("link", name=name, exact=True).click()

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True).locator("visible=true")

    def field(self, name: str) -> Locator:
        control = self.page.locator("input, select, textarea").and_(self.page.get_by_label(name, exact=True))
        return control.locator("visible=true").first

    def says(self, text: str) -> Locator:
        return self.page.get_by_text(text).locator("visible=true").first

    def headline(self, *words: str) -> str:
        """Waits until what the rover is about begins with one of the words."""
        return self.until(lambda: self._headline(), lambda told: told.startswith(words))

    def _headline(self) -> str:
        return self.page.locator(".headline").locator("visible=true").first.inner_text()

    def until(self, ask: Callable[[], Any], good: Callable[[Any], bool]) -> Any:
        deadline = time.monotonic() + PATIENCE_MS / 1e3
        while not good(told := ask()):
            assert time.monotonic() < deadline, told
            self.page.wait_for_timeout(100)
        return told

    def places_on_map(self) -> Callable[[float, float], tuple[float, float]]:
        """From metres of the visible map to pixels of the page, by what the map says of two places."""
        chart = self.page.locator(".map").locator("visible=true").first
        chart.scroll_into_view_if_needed()
        box = chart.bounding_box()
        assert box is not None
        told = []
        for x, y in ((box["x"] + 100, box["y"] + 100), (box["x"] + 300, box["y"] + 300)):
            self.page.mouse.move(x, y)
            text = chart.locator(".ol-mouse-position").inner_text()
            found = re.findall(r"-?\d+\.\d+", text)
            told.append((x, y, float(found[0]), float(found[1])))
        (px, py, x0, y0), (qx, qy, x1, y1) = told
        return lambda x, y: (px + (x - x0) * (qx - px) / (x1 - x0), py + (y - y0) * (qy - py) / (y1 - y0))

    def faults(self) -> list[str]:
        """What axe-core finds serious on the page as it is."""
        if not AXE.is_file():
            pytest.skip(f"no axe-core in {AXE.parent}: run 'make setup-dev' with Node")
        self.page.evaluate(AXE.read_text(encoding="utf-8"))
        found = self.page.evaluate("axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'] })")
        return [
            f"{rule['id']}: {node['html'][:120]}"
            for rule in found["violations"]
            if rule["impact"] in SERIOUS
            for node in rule["nodes"]
        ]
