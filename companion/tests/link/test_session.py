"""Handshake, heartbeat, arming and the ways in which a link ends."""

from __future__ import annotations

import pytest
from rover.errors import LinkLost, PreflightFailed, SafetyStop
from rover.link.bench import Bench
from rover.link.clock import WallClock
from rover.link.disturbance import Disturbance
from rover.link.frames import SerialFrames
from rover.link.session import Link
from rover.link.telemetry import FirmwareState, LogLine, WheelMotion
from rover.link.transport import SerialTransport

from .listen import listen


def test_the_handshake_tells_who_is_there(world) -> None:
    identity = Link(world, world, session=77).connect()
    assert (identity.version, identity.board, identity.git_hash) == ("0.1.0", "Sitl", "0000abcd")


def test_another_schema_is_refused_and_both_hashes_are_shown(world, firmware) -> None:
    firmware.schema_hash = 0x12345678
    with pytest.raises(PreflightFailed, match=r"0x12345678.*this companion's is 0x") as error:
        Link(world, world).connect()
    assert "\n" not in str(error.value)


def test_no_answer_is_said_to_be_one(world, firmware) -> None:
    firmware.mute = True
    with pytest.raises(PreflightFailed, match="no answer"):
        Link(world, world).connect(timeout=0.5)


def test_keep_alives_count_up_with_every_poll(world, firmware) -> None:
    link = Link(world, world)
    link.connect()
    firmware.keep_alives.clear()
    listen(link, 2.0)
    assert len(firmware.keep_alives) == pytest.approx(100, abs=20), "none where the clock is asked"
    assert all((b - a) & 255 == 1 for a, b in zip(firmware.keep_alives, firmware.keep_alives[1:], strict=False))


def test_arming_uses_a_new_token_each_time(world, firmware) -> None:
    link = Link(world, world)
    link.connect()
    link.arm()
    first = firmware.token
    link.stop()
    listen(link, 0.3)
    link.arm()
    assert firmware.token == first + 1
    assert link.disarm()


@pytest.mark.parametrize("stop", ["stop", "emergency_stop"])
def test_a_stop_that_is_lost_is_sent_again_until_the_firmware_has_stopped(world, firmware, stop: str) -> None:
    link = Link(world, world)
    link.connect()
    link.arm()
    firmware.drop = lambda name, count: name in ("Stop", "EmergencyStop") and count < 7
    getattr(link, stop)()
    listen(link, 0.4)
    assert link.state is not None
    assert link.state.state == "Latched"
    assert firmware.counts["Stop" if stop == "stop" else "EmergencyStop"] < 12, "and not for ever"
    link.arm()
    listen(link, 0.2)
    assert link.state.state == "Armed"


def test_a_refused_arming_says_why(world, firmware) -> None:
    firmware.refuse_arming = True
    link = Link(world, world)
    link.connect()
    with pytest.raises(PreflightFailed, match="does not arm"):
        link.arm(timeout=0.5)


def test_telemetry_has_companion_time_and_unwrapped_counts(world, firmware) -> None:
    link = Link(world, world)
    link.connect()
    link.poll()
    wheels = [event for event in listen(link, 1.0) if isinstance(event, WheelMotion)]
    assert len(wheels) == pytest.approx(50, abs=1)
    assert wheels[-1].time == pytest.approx(link.clock.now(), abs=0.025)
    assert wheels[-1].right_counts == -5


def test_events_that_came_while_arming_are_not_lost(world) -> None:
    link = Link(world, world)
    link.connect()
    link.poll()
    link.arm()
    assert any(isinstance(event, FirmwareState) and event.state == "Armed" for event in link.poll())


def test_a_log_line_is_put_together_from_its_pieces(world, firmware) -> None:
    link = Link(world, world)
    link.connect()
    pieces = [b"sonar 1", b" is dea", b"d\0"]
    offset = 0
    for piece in pieces:
        world.inbox.append((world.time, firmware.frame("LogText", offset=offset, text=piece)))
        offset += 7
    assert [e.text for e in link.poll() if isinstance(e, LogLine)] == ["sonar 1 is dead"]


def test_a_second_of_silence_is_a_lost_link(world, firmware) -> None:
    link = Link(world, world)
    link.connect()
    firmware.mute = True
    with pytest.raises(LinkLost, match="nothing from the firmware"):
        listen(link, 2.0)
    assert world.time < 1.5


def test_a_restarted_firmware_ends_the_mission(world, firmware) -> None:
    link = Link(world, world)
    link.connect()
    firmware.handshake = 0
    with pytest.raises(SafetyStop, match="restarted"):
        listen(link, 0.2)


def test_garbage_is_counted_and_lost_frames_show_in_the_figures(world, firmware) -> None:
    link = Link(world, world)
    link.connect()
    world.inbox.append((world.time, b"\x05garbage\x00\x03\x99\x00"))
    firmware.sequence += 3
    listen(link, 0.2)
    figures = link.figures()
    assert figures.lost == 3
    assert figures.malformed + figures.checksum_errors == 2
    assert 0.9 < figures.quality < 1.0


def test_parameters_are_read(world) -> None:
    link = Link(world, world)
    link.connect()
    assert link.get_parameter(3).value == 42


def test_over_a_real_pty_in_real_time(pty_firmware) -> None:
    clock = WallClock()
    link = Link(SerialTransport(pty_firmware.port, clock=clock), clock)
    link.connect()
    link.arm()
    listen(link, 0.3)
    pty_firmware.pull()
    with pytest.raises(LinkLost, match="link lost"):
        listen(link, 3.0)
    link.close()


def test_a_port_that_is_not_there_is_a_preflight_failure() -> None:
    with pytest.raises(PreflightFailed, match="cannot open the port /nowhere/tty: No such file"):
        SerialTransport("/nowhere/tty")


def frozen(link: Link, world, firmware, seconds: float) -> None:
    """The host stands still: what the firmware says meanwhile is there only after the first look."""
    firmware.mute = True
    world.advance(world.now() + seconds)
    link.poll()
    firmware.mute = False


@pytest.mark.parametrize("seconds", [0.5, 1.0, 3.0, 30.0])
def test_a_host_that_stood_still_does_not_blame_the_wire(world, firmware, seconds: float) -> None:
    link = Link(world, world)
    link.connect()
    listen(link, 0.5)
    frozen(link, world, firmware, seconds)
    listen(link, 2.0)


def test_a_wire_that_is_gone_is_noticed_by_a_host_that_keeps_stumbling(world, firmware) -> None:
    link = Link(world, world)
    link.connect()
    listen(link, 0.5)
    firmware.mute = True
    with pytest.raises(LinkLost, match="nothing from the firmware"):
        stumble(link, world)


def stumble(link: Link, world) -> None:
    for _ in range(10):
        world.advance(world.now() + 0.4)
        link.poll()


def test_a_bench_of_a_firmware_that_never_tells_how_far_it_is_ends_and_says_so(world, firmware) -> None:
    bench = Bench(SerialFrames(world), world, Disturbance(), 1)
    with pytest.raises(LinkLost, match="has not told"):
        bench.run(5.0)
    assert world.now() < 30.0
