"""Logs, videos, radiometric folders and the simulator give the same type of frame; a thread keeps the latest ones."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rover.capture import Frame, open_source
from rover.capture.devices import Camera, list_cameras
from rover.capture.latest import LatestFrames
from rover.capture.mcap_log import McapSource
from rover.capture.source import kind_of
from rover.errors import BadInput
from rover.record.recording import Recording

from companion.tests.capture.flir_sample import MODEL, counts_of, flir_file, jpeg_with


def counts(seed: int = 0, shape: tuple[int, int] = (24, 32)) -> np.ndarray:
    return np.random.default_rng(seed).integers(28000, 31000, shape).astype(np.uint16)


def test_a_log_gives_back_the_frames_that_a_run_recorded(tmp_path):
    file = tmp_path / "mission.mcap"
    with Recording(file) as recording:
        for number, seed in enumerate((1, 2, 2)):
            recording.frame(0.1 * number + 0.06, Frame(counts(seed), 0.1 * number, number + 5))
        recording.log(0.4, "info", "not a picture")
    frames = list(open_source(f"mcap:{file}"))
    assert [frame.time for frame in frames] == pytest.approx([0.0, 0.1, 0.2])
    assert [frame.ffc for frame in frames] == [False, False, True]
    np.testing.assert_array_equal(frames[1].counts, counts(2))
    with pytest.raises(BadInput, match=r"holds foxglove\.Log"):
        list(open_source(f"mcap:{file}?topic=/log"))
    with pytest.raises(BadInput, match="no pictures on /other"):
        list(open_source(f"mcap:{file}?topic=/other"))


@pytest.mark.parametrize("content", [b"", b"text", b"\x89MCAP0\r\n" + b"\xff" * 50])
def test_a_damaged_log_is_one_line(tmp_path, content):
    file = tmp_path / "bad.mcap"
    file.write_bytes(content)
    with pytest.raises(BadInput, match=r"bad\.mcap") as caught:
        list(open_source(f"mcap:{file}"))
    assert "\n" not in str(caught.value)


def test_a_cut_log_gives_what_is_whole_or_one_line(tmp_path):
    file = tmp_path / "mission.mcap"
    with Recording(file) as recording:
        for number in range(200):
            recording.frame(0.1 * number, Frame(counts(number), 0.1 * number, number))
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2])
    source = McapSource(str(file))
    frames = list(source)
    assert source.cut
    assert 0 < len(frames) < 200
    assert all((frame.counts == counts(number)).all() for number, frame in enumerate(frames))


@pytest.mark.parametrize("packing", [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD])
@pytest.mark.parametrize("share", [1.0, 0.7])
def test_logs_of_others_are_read_however_they_are_packed_and_where_they_end(tmp_path, packing, share):
    file = tmp_path / "theirs.mcap"
    with file.open("wb") as stream:
        writer = McapWriter(stream, compression=packing, chunk_size=4096)
        writer.start()
        schema = writer.register_schema("foxglove.RawImage", "protobuf", b"")
        channel = writer.register_channel("/camera/thermal", "protobuf", schema)
        for number in range(40):
            image = RawImage(width=16, height=12, encoding="mono16", step=32, data=noise(number).tobytes())
            writer.add_message(channel, number, image.SerializeToString(), number, number)
        writer.finish()
    file.write_bytes(file.read_bytes()[: int(share * file.stat().st_size)])
    source = McapSource(str(file))
    frames = list(source)
    assert source.cut == (share < 1.0)
    assert len(frames) == 40 if share == 1.0 else 10 < len(frames) < 40
    assert all((frame.counts == noise(number)).all() for number, frame in enumerate(frames))


def noise(number: int) -> np.ndarray:
    return np.random.default_rng(number).integers(0, 65535, (12, 16)).astype(np.uint16)


@pytest.mark.parametrize(
    ("name", "kind"),
    [("a.CPTV", "cptv"), ("a.mcap", "mcap"), ("a.mp4", "video"), ("a.seq", "file"), ("a.tif", "file"),
     ("/dev/video3", "v4l2"), ("a.cptv?unit=raw", "cptv"), ("folder", "folder")],
)  # fmt: skip
def test_a_plain_path_tells_its_kind(name, kind):
    assert kind_of(name) == kind


def test_a_name_with_a_colon_in_it_is_a_file_where_there_is_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cv2.imwrite("18:30.png", np.full((12, 16), 29300, np.uint16))
    (frame,) = open_source("18:30.png")
    assert frame.counts[0, 0] == 29300


def test_a_tiff_of_many_pages_gives_them_all(tmp_path):
    pages = [np.full((12, 16), 29000 + number, np.uint16) for number in range(3)]
    cv2.imwritemulti(str(tmp_path / "many.tif"), pages)
    assert [int(frame.counts[0, 0]) for frame in open_source(str(tmp_path / "many.tif"))] == [29000, 29001, 29002]


def write_video(file: Path, fourcc: str, frames: list[np.ndarray], depth: int) -> None:
    height, width = frames[0].shape
    settings = [cv2.VIDEOWRITER_PROP_DEPTH, depth, cv2.VIDEOWRITER_PROP_IS_COLOR, 0]
    writer = cv2.VideoWriter(str(file), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*fourcc), 9.0, (width, height), settings)
    if not writer.isOpened():
        pytest.skip(f"this OpenCV cannot write {fourcc}")
    for frame in frames:
        writer.write(frame)
    writer.release()


def test_an_8_bit_video_gives_grey_levels_that_are_no_temperatures(tmp_path):
    file = tmp_path / "clip.avi"
    given = [cv2.GaussianBlur(np.random.default_rng(n).integers(0, 255, (48, 64)).astype(np.uint8), (0, 0), 5)
             for n in range(4)]  # fmt: skip
    write_video(file, "FFV1", given, cv2.CV_8U)
    frames = list(open_source(f"video:{file}"))
    assert len(frames) == 4
    assert frames[0].size == (64, 48)
    assert np.abs(frames[2].counts.astype(int) - given[2]).max() <= 2
    assert frames[1].time == pytest.approx(1 / 9, abs=1e-3)
    assert frames[0].kelvin_per_count is None


def test_a_16_bit_video_keeps_its_16_bits(tmp_path):
    file = tmp_path / "clip.mkv"
    given = [counts(n, (48, 64)) for n in range(3)]
    write_video(file, "FFV1", given, cv2.CV_16U)
    frames = list(open_source(f"video:{file}?unit=centikelvin&fps=5"))
    np.testing.assert_array_equal(frames[1].counts, given[1])
    assert frames[2].time == pytest.approx(0.4)


def test_what_is_no_video_is_one_line(tmp_path):
    file = tmp_path / "clip.avi"
    file.write_text("hello")
    with pytest.raises(BadInput, match=r"clip\.avi: cannot be opened"):
        list(open_source(f"video:{file}"))
    with pytest.raises(BadInput, match="no such video"):
        open_source(f"video:{tmp_path / 'none.avi'}")


def test_a_folder_of_radiometric_pictures_comes_in_hundredths_of_kelvin(tmp_path):
    kelvin = np.linspace(280.0, 310.0, 48 * 64).reshape(48, 64)
    for number in range(2):
        (tmp_path / f"IR_{number}.jpg").write_bytes(jpeg_with(flir_file(counts_of(kelvin), "png", ">")))
    frames = list(open_source(f"radiometric:{tmp_path}?fps=2"))
    assert [frame.time for frame in frames] == pytest.approx([0.0, 0.5])
    assert frames[0].camera == MODEL
    assert np.abs(frames[0].kelvin() - kelvin).max() < 0.06


def test_the_simulator_gives_frames_that_move_and_the_same_ones_for_the_same_seed():
    pytest.importorskip("rover_hil")
    first, again = ([frame.counts for frame in open_source("simulator:demo?seed=3&seconds=0.7")] for _ in range(2))
    assert len(first) >= 4
    assert first[0].shape == (120, 160)
    assert not np.array_equal(first[0], first[-1])
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))


def test_options_of_folders_say_what_the_counts_are(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), counts())
    cv2.imwrite(str(tmp_path / "b.png"), counts())
    frames = list(open_source(f"folder:{tmp_path}?fps=4&unit=raw"))
    assert frames[1].time == pytest.approx(0.25)
    assert frames[0].kelvin_per_count is None


def test_the_pipeline_never_waits_and_knows_what_it_missed():
    release = threading.Event()

    def camera():
        for number in range(10):
            yield Frame(counts(number), 0.1 * number, number)
        release.wait(5.0)
        yield Frame(counts(10), 1.0, 10)

    with LatestFrames(camera(), depth=2) as latest:
        deadline = time.monotonic() + 5.0
        while latest.dropped < 8 and time.monotonic() < deadline:
            time.sleep(0.002)
        assert [frame.sequence for frame in latest.take()] == [8, 9]
        begin = time.monotonic()
        assert latest.take() == []
        assert time.monotonic() - begin < 0.5
        assert not latest.finished
        release.set()
        while not latest.finished and time.monotonic() < deadline:
            time.sleep(0.002)
            assert all(frame.sequence == 10 for frame in latest.take())
        assert latest.dropped == 8


def test_what_ends_a_camera_reaches_the_pipeline_after_its_last_frames():
    def camera():
        yield Frame(counts(), 0.0, 0)
        raise BadInput("the camera went away")

    with LatestFrames(camera()) as latest:
        deadline = time.monotonic() + 5.0
        taken: list[Frame] = []
        while not taken and time.monotonic() < deadline:
            taken += latest.take()
            time.sleep(0.002)
        while not latest.finished and time.monotonic() < deadline:
            time.sleep(0.002)
        with pytest.raises(BadInput, match="went away"):
            latest.take()
        assert len(taken) == 1


def test_cameras_are_listed_as_the_kernel_names_them(tmp_path):
    for node, name, index in (("video10", "Boson: Boson Video", 0), ("video2", "PureThermal (fw:v1.3.0)", 0),
                              ("video3", "PureThermal (fw:v1.3.0)", 1)):  # fmt: skip
        (tmp_path / node).mkdir()
        (tmp_path / node / "name").write_text(name + "\n")
        (tmp_path / node / "index").write_text(f"{index}\n")
    assert list_cameras(tmp_path) == [Camera("/dev/video2", "PureThermal (fw:v1.3.0)"),
                                      Camera("/dev/video10", "Boson: Boson Video")]  # fmt: skip
    assert list_cameras(tmp_path / "none") == []


@pytest.mark.parametrize("seed", range(3))
def test_flipped_bits_in_a_log_end_in_frames_or_one_line(tmp_path: Path, seed: int) -> None:
    whole = tmp_path / "whole.mcap"
    with Recording(whole) as recording:
        for number in range(12):
            recording.frame(0.1 * number, Frame(counts(number), 0.1 * number, number))
    content, rng = whole.read_bytes(), np.random.default_rng(seed)
    file = tmp_path / "damaged.mcap"
    for _ in range(60):
        damaged = bytearray(content)
        for at in rng.integers(0, len(content), int(rng.integers(1, 6))):
            damaged[at] ^= 1 << int(rng.integers(8))
        file.write_bytes(damaged)
        assert outcome(file) <= 12


def outcome(file: Path) -> int:
    """How many frames a log gives; 0 where it gives one line instead."""
    try:
        return len(list(McapSource(str(file))))
    except BadInput as error:
        return 0 if "\n" not in str(error) else 1000
