"""The socket of `rover tell` in a run's folder: JSON lines, each answered with one, by the mission's own loop.

A thread takes the lines; nothing is done or answered but in the loop's cycle, so a mission that was told something is
replayed as it was driven. A client that says {"op": "watch"} is told from then on how the mission goes, a message a
line, by `rover.mission.watchers`: nothing of that reaches the loop.
"""

from __future__ import annotations

import json
import os
import queue
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rover.errors import BadInput, LinkLost
from rover.mission.watchers import Watchers

SOCKET = "tell.sock"
MAX_LINE_BYTES = 4096
# Seconds that a client waits: the loop answers within a cycle, unless it is planning or arming.
ANSWER_WITHIN_S = 5.0
MAX_CLIENTS = 8
# Of those so many may watch: there is always room for one who says stop.
MAX_WATCHERS = 4
WATCH = "watch"

Answer = dict[str, Any]


@dataclass
class Request:
    """What somebody asks; `reply` is called once."""

    content: dict[str, Any]
    _answered: threading.Event = field(default_factory=threading.Event)
    _answer: Answer = field(default_factory=dict)

    def reply(self, answer: Answer) -> None:
        """From the mission's loop."""
        self._answer = answer
        self._answered.set()

    def wait(self) -> Answer:
        """In the thread of the client's connection."""
        if self._answered.wait(ANSWER_WITHIN_S):
            return self._answer
        return {"ok": False, "error": f"the mission has not answered within {ANSWER_WITHIN_S:g} s"}


class Ear:
    """Listens while the block runs. `requests`: what was asked and waits for an answer. `watchers`: who looks on."""

    def __init__(self, folder: Path) -> None:
        self.requests: queue.SimpleQueue[Request] = queue.SimpleQueue()
        self.watchers = Watchers(MAX_WATCHERS)
        self.path = folder / SOCKET
        self._room = threading.BoundedSemaphore(MAX_CLIENTS)
        self._listener: socket.socket | None = None

    def __enter__(self) -> Ear:
        with suppress(OSError):  # a file system without sockets: the mission is driven without being told anything
            self.path.unlink(missing_ok=True)
            listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            _in_folder(self.path, listener.bind)
            os.chmod(self.path, 0o600)
            listener.listen(MAX_CLIENTS)
            self._listener = listener
            threading.Thread(target=self._accept, args=(listener,), name="ear", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self.watchers.close()
        if self._listener is not None:
            with suppress(OSError):
                self._listener.shutdown(socket.SHUT_RDWR)
            self._listener.close()
            self.path.unlink(missing_ok=True)

    def waiting(self) -> list[Request]:
        """What has been asked since the last call."""
        asked = []
        with suppress(queue.Empty):
            while True:
                asked.append(self.requests.get_nowait())
        return asked

    def _accept(self, listener: socket.socket) -> None:
        while True:
            try:
                client, _ = listener.accept()
            except OSError:
                return
            if self._room.acquire(blocking=False):
                threading.Thread(target=self._serve, args=(client,), name="ear-client", daemon=True).start()
            else:
                client.close()

    def _serve(self, client: socket.socket) -> None:
        try:
            with client, client.makefile("rb") as lines:
                client.settimeout(60.0)
                while line := lines.readline(MAX_LINE_BYTES):
                    answer = self._answer(line)
                    if answer is None:
                        self.watchers.serve(client)
                        return
                    client.sendall(json.dumps(answer, ensure_ascii=False).encode() + b"\n")
        except (OSError, ValueError):
            return  # the client has gone
        finally:
            self._room.release()

    def _answer(self, line: bytes) -> Answer | None:
        """None for a client that wants to watch."""
        try:
            content = json.loads(line)
        except (ValueError, RecursionError):
            return {"ok": False, "error": "not a line of JSON"}
        if not isinstance(content, dict):
            return {"ok": False, "error": 'a JSON object is expected, as {"op": "pause"}'}
        if content.get("op") == WATCH:
            return None
        request = Request(content)
        self.requests.put(request)
        return request.wait()


def connect(run: Path) -> socket.socket:
    """A connection to the mission in a run's folder. Raises OSError."""
    client = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        client.settimeout(ANSWER_WITHIN_S)
        _in_folder(run / SOCKET, client.connect)
    except BaseException:
        client.close()
        raise
    return client


def ask(run: Path, content: dict[str, Any]) -> Answer:
    """Asks the mission in a run's folder. Raises BadInput when none runs there, LinkLost when it does not answer."""
    if not run.is_dir():
        raise BadInput(f"{run}: no such folder; the folder of a running mission is expected")
    try:
        with connect(run) as client:
            client.settimeout(2.0 * ANSWER_WITHIN_S)
            client.sendall(json.dumps(content).encode() + b"\n")
            with client.makefile("rb") as lines:
                answer = json.loads(lines.readline())
    except (FileNotFoundError, ConnectionRefusedError):
        raise BadInput(f"{run}: no mission runs there") from None
    except (OSError, ValueError) as error:
        raise LinkLost(f"{run}: the mission does not answer: {error}") from error
    if not isinstance(answer, dict) or not answer.get("ok"):
        said = answer.get("error") if isinstance(answer, dict) else None
        raise BadInput(f"{run}: {said or 'the mission refused'}")
    return answer


def _in_folder(path: Path, use: Callable[[str], None]) -> None:
    """A socket's address has room for some hundred characters: a longer path is named through its folder."""
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        use(f"/proc/self/fd/{folder}/{path.name}" if os.path.exists("/proc/self/fd") else str(path))
    finally:
        os.close(folder)
