"""What every request has to pass before anything looks at it: host, origin, size, rate. And what every answer carries.

Pages of other sites reach a server on this computer, too: by a name that they let point here (so the host must be one
of ours), and by what a browser sends along for them (so the origin must be that host).
"""

from __future__ import annotations

import ipaddress
import socket
import time
from collections.abc import Callable, Iterable
from http.cookies import CookieError, SimpleCookie
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rover.console.limits import Limit

COOKIE = "rover_session"
MAX_BODY_BYTES = 2 * 2**20
# Requests a second, and at once, from one session or address.
RATE, BURST = 40.0, 200.0
READING = ("GET", "HEAD")

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
# The report of a run is a page of its own: with its style in it, and without any script or way out.
REPORT_POLICY = "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'"
ANSWERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
}


class TooLarge(Exception):
    """A body of more than MAX_BODY_BYTES."""


class Guard:
    """The outermost layer of the application."""

    def __init__(self, app: ASGIApp, hosts: Iterable[str], any_address: bool, known: Callable[[str], bool]) -> None:
        """`hosts`: names that the server is reached by. `any_address`: by any numerical address, too.

        `known`: whether a token is that of a session; all others share what their address may ask.
        """
        self._app = app
        self._known = known
        self._hosts = frozenset(hosts)
        self._any_address = any_address
        self._limit = Limit(RATE, BURST)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if refusal is not None:
            await _refuse(scope, receive, send, *refusal)
            return
        if scope["type"] == "websocket":
            await self._app(scope, receive, send)
            return
        await self._guarded(scope, receive, send)

    async def _guarded(self, scope: Scope, receive: Receive, send: Send) -> None:
        begun = False
        taken = 0

        async def counted() -> Message:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body", b""))
            if taken > MAX_BODY_BYTES:
                raise TooLarge
            return message

        async def dressed(message: Message) -> None:
            nonlocal begun
            if message["type"] == "http.response.start":
                begun = True
                headers = MutableHeaders(scope=message)
                for name, value in ANSWERS.items():
                    headers[name] = value
                headers.setdefault("content-security-policy", POLICY)
                headers.setdefault("cache-control", "no-store")
            await send(message)

        try:
            await self._app(scope, counted, dressed)
        except TooLarge:
            if not begun:
                await _refuse(scope, receive, send, 413, "the request is too large")

    def _refusal(self, scope: Scope) -> tuple[int, str] | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if not self._is_ours(host):
            return 421, "the console is not known by this name"
        origin = headers.get("origin")
        reading = scope["type"] == "http" and scope["method"] in READING
        if origin is None and not reading:
            return 403, "a request without its origin"
        if origin is not None and urlsplit(origin).netloc.lower() != host.lower():
            return 403, "a request of another site"
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin") and not (
            reading and headers.get("sec-fetch-mode") == "navigate"
        ):
            return 403, "a request of another site"
        length = headers.get("content-length", "0")
        if not length.isdecimal() or int(length) > MAX_BODY_BYTES:
            return 413, "the request is too large"
        token = token_of(scope)
        if not self._limit.allows(token if self._known(token) else address_of(scope), time.monotonic()):
            return 429, "too many requests; slow down"
        return None

    def _is_ours(self, host: str) -> bool:
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in self._hosts:
            return True
        if not self._any_address:
            return False
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return True


def hosts_of(listen: str) -> tuple[frozenset[str], bool]:
    """The names that a server is reached by which listens there, and whether any numerical address is one."""
    names = {"localhost", "127.0.0.1", "::1"}
    everywhere = listen in ("0.0.0.0", "::", "")
    if everywhere:
        own = socket.gethostname().lower()
        names |= {own, f"{own}.local"}
    elif listen:
        names.add(listen.lower())
    return frozenset(names), everywhere


def token_of(scope: Scope) -> str:
    """The session's token in a request's cookie; "" without one."""
    try:
        cookie = SimpleCookie(Headers(scope=scope).get("cookie", "")).get(COOKIE)
    except CookieError:
        return ""
    return "" if cookie is None else cookie.value


def address_of(scope: Scope) -> str:
    """Where a request comes from."""
    client = scope.get("client")
    return str(client[0]) if client else "?"


async def _refuse(scope: Scope, receive: Receive, send: Send, status: int, why: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": why})
        return
    await JSONResponse({"ok": False, "error": why}, status, {**ANSWERS, "connection": "close"})(scope, receive, send)
