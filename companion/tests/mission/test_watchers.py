"""Those who look on: they are told what is newest, and none of them is waited for."""

from __future__ import annotations

import json
import socket
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.mission.ear import MAX_WATCHERS, Ear, ask, connect
from rover.mission.moment import Layers, Moment, messages, seen_places
from rover.mission.watchers import Watchers
from rover.vision.camera.file import load_camera

CAMERA = load_camera("lepton-160")
AT_HOME = Pose2(0.0, 0.0, 0.0)


def moment(number: int, cells: int = 50) -> Moment:
    noise = np.random.default_rng(number).normal(295.0, 3.0, (cells, cells)).astype(np.float32)
    layers = Layers(noise, noise > 294.0, noise > 302.0, 0.02)
    frame = Frame(np.full((120, 160), 29_500, np.uint16), 1.0, number)
    return Moment({"number": number, "sigma": float("inf")}, ((0.0, 0.1, 0.2, 0.3),), frame, AT_HOME, CAMERA,
                  {7: (0.8, 0.0), 8: (-5.0, 0.0)}, layers)  # fmt: skip


def watch(folder: Path) -> socket.socket:
    client = connect(folder)
    client.settimeout(10.0)
    client.sendall(b'{"op": "watch"}\n')
    return client


def offer(watchers: Watchers, number: int) -> None:
    deadline = time.monotonic() + 10.0
    while not watchers.due():
        assert time.monotonic() < deadline
        time.sleep(0.005)
    watchers.show(moment(number))


def test_every_message_is_a_line_of_strict_json_whole_in_itself() -> None:
    told = {kind: json.loads(line) for kind, line in messages(moment(1)).items()}
    assert set(told) == {"state", "track", "map", "picture"}
    assert all(told[kind]["kind"] == kind for kind in told)
    assert told["state"]["sigma"] is None
    assert told["map"]["width_m"] == pytest.approx(1.0)
    assert [each["id"] for each in told["picture"]["candidates"]] == [7]


def test_a_place_appears_where_the_camera_sees_it() -> None:
    [(number, u, v)] = seen_places(
        Pose2(1.0, 2.0, 0.5), CAMERA, {3: (1.0 + 0.8 * np.cos(0.5), 2.0 + 0.8 * np.sin(0.5))}
    )
    assert number == 3
    assert (u, v) == pytest.approx(tuple(CAMERA.ground_to_pixel(np.array([[0.8, 0.0]]))[0]))


def test_nobody_looks_on_and_nothing_is_due(tmp_path: Path) -> None:
    with Ear(tmp_path) as ear:
        assert not ear.watchers.due()


def test_a_watcher_is_told_what_is_newest(tmp_path: Path) -> None:
    with Ear(tmp_path) as ear, watch(tmp_path) as client, client.makefile("rb") as lines:
        offer(ear.watchers, 1)
        first = [json.loads(lines.readline()) for _ in range(4)]
        offer(ear.watchers, 2)
        second = [json.loads(lines.readline()) for _ in range(4)]
    numbers = [each["number"] for each in [*first, *second] if each["kind"] == "state"]
    assert numbers == [1, 2]


def test_one_that_takes_nothing_costs_the_loop_nothing(tmp_path: Path) -> None:
    with Ear(tmp_path) as ear, watch(tmp_path), watch(tmp_path) as quick, quick.makefile("rb") as lines:
        longest, last = 0.0, -1
        for number in range(12):
            while not ear.watchers.due():
                time.sleep(0.002)
            shown = moment(number, cells=400)
            begun = time.perf_counter()
            ear.watchers.show(shown)
            longest = max(longest, time.perf_counter() - begun)
            told: dict[str, Any] = {}
            while told.get("kind") != "state":
                told = json.loads(lines.readline())
            last = told["number"]
        assert last == 11
        # Handing over is no more than a lock; a busy computer may take its time even for that.
        assert longest < 0.1


def test_there_is_always_room_for_one_who_says_stop(tmp_path: Path) -> None:
    with Ear(tmp_path) as ear:
        clients = [watch(tmp_path) for _ in range(MAX_WATCHERS + 2)]
        # Those for whom there was no room are let go.
        assert [client.recv(1) for client in clients[-2:]] == [b"", b""] or len(ear.watchers._watchers) == MAX_WATCHERS
        import threading

        def loop() -> None:
            deadline = time.monotonic() + 10.0
            while time.monotonic() < deadline:
                for request in ear.waiting():
                    request.reply({"ok": True})
                    return
                time.sleep(0.005)

        answering = threading.Thread(target=loop)
        answering.start()
        assert ask(tmp_path, {"op": "stop"})["ok"]
        answering.join()
        for client in clients:
            client.close()


def test_the_end_of_the_mission_ends_the_stream(tmp_path: Path) -> None:
    with Ear(tmp_path) as ear:
        client = watch(tmp_path)
        offer(ear.watchers, 1)
    read = b""
    while piece := client.recv(65536):
        read += piece
    client.close()
    assert read.count(b"\n") in (0, 4)
