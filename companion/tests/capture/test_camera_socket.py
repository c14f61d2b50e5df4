"""Pictures from another process: what was published comes, a publisher may go and come again."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from rover.capture import Frame, open_source
from rover.capture.latest import LatestFrames
from rover.capture.publisher import FramePublisher
from rover.capture.source import open_camera
from rover.errors import BadInput


def picture(number: int) -> Frame:
    counts = np.arange(48, dtype=np.uint16).reshape(6, 8) + number
    return Frame(counts.astype(np.uint16), 100.0 + number, number, number == 3)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "camera.sock"


@pytest.fixture
def publisher(path: Path) -> Iterator[FramePublisher]:
    made = FramePublisher(path)
    yield made
    made.close()


def take(frames: LatestFrames, publisher: FramePublisher, count: int) -> list[Frame]:
    taken: list[Frame] = []
    deadline = time.monotonic() + 5.0
    while len(taken) < count and time.monotonic() < deadline:
        publisher.publish()
        taken += frames.take()
        time.sleep(0.005)
    return taken


def test_what_is_published_comes_as_it_was(path, publisher):
    with LatestFrames(open_camera(f"socket:{path}"), depth=10) as frames:
        time.sleep(0.1)
        publisher.publish()
        publisher.publish(*(picture(number) for number in range(5)))
        taken = take(frames, publisher, 5)
    assert [frame.sequence for frame in taken] == [0, 1, 2, 3, 4]
    assert [frame.time for frame in taken] == [100.0, 101.0, 102.0, 103.0, 104.0]
    assert [frame.ffc for frame in taken] == [False, False, False, True, False]
    assert all(np.array_equal(frame.counts, picture(frame.sequence).counts) for frame in taken)
    assert {frame.kelvin_per_count for frame in taken} == {0.01}


def test_a_publisher_that_starts_again_is_found(path, publisher):
    with LatestFrames(open_camera(f"socket:{path}"), depth=10) as frames:
        time.sleep(0.1)
        publisher.publish()
        publisher.publish(picture(0))
        assert len(take(frames, publisher, 1)) == 1
        publisher.close()
        again = FramePublisher(path)
        time.sleep(0.6)
        again.publish()
        again.publish(picture(1))
        assert [frame.sequence for frame in take(frames, again, 1)] == [1]
        again.close()


def test_pictures_of_another_size_end_the_source(path, publisher):
    with LatestFrames(open_camera(f"socket:{path}"), depth=10) as frames:
        time.sleep(0.1)
        publisher.publish()
        publisher.publish(picture(0), Frame(np.zeros((4, 4), np.uint16), 101.0, 1))
        assert len(take(frames, publisher, 1)) == 1
        with pytest.raises(BadInput, match="the size of its pictures has changed"):
            take(frames, publisher, 1)


def test_a_reader_that_does_not_read_holds_nobody_up(path, publisher):
    reader = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    reader.connect(str(path))
    large = Frame(np.zeros((512, 640), np.uint16), 0.0, 0)
    begin = time.monotonic()
    for _ in range(10):
        publisher.publish(large)
    assert time.monotonic() - begin < 1.0
    reader.close()


def test_a_socket_where_nobody_listens_is_bad_input(path):
    with pytest.raises(BadInput, match="nobody publishes"):
        next(iter(open_camera(f"socket:{path}")))


def test_other_bytes_are_said_to_be_no_pictures(path):
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    listener.bind(str(path))
    listener.listen(1)

    def talk() -> None:
        connection, _ = listener.accept()
        connection.sendall(b"x" * 64)

    thread = threading.Thread(target=talk)
    thread.start()
    with pytest.raises(BadInput, match="no pictures"):
        next(iter(open_source(f"socket:{path}")))
    thread.join()
    listener.close()


@pytest.mark.parametrize("location", ["simulator:demo", "folder:.", "v5l:0"])
def test_a_recording_is_no_camera_for_a_real_rover(location):
    with pytest.raises(BadInput):
        open_camera(location)
