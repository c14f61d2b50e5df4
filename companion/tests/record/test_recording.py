"""The log reads back with standard tools, is the same for the same run, and survives a dying process."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path

import numpy as np
import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory
from rover.capture.frame import Frame
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.link.telemetry import WheelMotion
from rover.record.journal import to_json
from rover.record.recording import Recording


def fill(recording: Recording, seconds: int = 3) -> None:
    rng = np.random.default_rng(1)
    for step in range(seconds * 8):
        time = step * 0.125
        counts = (29_000 + rng.integers(0, 50, (120, 160))).astype(np.uint16)
        recording.frame(time + 0.06, Frame(counts, time, step))
        recording.pose(time, Pose2(time, 0.5, 0.1))
        recording.telemetry(time, WheelMotion(time, step, -step))
        recording.link("rx", time, 112, b"\x01\x02")
    recording.log(seconds, "warning", "sonar 1 is dead")
    recording.path(seconds, np.array([[0.0, 0.0], [1.0, 2.0]]))


def test_messages_read_back_with_the_published_schemas(tmp_path: Path) -> None:
    file = tmp_path / "mission.mcap"
    with Recording(file, {"seed": "1"}) as recording:
        fill(recording)
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        images = [m for _, _, _, m in reader.iter_decoded_messages(topics=["/camera/thermal"])]
    assert len(images) == 24
    assert (images[3].encoding, images[3].width, images[3].height, images[3].step) == ("mono16", 160, 120, 320)
    assert images[3].timestamp.nanos == 375_000_000
    rng = np.random.default_rng(1)
    first = (29_000 + rng.integers(0, 50, (120, 160))).astype(np.uint16)
    assert np.array_equal(np.frombuffer(images[0].data, "<u2").reshape(120, 160), first)


def test_own_values_are_json_with_a_schema(tmp_path: Path) -> None:
    file = tmp_path / "mission.mcap"
    with Recording(file) as recording:
        fill(recording)
    with file.open("rb") as stream:
        schema, channel, message = next(iter(make_reader(stream).iter_messages(topics=["/telemetry/WheelMotion"])))
    assert schema is not None
    assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
    assert json.loads(schema.data)["properties"]["left_counts"] == {"type": "integer"}
    assert json.loads(message.data) == {"time": 0.0, "left_counts": 0, "right_counts": 0}


def test_the_same_run_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        with Recording(tmp_path / name, {"z": "1", "a": "2"}) as recording:
            fill(recording)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_log_without_its_end_is_readable_up_to_the_last_chunk(tmp_path: Path) -> None:
    file = tmp_path / "mission.mcap"
    recording = Recording(file)
    fill(recording, seconds=6)
    left_behind = file.read_bytes()
    recording.close()
    times = []
    with contextlib.suppress(EndOfFile):  # there is no footer
        for record in StreamReader(io.BytesIO(left_behind)).records:
            if isinstance(record, Message):
                times.append(record.log_time * 1e-9)
    assert len(times) > 100
    assert max(times) > 4.0


def test_a_number_that_json_lacks_becomes_null(tmp_path: Path) -> None:
    assert to_json({"a": [float("inf"), 1.5], "b": float("nan")}) == '{"a":[null,1.5],"b":null}'


def test_what_has_no_form_in_json_is_refused(tmp_path: Path) -> None:
    with Recording(tmp_path / "x.mcap") as recording, pytest.raises(TypeError, match="/plan"):
        recording.event("/plan", 0.0, [1, 2])


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that takes nothing is a Linux thing")
def test_a_log_that_cannot_even_begin_is_bad_input() -> None:
    with pytest.raises(BadInput, match=r"^/dev/full: the log cannot be written: No space left on device$"):
        Recording(Path("/dev/full"))


def test_a_disk_that_fills_up_ends_the_log_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with Recording(tmp_path / "mission.mcap") as recording:
        fill(recording)
        assert recording.failure is None
        monkeypatch.setattr(recording._writer, "add_message", full)
        fill(recording)
        recording.identify("firmware", {"version": "1"})
    assert recording.failure == "the log can no longer be written: No space left on device"
