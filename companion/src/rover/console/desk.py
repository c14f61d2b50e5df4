"""All that one console knows while it runs."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from starlette.requests import HTTPConnection

from rover.console.audit import Audit
from rover.console.feed import Feed, Viewer
from rover.console.guard import address_of, token_of
from rover.console.missions import Missions
from rover.console.replay import Replays
from rover.console.runs import NAME, run_folder
from rover.console.sessions import Codes, Refused, Session, Sessions
from rover.console.start import Started

# What the console keeps beside the runs: its own folder, which is no run, and the missions drawn on the page.
OWN = ".console"
MISSIONS = "missions"


class Desk:
    """Of one console over one folder of runs."""

    def __init__(self, runs: Path, codes: Codes) -> None:
        self.runs = runs
        own = runs / OWN
        own.mkdir(parents=True, exist_ok=True)
        self.sessions = Sessions(codes)
        self.audit = Audit(own)
        self.missions = Missions(runs / MISSIONS, runs)
        self.started = Started(runs, own / "logs")
        self.replays = Replays()
        self._feeds: dict[str, Feed] = {}
        self._viewers: dict[Viewer, Session] = {}

    def session(self, asked: HTTPConnection) -> Session:
        """Whose request this is. Raises Refused for one without a session."""
        return self.sessions.find(token_of(asked.scope), time.monotonic())

    def note(self, asked: HTTPConnection, who: Session | None, what: str, about: str = "", answer: str = "ok") -> None:
        """A line in the audit log."""
        self.audit.note(who, address_of(asked.scope), what, about, answer)

    def folder(self, name: str) -> Path:
        """The folder of a run, or of one that is beginning. Raises Refused."""
        if NAME.fullmatch(name) and self.started.document(name) is not None:
            return self.runs / name
        return run_folder(self.runs, name)

    def feed(self, name: str) -> Feed:
        """What is told of a run on its way. Raises Refused."""
        if name not in self._feeds:
            folder = self.folder(name)
            self._feeds = {each: feed for each, feed in self._feeds.items() if feed.viewers}
            self._feeds[name] = Feed(folder)
        return self._feeds[name]

    def places(self, name: str) -> set[int]:
        """Numbers of the places that a mission on its way suspects; none for one that nobody looks at."""
        return self._feeds[name].places if name in self._feeds else set()

    def enter(self, viewer: Viewer, session: Session) -> None:
        """A browser is connected."""
        if len(self._viewers) >= 100:
            raise Refused("too many viewers", 503)
        self._viewers[viewer] = session
        session.connections += 1
        self.people_changed()

    def leave(self, viewer: Viewer) -> None:
        """A browser is gone."""
        session = self._viewers.pop(viewer, None)
        if session is not None:
            session.connections -= 1
            session.seen = time.monotonic()
            self.people_changed()

    def people_changed(self) -> None:
        """Everybody is shown who is there and who operates."""
        for viewer, session in self._viewers.items():
            viewer.put("people", json.dumps(self.sessions.document(session)))


async def body(request: Any) -> dict[str, Any]:
    """A request's JSON object. Raises Refused."""
    try:
        content = json.loads(await request.body())
    except (ValueError, RecursionError):
        raise Refused("JSON is expected", 400) from None
    if not isinstance(content, dict):
        raise Refused("a JSON object is expected", 400)
    return content
