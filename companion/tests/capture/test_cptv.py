"""CPTV clips give the counts and times that went in; what is damaged is named in one line."""

from __future__ import annotations

import hashlib
import random

import numpy as np
import pytest
from rover.capture import open_source
from rover.errors import BadInput

from companion.tests.capture.cptv_sample import cptv_clip

# Of all counts, uint16 little-endian, as the `cptv` package 1.5.5 decodes them.
REAL_CLIP_SHA256 = "61a3d885b645142be914512877d5814d920fec91edfc843c3cbe37bdfda7f4d1"


def pictures(count: int = 4, spread: int = 200) -> list[np.ndarray]:
    rng = np.random.default_rng(3)
    return [rng.integers(3000 - spread, 3000 + spread, (12, 16)).astype(np.uint16) for _ in range(count)]


@pytest.mark.parametrize("bits", [11, 12, 13, 16])
def test_every_bit_width_gives_the_counts_that_went_in(tmp_path, bits):
    file = tmp_path / "clip.cptv"
    given = pictures()
    file.write_bytes(cptv_clip(given, bits))
    frames = list(open_source(f"cptv:{file}"))
    assert len(frames) == len(given)
    for frame, picture in zip(frames, given, strict=True):
        np.testing.assert_array_equal(frame.counts, picture)


def test_times_shutter_and_camera_come_from_the_clip(tmp_path):
    file = tmp_path / "clip.cptv"
    first, second, *_ = pictures()
    file.write_bytes(cptv_clip([first, second, second]))
    frames = list(open_source(f"cptv:{file}"))
    assert [frame.time for frame in frames] == pytest.approx([0.0, 0.111, 0.222])
    assert [frame.since_ffc for frame in frames] == pytest.approx([30.0, 30.111, 30.222])
    assert [frame.ffc for frame in frames] == [False, False, True], "a repeated picture was taken behind the shutter"
    assert frames[0].camera == "flir lepton3.5"
    assert frames[0].kelvin_per_count is None
    with pytest.raises(BadInput, match="no temperatures"):
        frames[0].kelvin()


def test_the_recorders_background_is_left_out_but_counts_as_a_base(tmp_path):
    file = tmp_path / "clip.cptv"
    given = pictures()
    file.write_bytes(cptv_clip(given, background=True))
    frames = list(open_source(f"cptv:{file}"))
    assert [frame.sequence for frame in frames] == [0, 1, 2]
    np.testing.assert_array_equal(frames[0].counts, given[1])


def test_a_real_clip_equals_another_decoder(data_folder):
    frames = list(open_source(f"cptv:{data_folder / 'lepton' / 'v2.cptv'}"))
    assert len(frames) == 100
    assert all(frame.size == (160, 120) for frame in frames)
    counts = b"".join(frame.counts.astype("<u2").tobytes() for frame in frames)
    assert hashlib.sha256(counts).hexdigest() == REAL_CLIP_SHA256
    assert frames[-1].time == pytest.approx(10.999)
    assert all(frame.since_ffc == pytest.approx(30.0) for frame in frames)


def test_damage_is_decoded_or_named_and_never_a_traceback(tmp_path):
    file = tmp_path / "clip.cptv"
    whole = cptv_clip(pictures())
    source = random.Random(2)
    complaints = []
    for attempt in range(200):
        changed = bytearray(whole[: source.randrange(len(whole))] if attempt % 2 else whole)
        if changed and attempt % 3:
            changed[source.randrange(len(changed))] ^= 1 << source.randrange(8)
        file.write_bytes(bytes(changed))
        try:
            list(open_source(f"cptv:{file}"))
        except BadInput as error:
            complaints.append(str(error))
    assert len(complaints) > 100
    assert all("clip.cptv" in line and "\n" not in line for line in complaints)
