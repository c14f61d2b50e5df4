"""A log that is shown live: what a Foxglove client is told is what stands in the file, with the same schemas."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from rover.capture.frame import Frame
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.record.recording import Recording
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

foxglove_stream = pytest.importorskip("rover.record.foxglove_stream")
pytest.importorskip("foxglove", reason="the extra [foxglove] is not installed")

MESSAGE_DATA = 1


def joined(url: str) -> ClientConnection:
    return connect(url, subprotocols=[Subprotocol("foxglove.sdk.v1")], max_size=None)


def advertised(client: ClientConnection, count: int) -> dict[str, dict[str, str]]:
    """Channels by topic, once so many are known."""
    known: dict[str, dict[str, str]] = {}
    while len(known) < count:
        told = client.recv(timeout=10.0)
        if isinstance(told, str) and json.loads(told)["op"] == "advertise":
            known |= {channel["topic"]: channel for channel in json.loads(told)["channels"]}
    return known


def test_what_is_shown_is_what_is_written(tmp_path: Path) -> None:
    file = tmp_path / "mission.mcap"
    frame = Frame(np.full((120, 160), 29_500, np.uint16), 1.0, 1)
    with foxglove_stream.FoxgloveStream(0, "test") as stream, Recording(file, live=stream) as recording:
        recording.pose(1.0, Pose2(1.0, 2.0, 0.5))
        recording.frame(1.0, frame)
        recording.event("/operator", 1.0, {"word": "pause"})
        with joined(stream.url) as client:
            channels = advertised(client, 4)
            subscriptions = [
                {"id": number, "channelId": channel["id"]} for number, channel in enumerate(channels.values())
            ]
            client.send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))
            told: dict[str, bytes] = {}
            time = 2.0
            while len(told) < len(channels):
                recording.pose(time, Pose2(1.0, 2.0, 0.5))
                recording.frame(time, frame)
                recording.event("/operator", time, {"word": "go"})
                time += 0.1
                try:
                    while True:
                        data = client.recv(timeout=0.2)
                        if isinstance(data, bytes) and data[0] == MESSAGE_DATA:
                            subscription, _ = struct.unpack_from("<IQ", data, 1)
                            told.setdefault(list(channels)[subscription], data[13:])
                except TimeoutError:
                    assert time < 10.0
    with file.open("rb") as opened:
        reader = make_reader(opened)
        written: dict[str, list[bytes]] = {}
        for schema, channel, message in reader.iter_messages():
            written.setdefault(channel.topic, []).append(message.data)
            shown = channels[channel.topic]
            assert shown["encoding"] == channel.message_encoding
            assert shown["schemaName"] == (schema.name if schema else "")
    assert set(told) == set(written)
    assert all(data in written[topic] for topic, data in told.items())


def test_a_log_that_nobody_is_shown_has_the_same_bytes(tmp_path: Path) -> None:
    with foxglove_stream.FoxgloveStream(0, "test") as stream:
        for name, live in (("shown", stream), ("not", None)):
            with Recording(tmp_path / name, live=live) as recording:
                recording.pose(1.0, Pose2(1.0, 2.0, 0.5))
                recording.event("/operator", 1.0, {"word": "pause"})
    assert (tmp_path / "shown").read_bytes() == (tmp_path / "not").read_bytes()


def test_a_port_that_is_taken_is_one_line() -> None:
    with foxglove_stream.FoxgloveStream(0, "test") as stream:
        taken = int(stream.url.rpartition(":")[2])
        with pytest.raises(BadInput, match=f"--foxglove-port {taken}"):
            foxglove_stream.FoxgloveStream(taken, "test")
