"""The firmware's parameters over a link: all of them read at once, set by name, saved.

Names, units and ranges are those of `rover_protocol.parameters`, which is generated from the same description as the
firmware's own table.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rover_protocol import messages
from rover_protocol.parameters import PARAMETERS

from rover.errors import PreflightFailed
from rover.link.parameter_names import checked, named
from rover.link.session import STEP_S, Link
from rover.link.telemetry import ParameterValue

# Identifier in the answer to a ParameterCommand; the value is the command.
ALL = 0xFFFF
# Requests that are on their way at once: 6 bytes each, and answers of 12, on a wire that telemetry shares.
BURST = 12
PATIENCE_S = 3.0
REPEAT_S = 0.15
# A save takes the board up to 400 ms, in which it hears nothing.
SAVE_S = 1.5

COMMANDS = {
    "save": messages.PARAMETER_COMMAND_SAVE,
    "defaults": messages.PARAMETER_COMMAND_DEFAULTS,
    "load": messages.PARAMETER_COMMAND_LOAD,
}
WHY = {
    "UnknownParameter": "this firmware does not know it",
    "OutOfRange": "the firmware does not take that value",
    "RefusedWhileArmed": "the motors are on; nothing can be set then",
    "StorageError": "this board has nowhere to keep parameters",
}


def read_parameters(link: Link, names: Iterable[str] | None = None) -> dict[str, int]:
    """Values by name, in the order of the identifiers; without those that an older firmware does not know.

    Raises PreflightFailed when an answer does not come.
    """
    wanted = PARAMETERS if names is None else [named(name) for name in names]
    answers: dict[int, ParameterValue] = {}
    asked: dict[int, float] = {}
    start = link.clock.now()
    while missing := [each for each in wanted if each.identifier not in answers]:
        now = link.clock.now()
        if now - start > PATIENCE_S:
            raise PreflightFailed(f"the firmware does not answer for its parameter {missing[0].name}")
        for each in missing[:BURST]:
            if now - asked.get(each.identifier, -1.0) >= REPEAT_S:
                asked[each.identifier] = now
                link.request_parameter(each.identifier)
        link.clock.advance(now + STEP_S)
        answers |= {event.identifier: event for event in link.poll() if isinstance(event, ParameterValue)}
    return {each.name: answers[each.identifier].value for each in wanted if answers[each.identifier].status == "Ok"}


def write_parameters(link: Link, values: Mapping[str, int]) -> None:
    """Sets them in the board's memory, each answered. Raises BadInput, PreflightFailed with the firmware's reason."""
    for name, value in values.items():
        answer = link.set_parameter(named(name).identifier, checked(name, value))
        if answer.status != "Ok":
            raise PreflightFailed(f"{name} = {value}: {WHY.get(answer.status, answer.status)}")


def command_parameters(link: Link, command: str) -> None:
    """ "save", "defaults" or "load", and waits for its answer. Raises PreflightFailed."""
    number = COMMANDS[command]
    for _ in range(3):
        link.command_parameters(number)
        start = link.clock.now()
        while link.clock.now() - start < SAVE_S:
            link.clock.advance(link.clock.now() + STEP_S)
            for event in link.poll():
                if isinstance(event, ParameterValue) and event.identifier == ALL and event.value == number:
                    if event.status != "Ok":
                        raise PreflightFailed(f"parameters: {command}: {WHY.get(event.status, event.status)}")
                    return
    raise PreflightFailed(f"parameters: {command}: the firmware does not answer")
