"""The connection of a browser: everything that is to be seen goes out over it, and one word comes in, emergency.

The emergency stop has this way because it is open already when it is needed; whatever else is asked, and however busy
the console is with that, it does not wait behind it.
"""

from __future__ import annotations

import asyncio
import json
import time
from contextlib import suppress

from starlette.websockets import WebSocket, WebSocketDisconnect

from rover.console.desk import Desk
from rover.console.emergency import cut_motors
from rover.console.feed import Viewer
from rover.console.guard import address_of
from rover.console.limits import Limit
from rover.console.sessions import Refused, Session

MAX_WORD = 200
# Words a second from one connection, and at once; a client that sends more is closed.
RATE, BURST = 10.0, 60.0


async def live(socket: WebSocket) -> None:
    """One connection, from pairing on."""
    desk: Desk = socket.app.state.desk
    viewer = Viewer()
    run = socket.query_params.get("run", "")
    try:
        session = desk.session(socket)
        feed = desk.feed(run) if run else None
        desk.enter(viewer, session)
    except Refused as refused:
        await socket.close(1008, str(refused))
        return
    try:
        if feed is not None:
            feed.join(viewer)
        await socket.accept()
        sending = asyncio.create_task(viewer.send(socket))
        hearing = asyncio.create_task(_hear(desk, socket, session, viewer, run))
        _, open_ones = await asyncio.wait((sending, hearing), return_when=asyncio.FIRST_COMPLETED)
        for task in open_ones:
            task.cancel()
        with suppress(RuntimeError, WebSocketDisconnect, OSError):
            await asyncio.wait_for(socket.close(1001), 1.0)
    except Refused as refused:
        await socket.close(1013, str(refused))
    finally:
        if feed is not None:
            feed.leave(viewer)
        desk.leave(viewer)


async def _hear(desk: Desk, socket: WebSocket, session: Session, viewer: Viewer, run: str) -> None:
    """Until the browser goes, or says more than a person can."""
    limit = Limit(RATE, BURST)
    while True:
        try:
            text = await socket.receive_text()
        except (WebSocketDisconnect, KeyError, RuntimeError):
            return
        if len(text) > MAX_WORD or not limit.allows("", time.monotonic()):
            return
        try:
            word = json.loads(text)
        except ValueError:
            return
        if isinstance(word, dict) and word.get("op") == "emergency" and run:
            answer = await cut_motors(desk, session, address_of(socket.scope), run)
            viewer.put("stopped", json.dumps({"kind": "stopped", "ref": str(word.get("ref", ""))[:40], **answer}))
