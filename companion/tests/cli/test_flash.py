"""`rover flash` from a drive, and from a running rover: the sitl rig plays the board that comes up."""

from __future__ import annotations

import json
import threading
import time
from pathlib import Path

import pytest
from rover.cli import flash
from rover.link import boot_drive, flashing

from ..link.uf2_file import RP2350, marked_file, uf2_file
from ..link.uf2_file import boot_drive as mount


@pytest.fixture
def firmware(tmp_path) -> Path:
    return uf2_file(tmp_path / "rover-pico.uf2", 99)


@pytest.fixture
def mounts(tmp_path, monkeypatch) -> Path:
    """Where drives are looked for; no other board and no other rover is seen."""
    monkeypatch.setattr(boot_drive, "MOUNT_PATTERNS", (f"{tmp_path}/media/*",))
    monkeypatch.setattr(flashing, "rover_ports", list)
    monkeypatch.setattr(flashing, "has_probe", lambda: False)
    monkeypatch.setattr(flashing, "unmounted", lambda: None)
    media: Path = tmp_path / "media"
    return media


@pytest.fixture(scope="module")
def port(free_rig):
    return free_rig("serial")


def test_without_a_board_it_says_what_to_do(rover, mounts, firmware) -> None:
    result = rover("flash", "--file", firmware)
    assert result.code == 3
    for help_of in ("BOOTSEL", "--port", "probe-rs"):
        assert help_of in result.err
    assert result.err.count("\n") == 1


def test_a_folder_that_is_no_drive_is_said_to_be_none(rover, mounts, firmware, tmp_path) -> None:
    result = rover("flash", "--file", firmware, "--drive", tmp_path)
    assert result.code == 3
    assert "no INFO_UF2.TXT" in result.err


def test_a_file_that_is_no_firmware_is_bad_input(rover, mounts, tmp_path) -> None:
    (tmp_path / "x.uf2").write_bytes(b"nonsense")
    assert rover("flash", "--file", tmp_path / "x.uf2").code == 2


def test_a_firmware_for_another_board_is_bad_input(rover, mounts, firmware) -> None:
    mount(mounts / "RP2350", "RP2350", "Raspberry Pi RP2350")
    result = rover("flash", "--file", firmware)
    assert result.code == 2
    assert "is for RP2040, and the board" in result.err


def test_of_what_is_built_each_board_gets_its_own(rover, mounts, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(flash, "BUILT", tmp_path)
    monkeypatch.setattr(flashing, "_wait", lambda look, timeout: look())
    built = {
        "RPI-RP2": uf2_file(tmp_path / "rover-pico.uf2", 9),
        "RP2350": uf2_file(tmp_path / "rover-pico2.uf2", 9, RP2350),
    }
    for board, image in built.items():
        folder = mount(mounts / board, board)
        assert f"writing {image.name}," in rover("flash", "--drive", folder).err
        assert (folder / "rover.uf2").read_bytes() == image.read_bytes()


def test_when_nothing_comes_up_the_writing_is_told_of_all_the_same(rover, mounts, firmware, monkeypatch) -> None:
    mount(mounts / "RPI-RP2")
    monkeypatch.setattr(flashing, "_wait", lambda look, timeout: look())
    result = rover("flash", "--file", firmware)
    assert result.code == 3
    assert "is written, and no rover has come up on any USB port" in result.err


@pytest.fixture
def of_the_rig(rover, port, tmp_path) -> Path:
    """A file that says it is what answers on the rig."""
    answer = json.loads(rover("status", "--port", port, "--json").out)
    return marked_file(tmp_path / "rig.uf2", 0, int(answer["git_hash"], 16))


@pytest.mark.rig("sitl")
@pytest.mark.parametrize(("board", "flip", "says"), [(1, 0, "is for Rp2040, commit"), (0, 1, "is for Sitl, commit")])
def test_another_board_or_commit_that_answers_is_no_success(
    rover, mounts, of_the_rig, port, tmp_path, board, flip, says
) -> None:
    mount(mounts / "RPI-RP2")
    answer = json.loads(rover("status", "--port", port, "--json").out)
    other = marked_file(tmp_path / "other.uf2", board, int(answer["git_hash"], 16) ^ flip)
    result = rover("flash", "--file", other, "--port", port)
    assert result.code == 3
    assert says in result.err
    assert f"what answers on {port} is Sitl" in result.err


@pytest.mark.rig("sitl")
def test_a_file_that_does_not_say_who_it_is_proves_nothing(rover, mounts, firmware, port) -> None:
    mount(mounts / "RPI-RP2")
    result = rover("flash", "--file", firmware, "--port", port)
    assert result.code == 3
    assert "carries no mark" in result.err


@pytest.mark.rig("sitl")
def test_from_a_drive_to_the_self_test(rover, mounts, of_the_rig, port) -> None:
    firmware = of_the_rig
    folder = mount(mounts / "RPI-RP2")
    result = rover("flash", "--file", firmware, "--port", port, "--json")
    told = json.loads(result.out)
    assert result.code == 0, result.err
    assert (folder / "rover.uf2").read_bytes() == firmware.read_bytes()
    assert (told["board"], told["for"], told["written_to"]) == ("Sitl", "RP2040", str(folder))
    assert [each["name"] for each in told["self_test"] if each["ok"]] == [
        "state", "faults", "battery", "emergency stop", "bumper", "sonar left", "sonar centre", "sonar right",
    ]  # fmt: skip


@pytest.mark.rig("sitl")
def test_a_running_rover_is_told_to_start_its_boot_loader(rover, mounts, of_the_rig, port) -> None:
    """The drive comes a second after the reboot, as a desktop mounts it; the reset cause shows that there was one."""

    def boot_loader() -> None:
        time.sleep(1.5)
        mount(mounts / "RPI-RP2")

    thread = threading.Thread(target=boot_loader)
    thread.start()
    result = rover("flash", "--file", of_the_rig, "--port", port)
    thread.join()
    assert result.code == 0, result.err
    assert "telling the rover on" in result.err
    assert (mounts / "RPI-RP2" / "rover.uf2").exists()
    assert "sonar centre" in result.out
    status = json.loads(rover("status", "--port", port, "--json").out)
    assert status["reset_cause"] == "Software"
