"""Properties of codec and framing, whatever the values, garbage or chunks."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rover_protocol import framing, messages

frames = st.tuples(st.integers(0, 0xFFFF), st.integers(0, 255), st.binary(max_size=8))
payloads = st.sampled_from(list(messages.BY_ID.values())).flatmap(
    lambda m: st.tuples(st.just(m), st.binary(min_size=m.LENGTH, max_size=m.LENGTH))
)


@given(payloads)
def test_every_payload_of_the_right_length_is_a_message_and_packs_to_itself(case) -> None:
    message, payload = case
    assert message.pack(**message.decode(payload)) == payload


@given(payloads, st.integers(0, 12))
def test_a_payload_of_another_length_is_refused(case, length: int) -> None:
    message, _ = case
    if length != message.LENGTH:
        with pytest.raises(ValueError, match=f"{message.name} has {message.LENGTH} bytes, got {length}"):
            messages.decode(message.ID, bytes(length))


@given(st.integers(0, 0xFFFF).filter(lambda i: i not in messages.BY_ID))
def test_an_unknown_identifier_is_refused(identifier: int) -> None:
    with pytest.raises(ValueError, match=f"unknown identifier 0x{identifier:03x}"):
        messages.decode(identifier, b"")


@given(st.lists(frames, max_size=20), st.integers(1, 40))
def test_frames_survive_any_chunking(sent, chunk: int) -> None:
    wire = b"".join(framing.encode(*frame) for frame in sent)
    decoder = framing.Decoder()
    received = []
    for start in range(0, len(wire), chunk):
        received += decoder.feed(wire[start : start + chunk])
    assert received == sent
    assert (decoder.checksum_errors, decoder.malformed) == (0, 0)


@given(frames)
def test_zeros_are_at_the_ends_of_a_frame_only(frame) -> None:
    wire = framing.encode(*frame)
    assert (wire[0], wire.index(0, 1)) == (0, len(wire) - 1)
    assert len(wire) == len(frame[2]) + 8 <= framing.MAX_FRAME


@given(st.binary(max_size=300), frames)
def test_after_any_garbage_the_next_frame_is_received(garbage: bytes, frame) -> None:
    decoder = framing.Decoder()
    assert decoder.feed(garbage + framing.encode(*frame))[-1] == frame


@given(frames, st.data())
def test_no_single_bit_error_passes_as_a_frame(frame, data) -> None:
    wire = bytearray(framing.encode(*frame))
    bit = data.draw(st.integers(8, 8 * (len(wire) - 1) - 1))
    wire[bit // 8] ^= 1 << bit % 8
    assert framing.Decoder().feed(wire) == []


@pytest.mark.parametrize(
    ("attempt", "problem"),
    [
        (lambda: messages.Stop.pack(reason=256), "Stop.reason: 256 does not fit 8 bits"),
        (lambda: messages.SegmentTravel.pack(1, 1000, -(1 << 23) - 1), "jerk_travel: -8388609 does not fit 24 bits"),
        (lambda: messages.Stop.pack(cause=1), "Stop.cause: no such field"),
        (lambda: messages.Stop.pack(1, reason=1), "Stop.reason: given twice"),
        (lambda: messages.Stop.pack(1, 2), "Stop has 1 fields, got 2 values"),
        (lambda: messages.LogText.pack(text=b"12345678"), "LogText.text: .* is longer than 7 bytes"),
        (lambda: framing.encode(1, 0, bytes(9)), "a payload has at most 8 bytes, got 9"),
    ],
)
def test_what_cannot_be_sent_is_refused_with_its_name(attempt, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        attempt()
