"""UF2 files, the boot loader's drive, and the self-test: what is refused, and what is said then."""

from __future__ import annotations

import dataclasses
import errno
import os
import stat
from pathlib import Path

import pytest
from rover.errors import BadInput, LinkLost, PreflightFailed
from rover.link import flashing
from rover.link.boot_drive import find_drives, read_drive, unmounted, write
from rover.link.self_test import self_test
from rover.link.telemetry import Battery, FirmwareState
from rover.link.uf2 import Mark, read_uf2

from .uf2_file import ABSOLUTE, RP2350, block, boot_drive, marked_file, uf2_file


def quiet(written: int, total: int) -> None:
    """No progress."""


def test_a_file_says_for_which_board_it_is(tmp_path: Path) -> None:
    firmware = read_uf2(uf2_file(tmp_path / "a.uf2"))
    assert (firmware.blocks, firmware.family_names) == (300, "RP2040")


def test_a_file_says_of_which_board_and_commit_its_image_is(tmp_path: Path) -> None:
    assert read_uf2(marked_file(tmp_path / "a.uf2", 1, 0xC0FFEE)).mark == Mark("Rp2040", "00c0ffee")
    assert read_uf2(uf2_file(tmp_path / "b.uf2")).mark is None


def test_a_file_for_the_rp2350_may_begin_with_an_absolute_block(tmp_path: Path) -> None:
    file = uf2_file(tmp_path / "a.uf2", 4, RP2350, before=block(0, 2, ABSOLUTE))
    assert read_uf2(file).family_names == "RP2350"


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "no UF2 file"),
        (b"x" * 512, "block 0 has not UF2's marks"),
        (block(0, 2) + block(1, 2)[:-1], "not a whole number"),
        (block(0, 3) + block(1, 3), "ends after 2 of 3 blocks"),
        (block(0, 3) + block(2, 3), "block 1 says that it is number 2"),
        (block(0, 1, flags=0x2001), "not meant for the flash"),
        (block(0, 1, flags=0), "not meant for the flash of a named board"),
        (block(0, 1, ABSOLUTE), "does not say for which board"),
    ],
)
def test_a_file_that_is_not_whole_is_refused(tmp_path: Path, content: bytes, why: str) -> None:
    file = tmp_path / "bad.uf2"
    file.write_bytes(content)
    with pytest.raises(BadInput, match=why) as error:
        read_uf2(file)
    assert str(file) in str(error.value)


def test_a_drive_is_known_by_what_lies_on_it(tmp_path: Path) -> None:
    boot_drive(tmp_path / "one")
    (tmp_path / "stick").mkdir()
    (drive,) = find_drives([f"{tmp_path}/*"])
    assert (drive.folder, drive.board_id, drive.model) == (tmp_path / "one", "RPI-RP2", "Raspberry Pi RP2")


def test_the_firmware_arrives_byte_for_byte_and_progress_is_told(tmp_path: Path) -> None:
    drive = read_drive(boot_drive(tmp_path / "drive"))
    firmware = read_uf2(uf2_file(tmp_path / "a.uf2"))
    told: list[tuple[int, int]] = []
    assert drive is not None
    write(drive, firmware, lambda *progress: told.append(progress))
    assert (drive.folder / "rover.uf2").read_bytes() == firmware.content
    assert told[-1] == (len(firmware.content),) * 2
    assert len(told) > 3


@pytest.mark.parametrize(("board", "family"), [("RP2350", 0xE48BFF56), ("RPI-RP2", RP2350)])
def test_firmware_for_another_board_is_not_written(tmp_path: Path, board: str, family: int) -> None:
    drive = read_drive(boot_drive(tmp_path / "drive", board, f"Raspberry Pi {board}"))
    assert drive is not None
    with pytest.raises(BadInput, match=f"is for RP2.* and the board on .* is Raspberry Pi {board}"):
        write(drive, read_uf2(uf2_file(tmp_path / "a.uf2", 3, family)), quiet)
    assert os.listdir(drive.folder) == ["INFO_UF2.TXT"]


