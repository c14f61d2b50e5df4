"""The record of a firmware's last crash: asked for over the link, and cleared."""

from __future__ import annotations

from dataclasses import dataclass, field

from rover_protocol import messages

from rover.errors import PreflightFailed
from rover.link.session import STEP_S, Link
from rover.link.telemetry import CrashPiece

# Seconds for all of an answer: a piece comes each millisecond, and the slowest wire takes 20 ms for them.
ANSWER_S = 1.0
# Seconds after which it is asked again: erasing the page may keep the firmware for 0.4 s.
REPEAT_S = 0.5


@dataclass(frozen=True)
class CrashEvent:
    """Something that went before: seconds since the start, and what it was in words."""

    time_s: float
    text: str


@dataclass(frozen=True)
class Crash:
    """`cause` "Panic", "HardFault" or "Watchdog"; `task` that ran or had stopped; `line` of a panic, else None.

    `program_counter` is None when it is not known; of a panic it is the address of its place in the source
    (core::panic::Location). `events`: the last ones before it, the oldest first.
    """

    cause: str
    task: str
    program_counter: int | None
    line: int | None
    uptime_s: float
    stack_bytes: int
    events: tuple[CrashEvent, ...]


@dataclass
class _Answer:
    cause: dict[str, int] | None = None
    time: dict[str, int] | None = None
    events: dict[int, dict[str, int]] = field(default_factory=dict)

    @property
    def complete(self) -> bool:
        if self.cause is None:
            return False
        if self.cause["cause"] == messages.CRASH_CAUSE_NONE:
            return True
        return self.time is not None and len(self.events) >= self.time["events"]

    def take(self, piece: CrashPiece) -> None:
        if piece.name == "CrashCause":
            self.cause = piece.fields
        elif piece.name == "CrashTime":
            self.time = piece.fields
        else:
            self.events[piece.fields["index"]] = piece.fields


def read_crash(link: Link) -> Crash | None:
    """The last crash, None when there was none. Raises PreflightFailed when the firmware does not tell, LinkLost."""
    return _ask(link, messages.CRASH_REQUEST_COMMAND_READ)


def clear_crash(link: Link) -> None:
    """Forgets it. Raises PreflightFailed when the firmware does not, as while it is armed; LinkLost."""
    if _ask(link, messages.CRASH_REQUEST_COMMAND_CLEAR) is not None:
        raise PreflightFailed("the crash record is not cleared: that needs a disarmed rover")


def _ask(link: Link, command: int) -> Crash | None:
    answer = _Answer()
    clock = link.clock
    end = clock.now() + ANSWER_S
    due = clock.now()
    while not answer.complete:
        if clock.now() > end:
            raise PreflightFailed("the firmware does not tell its crash record")
        if clock.now() >= due:
            link.wire.send("CrashRequest", clock.now(), command=command)
            due = clock.now() + REPEAT_S
        for event in link.poll():
            if isinstance(event, CrashPiece):
                answer.take(event)
        clock.advance(clock.now() + STEP_S)
    return _crash(answer)


def _crash(answer: _Answer) -> Crash | None:
    cause, time = answer.cause, answer.time
    if cause is None or time is None:
        return None
    names = messages.VALUES["CrashCause"]
    panic = cause["cause"] == messages.CRASH_CAUSE_PANIC
    return Crash(
        cause=names["cause"].get(cause["cause"], f"Unknown{cause['cause']}"),
        task=names["task"].get(cause["task"], f"Unknown{cause['task']}"),
        program_counter=cause["program_counter"] or None,
        line=cause["detail"] if panic else None,
        uptime_s=time["uptime"] * 1e-3,
        stack_bytes=time["stack"],
        events=tuple(
            CrashEvent(event["time"] * 1e-3, _in_words(event["kind"], event["detail"]))
            for _, event in sorted(answer.events.items())
        ),
    )


def _in_words(kind: int, detail: int) -> str:
    values = messages.VALUES
    name = values["CrashEvent"]["kind"].get(kind, f"Unknown{kind}")
    if name == "Start":
        return f"Start: {values['HelloBuild']['reset_cause'].get(detail, detail)}"
    if name == "State":
        state = values["State"]["state"].get(detail & 0xFF, f"Unknown{detail & 0xFF}")
        return f"State: {state}, cause {values['State']['cause'].get(detail >> 8, f'Unknown{detail >> 8}')}"
    if name in ("Fault", "FaultOver"):
        return f"{name}: {values['Fault']['code'].get(detail, detail)}"
    return name
