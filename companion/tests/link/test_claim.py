"""One owner for each port: by the device behind the name, told by name, gone with its process."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover.link import claim
from rover.link.claim import Claim, PortHeld, device_of, mission_on
from rover.link.transport import SerialTransport

HOLD = """
import sys, time
from rover.link.claim import Claim
claim = Claim(sys.argv[1])
print("held", flush=True)
time.sleep(60.0)
"""


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Locks of their own: another test may hold a pseudo-terminal of the same number."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)


@pytest.fixture
def port() -> Iterator[str]:
    master, slave = pty.openpty()
    yield os.ttyname(slave)
    os.close(master)
    os.close(slave)


@pytest.fixture
def other(port: str) -> Iterator[subprocess.Popen[str]]:
    """Another program that has claimed the port."""
    program = subprocess.Popen([sys.executable, "-c", HOLD, port], stdout=subprocess.PIPE, text=True)
    assert program.stdout is not None
    assert program.stdout.readline() == "held\n"
    yield program
    program.kill()
    program.communicate()


def test_who_comes_second_is_told_who_holds_the_port(port: str, other: subprocess.Popen[str]) -> None:
    with pytest.raises(PortHeld, match=rf"{port} is in use by -c {port} \(pid {other.pid}, since 20"):
        Claim(port)
    with pytest.raises(PreflightFailed, match="is in use by"):
        SerialTransport(port)


def test_another_name_for_the_same_device_is_no_way_in(port: str, other: subprocess.Popen[str], tmp_path: Path) -> None:
    link = tmp_path / "rover"
    link.symlink_to(port)
    for name in (str(link), f"can:slcan:{port}", f"can:slcan:{link}"):
        with pytest.raises(PortHeld):
            Claim(name)


def test_a_port_whose_holder_was_killed_is_free(port: str, other: subprocess.Popen[str]) -> None:
    other.send_signal(signal.SIGKILL)
    other.wait()
    Claim(port).release()


def test_a_port_that_was_let_go_is_free_again(port: str) -> None:
    for _ in range(3):
        transport = SerialTransport(port)
        with pytest.raises(PortHeld):
            Claim(port)
        transport.close()
    Claim(port).release()


def test_a_port_that_does_not_open_is_not_held(port: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise OSError(5, "broken")

    with monkeypatch.context() as patched:
        patched.setattr("serial.Serial", broken)
        with pytest.raises(PreflightFailed, match="cannot open"):
            SerialTransport(port)
    Claim(port).release()


def test_the_note_names_the_mission_that_can_be_asked(port: str, tmp_path: Path) -> None:
    held = Claim(port)
    mission_on(port, tmp_path / "run")
    with pytest.raises(PortHeld) as refused:
        Claim(port)
    assert refused.value.holder is not None
    assert refused.value.holder.run == str(tmp_path / "run")
    held.release()


@pytest.mark.parametrize("note", [b"", b"nonsense", b'{"pid": "x"}', b"\xff" * 9000, b'{"pid": 1}'])
def test_a_note_that_says_nothing_still_keeps_others_out(port: str, note: bytes) -> None:
    held = Claim(port)
    path = claim.folder() / f"{device_of(port)}.lock"
    path.write_bytes(note)
    with pytest.raises(PortHeld, match="another program"):
        Claim(port)
    held.release()


def test_control_characters_of_a_note_do_not_reach_the_terminal(port: str) -> None:
    held = Claim(port)
    path = claim.folder() / f"{device_of(port)}.lock"
    path.write_text(json.dumps({"pid": 1, "command": "\x1b[31mrover\nrun", "since": "now", "run": ""}))
    with pytest.raises(PortHeld) as refused:
        Claim(port)
    assert str(refused.value).isprintable()
    held.release()


def test_what_is_no_device_is_not_claimed(tmp_path: Path) -> None:
    assert device_of(str(tmp_path)) is None
    assert device_of("can:virtual:test") is None
    assert device_of("can:socketcan:can0") == "can-socketcan-can0"
    Claim(str(tmp_path / "nothing")).release()