def test_a_drive_that_cannot_take_it_is_said_to_be_one(tmp_path: Path) -> None:
    drive = read_drive(boot_drive(tmp_path / "drive"))
    assert drive is not None
    (drive.folder / "rover.uf2").symlink_to("/dev/full")
    with pytest.raises(LinkLost, match=f"0 of 153600 bytes written, then: {os.strerror(errno.ENOSPC)}"):
        write(drive, read_uf2(uf2_file(tmp_path / "a.uf2")), quiet)


def test_of_two_boards_one_has_to_be_chosen(tmp_path: Path) -> None:
    for name in ("one", "two"):
        boot_drive(tmp_path / name)
    with pytest.raises(BadInput, match=r"--drive .*one or .*two"):
        flashing.choose_drive(None, [f"{tmp_path}/*"])


def test_a_drive_that_is_plugged_in_and_not_mounted_is_named(tmp_path: Path) -> None:
    assert unmounted(tmp_path) is None
    (tmp_path / "RPI-RP2").touch()
    assert unmounted(tmp_path) == tmp_path / "RPI-RP2"


def probe_rs(folder: Path, script: str) -> None:
    """A stand-in for the program probe-rs, which is not part of this project."""
    program = folder / "probe-rs"
    program.write_text(f'#!/bin/sh\necho "$@" >> {folder}/calls\n{script}\n')
    program.chmod(program.stat().st_mode | stat.S_IXUSR)


def test_a_debug_probe_is_used_through_probe_rs(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    assert not flashing.has_probe()
    probe_rs(tmp_path, 'test "$1" != list || echo "[0]: Debug Probe (CMSIS-DAP)"')
    assert flashing.has_probe()
    said: list[str] = []
    flashing.flash_by_probe(Path("a.uf2"), "RP2040", said.append)
    calls = (tmp_path / "calls").read_text().splitlines()
    assert calls[1:] == ["download --chip RP2040 --binary-format uf2 a.uf2", "reset --chip RP2040"]
    probe_rs(tmp_path, "echo no such chip >&2; exit 1")
    assert not flashing.has_probe()
    with pytest.raises(LinkLost, match="probe-rs: no such chip"):
        flashing.flash_by_probe(Path("a.uf2"), "RP2040", said.append)


def test_a_rover_that_does_not_answer_is_not_restarted(pty_firmware) -> None:
    pty_firmware.firmware.mute = True
    with pytest.raises(PreflightFailed, match="no answer"):
        flashing.into_bootloader(pty_firmware.port)


GOOD = FirmwareState(0.0, "Disarmed", "None", 0, (), 0, True, False, False, False)
ALIVE = {0: "Ok", 1: "NoEcho", 2: "Ok"}


def test_a_healthy_board_passes_its_self_test() -> None:
    findings = self_test(GOOD, Battery(0.0, 7.4, 7.4), ALIVE)
    assert all(finding.ok for finding in findings)
    assert len(findings) == 8


@pytest.mark.parametrize(
    ("change", "battery", "sonars", "name", "says"),
    [
        ({"state": "Latched", "cause": "Stall"}, 7.4, ALIVE, "state", "Latched, last stop: Stall"),
        ({"faults": ("SonarDead",)}, 7.4, ALIVE, "faults", "SonarDead"),
        ({"emergency_input": True}, 7.4, ALIVE, "emergency stop", "pressed"),
        ({"bumper": True}, 7.4, ALIVE, "bumper", "pressed, or a wire is off"),
        ({}, None, ALIVE, "battery", "not told"),
        ({}, 7.4, {0: "Ok", 1: "Ok"}, "sonar right", "says nothing"),
        ({}, 7.4, {**ALIVE, 1: "Dead"}, "sonar centre", "does not answer"),
    ],
)
def test_what_is_wrong_is_found_and_named(change, battery, sonars, name, says) -> None:
    told = None if battery is None else Battery(0.0, battery, battery)
    findings = self_test(dataclasses.replace(GOOD, **change), told, sonars)
    (wrong,) = [finding for finding in findings if not finding.ok]
    assert wrong.name == name
    assert says in wrong.detail
