"""The served sitl rig: control socket, lock step, marks and frames, truth files, and what ends it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rover.link.baud import DEFAULT_BAUD
from rover.record.tum import read_tum
from rover_hil.testing.firmware_talk import FirmwareTalk
from rover_hil.testing.rigs import RunningRig, rig_command

Start = Callable[..., RunningRig]
BYTES_PER_MS = DEFAULT_BAUD / 10 / 1000


def test_hello_tells_the_time_and_the_camera_and_nonsense_is_answered_with_an_error(
    rig: Start, rig_name: str
) -> None:
    client = rig("--seed", "3").client()
    assert "op 'fly'" in client.ask(op="fly")[0]["error"]
    assert "'to_us' is missing" in client.ask(op="advance", host_bytes=0)[0]["error"]
    reply, _ = client.ask(op="hello")
    assert reply["now_us"] == 0
    assert reply["rig"] == rig_name
    camera = {"name": "lepton-160", "width": 160, "height": 120, "period_us": 120_000, "latency_us": 60_000}
    assert reply["camera"] == camera


def test_time_moves_by_what_is_asked_and_brings_frames_and_marks(rig: Start) -> None:
    client = rig().client()
    client.ask(op="hello")
    reply, blob = client.ask(op="advance", to_us=100_000, host_bytes=0)
    assert reply["now_us"] == 100_000
    assert (reply["frames"], blob) == ([], b"")
    reply, blob = client.ask(op="advance", to_us=350_000, host_bytes=0)
    assert [frame["delivered_us"] for frame in reply["frames"]] == [110_000, 230_000, 350_000]
    assert [frame["exposure_us"] for frame in reply["frames"]] == [50_000, 170_000, 290_000]
    pictures = np.frombuffer(blob, dtype="<u2").reshape(3, 120, 160)
    assert (pictures > 27_000).all()
    assert (pictures < 36_000).all()
    times, totals = np.array(reply["marks"]).T
    assert (times > 100_000).all()
    assert (times <= 350_000).all()
    assert (np.diff(totals) > 0).all()


def test_the_bytes_that_the_marks_announce_are_on_the_port_and_keep_to_the_baud_rate(rig: Start) -> None:
    running = rig()
    client = running.client()
    client.ask(op="hello")
    with FirmwareTalk(running.port) as talk:
        marks = []
        for step in range(1, 51):
            reply, _ = client.ask(op="advance", to_us=step * 20_000, host_bytes=0)
            marks += reply["marks"]
        talk.read_exactly(marks[-1][1])
        assert talk.decoder.checksum_errors == talk.decoder.malformed == talk.decoder.lost == 0
        assert talk.newest("State")["state"] == "Disarmed"
    before = (0, 0)
    for at, total in marks:
        assert total - before[1] <= BYTES_PER_MS * (at - before[0]) / 1000 + 1
        before = (at, total)


def test_bytes_of_the_host_take_their_time_on_the_wire(rig: Start) -> None:
    """A Hello behind 230 zero bytes is answered 10 ms later than a Hello alone."""
    running = rig()
    client = running.client()
    client.ask(op="hello")
    now = 300_000

    def delay(ahead: bytes) -> int:
        """From writing until the reply, µs."""
        nonlocal now
        asked, replies = now, len(talk.received("HelloReply"))
        talk.write_raw(ahead)
        written = talk.send("Hello", schema_hash=0, session=5)
        while len(talk.received("HelloReply")) == replies:
            now += 1000
            advance(written)
            assert now < asked + 100_000
        return now - asked

    def advance(written: int) -> None:
        reply, _ = client.ask(op="advance", to_us=now, host_bytes=written)
        if reply["marks"]:
            talk.read_exactly(reply["marks"][-1][1] - talk.bytes_read)

    with FirmwareTalk(running.port) as talk:
        advance(0)
        alone = delay(b"")
        behind = delay(bytes(230))
    assert 9_000 <= behind - alone <= 12_000


def test_finish_returns_the_verdict_and_writes_the_truth(rig: Start, tmp_path: Path) -> None:
    out = tmp_path / "run"
    running = rig("--out", str(out), "--seed", "4")
    client = running.client()
    client.ask(op="hello")
    client.ask(op="advance", to_us=1_000_000, host_bytes=0)
    verdict, _ = client.ask(op="finish", zones=[{"t": 0.0, "id": 9, "x": 0.45, "y": 0.45, "r": 0.3}], detections=[])
    assert verdict["collisions"] == 0
    assert verdict["keepout_violations"] == 0
    assert verdict["unseen_ground_m2"] == 0.0
    assert verdict["wheel_over_mine"] == 0
    assert verdict["zones_declared_under_wheel"] == [9]
    truth = read_tum(out / "truth.tum")
    assert len(truth) == 101
    assert truth[-1] == pytest.approx([1.0, 0.45, 0.45, np.pi / 4], abs=1e-6)
    document = json.loads((out / "truth.json").read_text())
    assert len(document["mines"]) == 5
    assert document["verdict"] == verdict
    client.socket.close()
    assert running.process.wait(timeout=5.0) == 0


def test_the_same_seed_gives_the_same_bytes_over_port_and_socket(rig: Start) -> None:
    def run(seed: str) -> tuple[bytes, bytes]:
        running = rig("--seed", seed)
        client = running.client()
        client.ask(op="hello")
        with FirmwareTalk(running.port) as talk:
            written = talk.hello()
            reply, pictures = client.ask(op="advance", to_us=600_000, host_bytes=written)
            return talk.read_exactly(reply["marks"][-1][1]), pictures

    assert run("11") == run("11")


def test_pressing_the_emergency_stop_latches_the_firmware(rig: Start) -> None:
    running = rig()
    client = running.client()
    client.ask(op="hello")
    with FirmwareTalk(running.port) as talk:
        client.ask(op="inputs", emergency_stop=True)
        reply, _ = client.ask(op="advance", to_us=500_000, host_bytes=0)
        talk.read_exactly(reply["marks"][-1][1])
        assert talk.newest("State")["flags"] & 2


def test_a_lost_companion_leaves_the_rig_running_and_the_firmware_stops_by_its_dead_man(rig: Start) -> None:
    running = rig("--linger", "20")
    client = running.client()
    client.ask(op="hello")
    with FirmwareTalk(running.port) as talk:
        now = talk.arm_and_drive_ahead(client)
        for _ in range(75):
            now += 20_000
            reply, _ = client.ask(op="advance", to_us=now, host_bytes=talk.keep_alive())
            talk.read_exactly(reply["marks"][-1][1] - talk.bytes_read)
        assert talk.newest("State")["state"] == "Moving"
        assert talk.newest("Velocity")["measured_travel"] > 0.15 * 10_000
        client.socket.close()

    # The companion is gone with port and socket; some other program asks.
    with FirmwareTalk(running.port) as asking:
        state = asking.wait_for("State", lambda values: values["state"] == "Latched", seconds=3.0)
        assert state["cause"] == "DeadMan"
        asking.hello()
        assert asking.wait_for("HelloBuild", lambda _: True, seconds=2.0)["accepted"] == 1
    assert running.process.poll() is None


def test_the_rig_ends_when_no_companion_comes_back(rig: Start) -> None:
    running = rig("--linger", "0.2")
    client = running.client()
    client.ask(op="hello")
    client.socket.close()
    assert running.process.wait(timeout=5.0) == 0
    assert not Path(running.control).exists()


def test_a_second_companion_counts_from_zero(rig: Start) -> None:
    running = rig("--linger", "20")
    client = running.client()
    client.ask(op="hello")
    with FirmwareTalk(running.port) as talk:
        client.ask(op="advance", to_us=300_000, host_bytes=talk.hello())
        client.socket.close()
    client = running.client()
    start, _ = client.ask(op="hello")
    assert start["now_us"] >= 300_000
    with FirmwareTalk(running.port) as talk:
        reply, _ = client.ask(op="advance", to_us=start["now_us"] + 200_000, host_bytes=talk.hello())
        talk.read_exactly(reply["marks"][-1][1])
        assert talk.received("HelloBuild")


def test_when_the_firmware_dies_everything_closes_and_the_rig_says_so(rig: Start) -> None:
    running = rig()
    client = running.client()
    client.ask(op="hello")
    port = os.open(running.port, os.O_RDWR | os.O_NOCTTY)
    try:
        os.kill(running.firmware_pid, signal.SIGKILL)
        reply, _ = client.ask(op="advance", to_us=20_000, host_bytes=0)
        assert "rover-sitl has ended" in reply["error"]
        with pytest.raises((EOFError, ConnectionError)):
            client.ask(op="hello")
        assert running.process.wait(timeout=5.0) == 1
        while os.read(port, 4096):  # what was sent before, then the end of the file
            pass
        assert running.process.stderr is not None
        assert "rover-sitl has ended" in running.process.stderr.read().decode()
    finally:
        os.close(port)


@pytest.mark.parametrize(
    ("change", "environment", "code", "says"),
    [
        (["--mission", "no-such-file.toml"], {}, 2, "no-such-file.toml"),
        (["--rig", "spaceship"], {}, 2, "--rig spaceship: not known here"),
        ([], {"ROVER_SITL": "/nowhere/rover-sitl"}, 3, "run 'make setup'"),
        (["--control", "/nowhere/control"], {}, 3, "cannot listen there"),
    ],
)
def test_what_cannot_start_says_why_in_one_line(
    tmp_path: Path, change: list[str], environment: dict[str, str], code: int, says: str
) -> None:
    command = [*rig_command(tmp_path / "control"), *change]
    result = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, timeout=60)
    assert result.returncode == code
    assert result.stdout == "" or "/nowhere/control" in command
    assert says in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
