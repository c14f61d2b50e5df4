"""Every answer in one form: what was asked for with ok, or one line that says why not."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response

from rover.console.desk import Desk
from rover.console.sessions import Refused
from rover.errors import RoverError

Handler = Callable[[Desk, Request], Awaitable[dict[str, Any] | Response]]


def answered(handler: Handler) -> Callable[[Request], Awaitable[Response]]:
    """The endpoint of a handler."""

    async def endpoint(request: Request) -> Response:
        desk: Desk = request.app.state.desk
        try:
            told = await handler(desk, request)
        except Refused as refused:
            return JSONResponse({"ok": False, "error": str(refused)}, refused.status)
        except RoverError as error:
            return JSONResponse({"ok": False, "error": str(error)}, 400)
        except ClientDisconnect:
            return Response(status_code=400)
        return told if isinstance(told, Response) else JSONResponse({"ok": True, **told})

    return endpoint
