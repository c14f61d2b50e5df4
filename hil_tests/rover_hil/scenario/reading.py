"""From a scenario's TOML to its parts. Whatever is wrong is one line with file, key and what is to be done."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rover.errors import BadInput
from rover.toml_table import Table
from rover.vehicle import STANDARD
from rover_protocol import messages

from rover_hil.scenario import catalogue
from rover_hil.scenario.catalogue import FAULTS, Number, Raw, Word, Words
from rover_hil.scenario.checks import check_keys, read_checks
from rover_hil.scenario.condition import parse_condition
from rover_hil.scenario.language import (
    START,
    Drive,
    Expectation,
    Field,
    Injection,
    Move,
    ParameterValue,
    Prohibition,
    Scenario,
)

MAX_DURATION_S = 600.0
PLANT_SECTIONS = ("drive", "battery", "sonar", "camera")
TOP_KEYS = (
    *("name", "description", "rigs", "seed", "transport", "max_duration_s", "settle_s"),
    *("field", "drive", "parameters", "plant", "inject", "expect", "never", "end"),
)
DRIVE_KEYS = ("steps", "repeat", "speed", "arm", "disarm")
INJECT_KEYS = ("fault", "name", "at_s", "when", "after", "duration_s")
EXPECT_KEYS = ("name", "after", "within_s", "not_before_s", "from_s")
NEVER_KEYS = ("name", "after", "until")
FIELD_KEYS = ("width_m", "height_m", "launch", "obstacles")
# Metres and degrees beyond which a field's numbers make no sense.
MAX_COORDINATE_M = 1e4


def load_scenario(path: Path) -> Scenario:
    """Reads and checks one file. Raises BadInput."""
    return _scenario(Table.of_file(path).only(*TOP_KEYS))


def _scenario(top: Table) -> Scenario:
    rigs = top.choices("rigs", catalogue.RIGS)
    transport = top.choice("transport", catalogue.TRANSPORTS, "serial")
    drive, mission = _drive(top.table("drive"), transport)
    for section in ("field", "parameters", "plant"):
        if mission is not None and top.has(section):
            raise top.error(section, "has no meaning beside drive.mission: the mission's file says where it is")
    injections = [_injection(table, number, mission) for number, table in enumerate(top.tables("inject"), 1)]
    for table, injection in zip(top.tables("inject"), injections, strict=True):
        _check_possible(table, injection, rigs, transport)
    events = _names(top, injections)
    expectations = [_expectation(table, number, events) for number, table in enumerate(top.tables("expect"), 1)]
    if not expectations:
        raise top.error("expect", "missing: a scenario says what must be observed, and within which time")
    end = top.table("end").only(*check_keys(moved=True))
    if not end.has("state"):
        raise end.error("state", "missing: a scenario says in which state it ends")
    return Scenario(
        path=top.path,
        name=top.text("name"),
        description=top.text("description"),
        rigs=rigs,
        seed=top.integer("seed", 0, 2**32 - 1, 1),
        transport=transport,
        max_duration=top.number("max_duration_s", 0.5, MAX_DURATION_S, 20.0),
        settle=top.number("settle_s", 0.0, MAX_DURATION_S, 0.3),
        field=_field(top.table("field")),
        drive=drive,
        parameters=_parameters(top.table("parameters")),
        injections=tuple(injections),
        expectations=tuple(expectations),
        prohibitions=tuple(_prohibition(table, n, events) for n, table in enumerate(top.tables("never"), 1)),
        end=read_checks(end, moved=True),
        mission=mission,
        plant=_plant(top.table("plant")),
    )


def _drive(table: Table, transport: str) -> tuple[Drive, str | None]:
    if table.has("mission"):
        table.only("mission")
        if transport != "serial":
            raise table.error("mission", "is driven over serial: leave out transport")
        return Drive(), table.text("mission")
    table.only("mission", *DRIVE_KEYS)
    moves = [move for step in table.tables("steps") for move in _moves(step)]
    drive = Drive(
        tuple(moves) * table.integer("repeat", 1, 1000, 1),
        table.number("speed", 0.02, 0.45, 0.25),
        table.flag("arm", True),
        table.flag("disarm", False),
    )
    if drive.moves and not drive.arm:
        raise table.error("arm", "is false, and nothing drives unarmed: leave out the steps")
    return drive, None


def _moves(step: Table) -> list[Move]:
    bounds = {"forward_m": 20.0, "turn_deg": 3600.0, "pause_s": 60.0}
    moves = [Move(key, step.number(key, -most, most)) for key, most in bounds.items() if step.has(key)]
    if len(moves) != 1 or len(step.names()) != 1:
        forms = "{ forward_m = … }, { turn_deg = … }, { pause_s = … }"
        raise BadInput(f"{step.path}: [{step.name}] must be one of {forms}")
    if moves[0].kind == "pause_s" and moves[0].amount <= 0.0:
        raise step.error("pause_s", "must be positive")
    return moves if moves[0].amount else []


def _injection(table: Table, number: int, mission: str | None) -> Injection:
    fault = table.choice("fault", tuple(FAULTS))
    kind = FAULTS[fault]
    table.only(*INJECT_KEYS, *kind.parameters)
    if kind.needs_mission and mission is None:
        raise table.error("fault", f"{fault!r}: a scripted drive does not notice it, give drive.mission")
    if mission is not None and fault not in catalogue.IN_MISSIONS:
        known = ", ".join(catalogue.IN_MISSIONS)
        raise table.error("fault", f"{fault!r}, which is for scripted drives; in a mission there is {known}")
    at = table.number("at_s", 0.0, MAX_DURATION_S) if table.has("at_s") else None
    when = table.text("when") if table.has("when") else None
    after = table.text("after") if table.has("after") else None
    if when is not None and (at is not None or after is not None):
        raise table.error("when", "stands beside at_s or after: give one or the other")
    duration = table.number("duration_s", 0.001, MAX_DURATION_S) if table.has("duration_s") else None
    if duration is not None and not kind.lasting:
        raise table.error("duration_s", f"has no meaning: {fault} happens once")
    return Injection(
        name=table.text("name", fault if number == 1 else f"{fault}-{number}"),
        fault=fault,
        at=at,
        when=_condition(table, when) if when is not None else None,
        when_text=when or "",
        after=after,
        duration=duration,
        parameters={name: _parameter(table, name, spec) for name, spec in kind.parameters.items()},
    )


def read_fault(table: Table, faults: Sequence[str], rig: str, transport: str) -> Injection:
    """A fault that begins now, in the words of an `[[inject]]` without its time. Raises BadInput."""
    fault = table.choice("fault", faults)
    kind = FAULTS[fault]
    lasting = ("duration_s",) if kind.lasting else ()
    table.only("fault", "name", *lasting, *kind.parameters)
    injection = Injection(
        name=table.text("name", fault),
        fault=fault,
        at=None,
        when=None,
        when_text="",
        after=None,
        duration=table.number("duration_s", 0.001, MAX_DURATION_S) if table.has("duration_s") else None,
        parameters={name: _parameter(table, name, spec) for name, spec in kind.parameters.items()},
    )
    _check_possible(table, injection, (rig,), transport)
    return injection


def _condition(table: Table, text: str) -> Any:
    try:
        return parse_condition(text)
    except BadInput as error:
        raise table.error("when", str(error)) from error


def _parameter(table: Table, name: str, spec: catalogue.Parameter) -> ParameterValue:
    match spec:
        case Word(choices=choices, default=default):
            return table.choice(name, choices, default)
        case Number() as number:
            low, high = number.low, number.high
            if number.whole and table.has(name):
                return table.integer(name, int(low), int(high))
            return table.number(name, low, high, number.default)
        case Words():
            return table.choices(name, tuple(messages.BY_NAME), ())
        case Raw():
            values = table.table(name)
            return {key: values.integer(key, -(2**63), 2**64 - 1) for key in values.names()}
    raise AssertionError(spec)


def _check_possible(table: Table, injection: Injection, rigs: tuple[str, ...], transport: str) -> None:
    kind = FAULTS[injection.fault]
    impossible = [rig for rig in rigs if rig not in kind.rigs]
    if impossible:
        raise table.error("fault", f"{injection.fault!r} can't exist on {impossible[0]}: take that out of rigs")
    if transport not in kind.transports:
        raise table.error("fault", f"{injection.fault!r} does not exist on transport {transport!r}")
    if injection.fault == "send":
        _check_message(table, injection)


def _check_message(table: Table, injection: Injection) -> None:
    names, values = injection.parameters["message"], injection.parameters["values"]
    assert isinstance(names, tuple)
    assert isinstance(values, dict)
    if len(names) != 1:
        raise table.error("message", "must be a list with the name of one message")
    message = messages.BY_NAME[str(names[0])]
    known = list(message.FIELDS)
    for key in values:
        if key not in known:
            raise table.error(f"values.{key}", f"is no field of {message.name}; it has {', '.join(known)}")
    try:
        message.pack(**{name: values.get(name, 0) for name in known})
    except ValueError as error:
        raise table.error("values", str(error)) from None


def _names(top: Table, injections: list[Injection]) -> list[str]:
    names = [START]
    for table, injection in zip(top.tables("inject"), injections, strict=True):
        if injection.name in names:
            raise table.error("name", f"{injection.name!r} is taken")
        if injection.after is not None and injection.after not in names:
            raise table.error("after", f"{injection.after!r} is not one of those before this: {', '.join(names)}")
        names.append(injection.name)
    return names


def _after(table: Table, events: list[str]) -> str:
    # Without a word about it, the fault is what one waits for.
    return table.choice("after", events, events[1] if len(events) > 1 else START)


def _expectation(table: Table, number: int, events: list[str]) -> Expectation:
    table.only(*EXPECT_KEYS, *check_keys(moved=True))
    expectation = Expectation(
        name=table.text("name", f"expect-{number}"),
        after=_after(table, events),
        within=table.number("within_s", 0.001, MAX_DURATION_S),
        not_before=table.number("not_before_s", 0.0, MAX_DURATION_S, 0.0),
        begin=table.number("from_s", 0.0, MAX_DURATION_S, 0.0),
        checks=read_checks(table, moved=True),
    )
    if not expectation.checks:
        raise BadInput(f"{table.path}: [{table.name}] expects nothing: give state, cause, stopped, condition, …")
    for key, value in (("not_before_s", expectation.not_before), ("from_s", expectation.begin)):
        if value >= expectation.within:
            raise table.error(key, "must be less than within_s")
    if expectation.name in events:
        raise table.error("name", f"{expectation.name!r} is taken")
    events.append(expectation.name)
    return expectation


def _prohibition(table: Table, number: int, events: list[str]) -> Prohibition:
    table.only(*NEVER_KEYS, *check_keys(moved=False))
    checks = read_checks(table, moved=False)
    name, after = table.text("name", f"never-{number}"), _after(table, events)
    until = table.choice("until", events) if table.has("until") else None
    if len(checks) != 1:
        raise BadInput(f"{table.path}: [{table.name}] must hold one thing that never happens, it holds {len(checks)}")
    return Prohibition(name, after, until, checks[0])


def _field(table: Table) -> Field:
    default = Field()
    table.only(*FIELD_KEYS)
    circles = table.rows("obstacles", ("x", "y", "radius"), -MAX_COORDINATE_M, MAX_COORDINATE_M)
    x, y, heading = table.row("launch", ("x", "y", "heading"), -MAX_COORDINATE_M, MAX_COORDINATE_M, default.launch)
    ground = Field(
        table.number("width_m", 0.6, 50.0, default.width),
        table.number("height_m", 0.6, 50.0, default.height),
        (x, y, heading),
        tuple((x, y, radius) for x, y, radius in circles),
    )
    radius = STANDARD.radius
    if not (radius <= x <= ground.width - radius and radius <= y <= ground.height - radius):
        raise table.error("launch", f"lies nearer than the rover's radius of {radius:g} m to the bounds: {x:g}, {y:g}")
    return ground


def _parameters(table: Table) -> dict[str, int]:
    values = {key: table.integer(key, -(2**31), 2**31 - 1) for key in table.names()}
    for key in values:
        if not key.isdigit() or not 0 < int(key) < 65_535:
            raise table.error(key, "must be the number of a parameter, see docs/reference/protocol.md")
    return values


def _plant(table: Table) -> dict[str, dict[str, float]]:
    plant: dict[str, dict[str, float]] = {}
    for section in table.only(*PLANT_SECTIONS).names():
        inner = table.table(section)
        plant[section] = {key: inner.number(key, -1e12, 1e12) for key in inner.names()}
    return plant
