"""The companion's end of a lock-stepped rig: bytes and frames at virtual times, and the camera's pictures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from rover.errors import BadInput, LinkLost
from rover.link.port import CanPort
from rover_hil.client.bus import LockstepBus
from rover_hil.client.frames import RigFrames
from rover_hil.client.line import LockstepTransport
from rover_hil.pty import PseudoTerminal
from rover_protocol import messages


@pytest.fixture
def pty() -> Iterator[PseudoTerminal]:
    made = PseudoTerminal()
    yield made
    made.close()


def slcan(name: str, **raw: int) -> bytes:
    message = messages.BY_NAME[name]
    return f"t{message.ID:03X}{message.LENGTH}{message.pack(**raw).hex().upper()}\r".encode()


def test_lockstep_chunks_end_at_the_marks_and_carry_their_times(pty: PseudoTerminal) -> None:
    transport = LockstepTransport(pty.name, patience=0.2)
    pty.write(b"abcdefgh")
    transport.announce([(1_000, 3), (2_000, 3), (5_000, 8)])
    assert transport.read() == [(0.001, b"abc"), (0.005, b"defgh")]
    transport.announce([(6_000, 12)])
    with pytest.raises(LinkLost, match="0 of 4 bytes"):
        transport.read()
    pty.close()
    with pytest.raises(LinkLost, match="link lost"):
        transport.write(b"x")


def test_frames_are_lines_of_text_and_every_character_is_counted(pty: PseudoTerminal) -> None:
    transport = LockstepBus(CanPort("slcan", pty.name))
    opening = pty.read_exactly(10, timeout=2.0)  # python-can writes it command by command
    assert opening == b"C\rS6\r\rO\rO\r"
    transport.send(messages.Arm.ID, messages.Arm.pack(token=0x0107, session=0x2233))
    line = pty.read(100)
    assert line == slcan("Arm", token=0x0107, session=0x2233) == b"t018407013322\r"
    assert transport.bytes_written == len(opening) + len(line)
    up, _ = transport.wire_times(messages.Arm.LENGTH, 8)
    assert up == pytest.approx(0.001 - 50e-6 + 79 / 500_000), "just before the end of a step, and 79 bits"
    transport.close()


def test_a_frame_has_the_time_of_the_mark_at_which_its_line_ended(pty: PseudoTerminal) -> None:
    transport = LockstepBus(CanPort("slcan", pty.name), patience=0.2)
    first, second = slcan("Battery", voltage=7400), slcan("State", state=1)
    pty.write(b"\r" + first + second + b"t99\r" + b"z\r" + slcan("Battery") + slcan("Battery"))
    transport.announce([(1_000, 4), (2_000, 1 + len(first)), (5_000, 1 + len(first) + len(second) + 4 + 2)])
    frames = transport.receive()
    assert [frame.time for frame in frames] == pytest.approx([0.002, 0.005])
    assert [frame.identifier for frame in frames] == [messages.Battery.ID, messages.State.ID]
    assert (transport.counters.frames, transport.counters.malformed) == (2, 1)
    assert transport.receive() == [], "what the rig has not announced is not there yet"
    transport.announce([(6_000, 500)])
    with pytest.raises(LinkLost, match="of 500 bytes came"):
        transport.receive()
    transport.close()


def counts(number: int = 0) -> NDArray[np.uint16]:
    return (np.arange(12 * 16, dtype=np.uint16) + 29_000 + number).reshape(12, 16)


def header(sequence: int, ffc: bool = False) -> dict[str, object]:
    return {"sequence": sequence, "exposure_us": sequence * 120_000, "ffc": ffc, "width": 16, "height": 12}


def test_rig_frames_keep_order_time_and_shutter_flag_and_count_what_was_lost() -> None:
    rig = RigFrames()
    rig.accept([header(0), header(1, ffc=True)], counts(0).tobytes() + counts(1).tobytes())
    rig.accept([header(4)], counts(4).tobytes())
    frames = list(rig)
    assert [(f.sequence, f.ffc) for f in frames] == [(0, False), (1, True), (4, False)]
    assert frames[1].time == pytest.approx(0.12)
    np.testing.assert_array_equal(frames[2].counts, counts(4))
    assert rig.lost == 2
    assert len(rig) == 0


def test_rig_frames_whose_bytes_do_not_fit_their_headers_are_refused_whole() -> None:
    rig = RigFrames()
    with pytest.raises(BadInput, match="their headers say 384"):
        rig.accept([header(0)], counts().tobytes()[:-2])
    assert len(rig) == 0
