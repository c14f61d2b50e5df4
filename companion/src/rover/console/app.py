"""The console's application: what may be asked for, behind the guard.

What blocks (files, the mission's socket) is done in threads; the loop that serves everybody never waits for a disk.
"""

from __future__ import annotations

from pathlib import Path

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.routing import Mount, WebSocketRoute
from starlette.staticfiles import StaticFiles

from rover.console.desk import Desk
from rover.console.guard import Guard, hosts_of
from rover.console.live import live
from rover.console.routes_missions import mission_routes
from rover.console.routes_people import people_routes
from rover.console.routes_runs import run_routes

BUILT = Path(__file__).resolve().parent / "built"


def application(desk: Desk, listen: str) -> Starlette:
    """`listen`: the host that the server listens on."""
    hosts, any_address = hosts_of(listen)
    guard = Middleware(Guard, hosts=hosts, any_address=any_address, known=desk.sessions.known)
    page = StaticFiles(directory=BUILT, html=True)
    routes = [
        *people_routes(),
        *mission_routes(),
        *run_routes(),
        WebSocketRoute("/api/live", live),
        Mount("/", page),
    ]
    app = Starlette(routes=routes, middleware=[guard])
    app.state.desk = desk
    return app
