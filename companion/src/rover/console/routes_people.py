"""Pairing, leaving, and the operator's seat."""

from __future__ import annotations

import time
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from rover.console.answer import answered
from rover.console.desk import Desk, body
from rover.console.guard import COOKIE, address_of
from rover.console.sessions import IDLE_S, Refused


async def pair(desk: Desk, request: Request) -> Response:
    """A code becomes a token, which no script of the page can read."""
    content = await body(request)
    code, name = content.get("code", ""), content.get("name", "")
    address = address_of(request.scope)
    try:
        if not isinstance(code, str) or not isinstance(name, str):
            raise Refused("code and name are expected", 400)
        session = desk.sessions.pair(code, name, address, time.monotonic())
    except Refused as refused:
        desk.note(request, None, "pair", name if isinstance(name, str) else "", str(refused))
        raise
    desk.note(request, session, "pair")
    answer = JSONResponse({"ok": True, **desk.sessions.document(session)})
    secure = request.url.scheme == "https"
    answer.set_cookie(COOKIE, session.token, int(IDLE_S), path="/", secure=secure, httponly=True, samesite="strict")
    return answer


async def me(desk: Desk, request: Request) -> dict[str, Any]:
    """Who this browser is; nobody for one that is not paired."""
    try:
        return desk.sessions.document(desk.session(request))
    except Refused:
        return {"me": None}


async def leave(desk: Desk, request: Request) -> Response:
    """The token is worth nothing any more."""
    session = desk.session(request)
    desk.sessions.leave(session)
    desk.note(request, session, "leave")
    desk.people_changed()
    answer = JSONResponse({"ok": True})
    answer.delete_cookie(COOKIE, path="/")
    return answer


async def seat(desk: Desk, request: Request) -> dict[str, Any]:
    """take: sit down, or ask who sits there; give: hand it over to the session of a number, or leave it free."""
    session = desk.session(request)
    content = await body(request)
    wish, heir = content.get("wish"), content.get("to")
    if wish == "take":
        done = desk.sessions.take_seat(session, time.monotonic())
        desk.note(request, session, "take the seat", answer="ok" if done else "asked for it")
    elif wish == "give" and (heir is None or isinstance(heir, int)):
        now = desk.sessions.hand_over(session, heir)
        desk.note(request, session, "hand over", "nobody" if now is None else now.name)
    else:
        raise Refused("wish is take or give", 400)
    desk.people_changed()
    return desk.sessions.document(session)


def people_routes() -> list[Route]:
    """All of them."""
    return [
        Route("/api/pair", answered(pair), methods=["POST"]),
        Route("/api/me", answered(me)),
        Route("/api/leave", answered(leave), methods=["POST"]),
        Route("/api/seat", answered(seat), methods=["POST"]),
    ]
