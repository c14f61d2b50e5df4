"""The socket of a running mission: lines of JSON in, answers of the mission's own loop out."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from rover.errors import BadInput
from rover.mission import ear
from rover.mission.ear import SOCKET, Ear, ask


@pytest.fixture
def listening(tmp_path: Path) -> Iterator[Path]:
    """A folder in which a mission answers what it was asked."""
    over = threading.Event()
    with Ear(tmp_path) as open_ear:

        def loop() -> None:
            while not over.wait(0.01):
                for request in open_ear.waiting():
                    request.reply({"ok": request.content.get("op") != "nonsense", "heard": request.content})

        thread = threading.Thread(target=loop)
        thread.start()
        yield tmp_path
        over.set()
        thread.join()


def say(folder: Path, line: bytes) -> dict[str, Any]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as client:
        client.settimeout(5.0)
        client.connect(str(folder / SOCKET))
        client.sendall(line)
        answer: dict[str, Any] = json.loads(client.makefile("rb").readline())
        return answer


def test_what_is_asked_is_answered_by_the_loop(listening: Path) -> None:
    assert ask(listening, {"op": "state"})["heard"] == {"op": "state"}


def test_a_refusal_is_one_line(listening: Path) -> None:
    with pytest.raises(BadInput, match="the mission refused"):
        ask(listening, {"op": "nonsense"})


@pytest.mark.parametrize("line", [b"hello\n", b"[1]\n", b"\xff\xfe\n", b"[" * 4000 + b"\n"])
def test_what_is_no_request_is_refused_and_the_next_client_is_heard(listening: Path, line: bytes) -> None:
    assert say(listening, line)["ok"] is False
    assert ask(listening, {"op": "state"})["ok"]


def test_clients_that_say_nothing_do_not_deafen_it(listening: Path) -> None:
    silent = []
    for _ in range(4):
        client = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        client.connect(str(listening / SOCKET))
        silent.append(client)
    assert ask(listening, {"op": "state"})["ok"]
    for client in silent:
        client.close()


def test_only_who_may_write_into_the_folder_is_heard(listening: Path) -> None:
    assert (listening / SOCKET).stat().st_mode & 0o077 == 0


def test_a_mission_that_is_over_leaves_no_socket(tmp_path: Path) -> None:
    with Ear(tmp_path):
        assert (tmp_path / SOCKET).exists()
    assert not (tmp_path / SOCKET).exists()
    with pytest.raises(BadInput, match="no mission runs there"):
        ask(tmp_path, {"op": "state"})


def test_a_socket_that_a_killed_mission_left_is_no_mission(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as dead:
        dead.bind(str(tmp_path / SOCKET))
    with pytest.raises(BadInput, match="no mission runs there"):
        ask(tmp_path, {"op": "state"})


def test_a_loop_that_does_not_answer_is_told_and_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ear, "ANSWER_WITHIN_S", 0.2)
    with Ear(tmp_path):
        begin = time.monotonic()
        with pytest.raises(BadInput, match="has not answered"):
            ask(tmp_path, {"op": "state"})
        assert time.monotonic() - begin < 5.0


@pytest.mark.parametrize("make", [lambda path: path / "nothing", lambda path: path])
def test_a_folder_without_a_mission_is_named(tmp_path: Path, make: Callable[[Path], Path]) -> None:
    with pytest.raises(BadInput, match=str(tmp_path.name)):
        ask(make(tmp_path), {"op": "state"})
