"""From one running mission to all who look at it: a single connection there, and for each viewer what is newest.

Nobody is waited for. A viewer that is slow is sent fewer moments, one that takes nothing for SEND_WITHIN_S is dropped;
neither costs the mission or the other viewers anything.
"""

from __future__ import annotations

import asyncio
import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from rover.console.sessions import Refused
from rover.mission.ear import WATCH, connect

MAX_VIEWERS = 60
MAX_LINE_BYTES = 32 * 2**20
SEND_WITHIN_S = 10.0
# Seconds between two looks for a mission that has not begun to listen, or no longer does.
AGAIN_S = 0.5
KIND = '{"kind": "'


class Viewer:
    """What one browser has not been sent yet, by kind."""

    def __init__(self) -> None:
        self.pending: dict[str, str] = {}
        self._changed = asyncio.Event()

    def put(self, kind: str, text: str) -> None:
        """Takes the place of what was waiting under that kind."""
        self.pending[kind] = text
        self._changed.set()

    async def send(self, socket: WebSocket) -> None:
        """Until the connection ends, or is too slow."""
        while True:
            await self._changed.wait()
            self._changed.clear()
            waiting, self.pending = self.pending, {}
            for text in waiting.values():
                try:
                    await asyncio.wait_for(socket.send_text(text), SEND_WITHIN_S)
                except (asyncio.TimeoutError, WebSocketDisconnect, RuntimeError, OSError):
                    return


class Feed:
    """One run's. `state`: the last message of that kind, as it came."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._viewers: set[Viewer] = set()
        self._newest: dict[str, str] = {}
        self._task: asyncio.Task[None] | None = None

    @property
    def viewers(self) -> int:
        """How many look at it."""
        return len(self._viewers)

    @property
    def places(self) -> set[int]:
        """Numbers of the places that the mission suspects now."""
        with suppress(KeyError, ValueError, TypeError):
            return {int(place["id"]) for place in json.loads(self._newest["state"])["places"]}
        return set()

    def join(self, viewer: Viewer) -> None:
        """It is sent what is known, and all that comes. Raises Refused when there is no room."""
        if len(self._viewers) >= MAX_VIEWERS:
            raise Refused("too many viewers", 503)
        self._viewers.add(viewer)
        for kind, text in self._newest.items():
            viewer.put(kind, text)
        if self._task is None:
            self._task = asyncio.get_running_loop().create_task(self._follow())

    def leave(self, viewer: Viewer) -> None:
        """Without viewers nothing is asked of the mission."""
        self._viewers.discard(viewer)
        if not self._viewers and self._task is not None:
            self._task.cancel()
            self._task = None

    def tell(self, kind: str, content: dict[str, Any]) -> None:
        """Something of the console's own to all of them."""
        self._spread(kind, json.dumps({"kind": kind, **content}))

    def _spread(self, kind: str, text: str) -> None:
        self._newest[kind] = text
        for viewer in self._viewers:
            viewer.put(kind, text)

    async def _follow(self) -> None:
        while True:
            try:
                client = connect(self._folder)
            except OSError:
                self.tell("link", {"running": False})
                await asyncio.sleep(AGAIN_S)
                continue
            client.setblocking(False)
            self.tell("link", {"running": True})
            with suppress(OSError, ValueError, asyncio.IncompleteReadError):
                await self._read(*await asyncio.open_unix_connection(sock=client, limit=MAX_LINE_BYTES))
            await asyncio.sleep(AGAIN_S)

    async def _read(self, lines: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            writer.write(json.dumps({"op": WATCH}).encode() + b"\n")
            while line := await lines.readline():
                text = line.decode().rstrip("\n")
                if text.startswith(KIND):
                    self._spread(text[len(KIND) : text.index('"', len(KIND))], text)
        finally:
            writer.close()


def is_open(socket: WebSocket) -> bool:
    """True while something may be sent."""
    return socket.application_state is WebSocketState.CONNECTED
