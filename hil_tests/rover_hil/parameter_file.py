"""Firmware parameters that are not at their defaults: a parameter file for rover-sitl, written by rover-sitl itself."""

from __future__ import annotations

from pathlib import Path

from rover.errors import BadInput, PreflightFailed
from rover.link.baud import DEFAULT_BAUD
from rover.vehicle import Vehicle
from rover_protocol import framing, messages, parameters
from rover_protocol.rig_tick import TickReply, TickRequest

from rover_hil.firmware_process import FirmwareProcess

TICKS_EACH = 100
BOOT_TICKS = 50
BATTERY_MV = 7400
STATUS = messages.VALUES["ParameterValue"]["status"]


def parse_setting(text: str) -> tuple[int, int]:
    """`NAME=VALUE` or `NUMBER=VALUE`. Raises BadInput."""
    key, _, value = text.partition("=")
    known = parameters.BY_NAME.get(key)
    if known is None and not key.isdigit():
        raise BadInput(f"--set {text}: no parameter {key!r}; there is {', '.join(parameters.BY_NAME)}")
    try:
        return int(key) if known is None else known.identifier, int(value)
    except ValueError:
        raise BadInput(f"--set {text}: a whole number is expected after the =, in the parameter's own unit") from None


def settings_of(vehicle: Vehicle) -> dict[int, int]:
    """By number, the parameters that the vehicle's firmware must not have at their defaults."""
    values = vehicle.parameters()
    return {
        known.identifier: values[known.name] for known in parameters.PARAMETERS if values[known.name] != known.default
    }


def write_parameter_file(command: list[str], file: Path, settings: dict[int, int]) -> None:
    """Has the firmware set and save these parameters in `file`. Raises BadInput with its answer when it refuses."""
    process = FirmwareProcess([*command, "--parameters", str(file)], DEFAULT_BAUD)
    decoder = framing.Decoder()
    sequence = now_us = due = sent = 0

    def exchange(name: str, ticks: int, **fields: int) -> dict[str, int]:
        nonlocal sequence, now_us, due, sent
        frame = b""
        if name:
            message = messages.BY_NAME[name]
            frame = framing.encode(message.ID, sequence, message.pack(**fields))
            sequence = (sequence + 1) & 255
        process.send(frame)
        due += len(frame)
        answer: dict[str, int] = {}
        for _ in range(ticks):
            now_us += 1000
            process.stdin.write(TickRequest(now_us=now_us, battery_mv=BATTERY_MV, host_bytes_due=due).pack())
            process.stdin.flush()
            reply = process.stdout.read(TickReply.SIZE)
            if len(reply) < TickReply.SIZE:
                raise PreflightFailed("rover-sitl has ended while its parameters were set")
            total = TickReply.unpack(reply).bytes_sent
            for identifier, _, payload in decoder.feed(process.receive(total - sent)):
                if identifier == messages.ParameterValue.ID:
                    answer = {key: int(value) for key, value in messages.decode(identifier, payload)[1].items()}
            sent = total
        return answer

    try:
        exchange("", BOOT_TICKS)
        for identifier, value in settings.items():
            answer = exchange("ParameterSet", TICKS_EACH, identifier=identifier, value=value)
            if not answer or answer["status"] != 0:
                why = STATUS.get(answer.get("status", -1), "no answer")
                raise BadInput(f"--set {identifier}={value}: the firmware does not take it: {why}")
        saved = exchange("ParameterCommand", TICKS_EACH, command=messages.PARAMETER_COMMAND_SAVE)
        if not saved or saved["status"] != 0:
            raise PreflightFailed(f"rover-sitl could not save its parameters in {file}")
    finally:
        process.close()
