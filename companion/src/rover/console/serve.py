"""Serves the console until it is told to end."""

from __future__ import annotations

import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import uvicorn

from rover.console.app import application
from rover.console.desk import Desk
from rover.console.sessions import Codes
from rover.errors import BadInput

# What comes in over a browser's connection is a word; a request's head is short as well.
MAX_MESSAGE_BYTES = 4096
MAX_QUEUED = 8
MAX_CONNECTIONS = 400


def parse_listen(text: str) -> tuple[str, int]:
    """HOST:PORT, [HOST]:PORT or :PORT. Raises BadInput."""
    host, colon, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not colon or not port.isdecimal() or int(port) > 65_535:
        raise BadInput(f"--listen {text}: HOST:PORT is expected, as 127.0.0.1:8080 or 0.0.0.0:8080")
    return host or "127.0.0.1", int(port)


def serve(listen: str, runs: Path, on_ready: Callable[[dict[str, Any]], None]) -> None:
    """Until a signal. `on_ready` is given what the first line of stdout says. Raises BadInput."""
    host, port = parse_listen(listen)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((host, port))
        listener.listen(128)
    except OSError as error:
        listener.close()
        raise BadInput(f"--listen {listen}: {error.strerror or error}") from error
    codes = Codes()
    try:
        desk = Desk(runs, codes)
    except OSError as error:
        listener.close()
        raise BadInput(f"--runs {runs}: {error.strerror or error}") from error
    config = uvicorn.Config(
        application(desk, host),
        http="h11",
        ws="websockets-sansio",
        ws_max_size=MAX_MESSAGE_BYTES,
        ws_max_queue=MAX_QUEUED,
        ws_per_message_deflate=False,
        ws_ping_interval=10.0,
        ws_ping_timeout=20.0,
        h11_max_incomplete_event_size=16_384,
        limit_concurrency=MAX_CONNECTIONS,
        timeout_keep_alive=30,
        timeout_graceful_shutdown=2,
        log_level="warning",
        access_log=False,
        proxy_headers=False,
        server_header=False,
        date_header=False,
    )
    shown = "127.0.0.1" if host in ("0.0.0.0", "") else f"[{host}]" if ":" in host else host
    on_ready(
        {
            "url": f"http://{shown}:{listener.getsockname()[1]}/",
            "pairing_code": codes.operator,
            "viewer_code": codes.viewer,
        }
    )
    uvicorn.Server(config).run(sockets=[listener])
