"""What must hold before a real rover may set off: one finding for each thing, said in one line.

The firmware's self-test is judged more mildly than after flashing: a latch, or a fault that arming takes back, is told
and does not keep the rover from a new mission.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from rover.capture.frame import Frame
from rover.capture.latest import LatestFrames
from rover.capture.plausible import doubts
from rover.detection.hours import warning
from rover.errors import LinkLost, PreflightFailed, RoverError
from rover.link.clock import WallClock
from rover.link.frames import FrameTransport
from rover.link.inquiry import Told, listen
from rover.link.parameters import read_parameters
from rover.link.self_test import Finding, self_test
from rover.link.session import Link
from rover.link.words import MotorState
from rover.mission.config import Mission
from rover.mission.fault_desk import row_of
from rover.mission.fault_table import AtStart
from rover.vehicle import Vehicle
from rover.vehicle.difference import differences, left_from_a_bench
from rover.vision.camera.model import CameraModel

READY = (MotorState.BOOT, MotorState.DISARMED, MotorState.LATCHED)
MIN_PICTURES = 4
# Seconds for the first pictures; a Lepton takes up to three after power-on.
CAMERA_PATIENCE = 6.0

# Pictures a second below which the rover sees too little of what it drives past.
MIN_PICTURE_RATE = 4.0

# Seconds from exposure to here beyond which a picture is not of now.
MAX_PICTURE_AGE = 0.5

PICTURE_RATE = 9
# Of a log, telemetry and estimates: about twice what missions write.
LINK_BYTES_PER_SECOND = 100_000


class Wired(Protocol):
    """An open port, and the clock that it goes by."""

    @property
    def clock(self) -> WallClock: ...
    @property
    def wire(self) -> FrameTransport: ...


class Parts(Wired, Protocol):
    """What is open: port and camera."""

    @property
    def camera(self) -> LatestFrames: ...


@dataclass(frozen=True)
class Preflight:
    """All findings."""

    findings: tuple[Finding, ...]

    def require(self) -> None:
        """Raises PreflightFailed, naming what has failed."""
        failed = [finding.name for finding in self.findings if not finding.ok]
        if failed:
            raise PreflightFailed(f"pre-flight failed: {', '.join(failed)}; nothing has moved")


def preflight(
    parts: Parts,
    mission: Mission,
    camera: CameraModel,
    out: Path,
    session: int,
    on_finding: Callable[[Finding], None] = lambda _: None,
) -> Preflight:
    """Looks at everything, also after something has failed; `on_finding` is told each as it is known."""
    findings: list[Finding] = []
    checks = (
        look_at_firmware(parts, session, mission.rover.vehicle),
        look_at_camera(parts, camera),
        judge_hour(mission.time_of_day_s / 3600.0),
        iter([judge_disk(shutil.disk_usage(out).free, mission.max_duration_s, camera)]),
    )
    for check in checks:
        for finding in check:
            findings.append(finding)
            on_finding(finding)
    return Preflight(tuple(findings))


def look_at_firmware(parts: Wired, session: int, vehicle: Vehicle) -> Iterator[Finding]:
    """Handshake with its schema, then state, faults, battery, emergency stop and sonars, and the board's parameters."""
    link = Link(parts.wire, parts.clock, session)
    try:
        identity = link.connect()
        told = listen(link)
        board = read_parameters(link)
    except (PreflightFailed, LinkLost) as error:
        yield Finding("firmware", False, str(error))
        return
    yield Finding(
        "firmware", True,
        f"{identity.version} ({identity.git_hash}) on {identity.board}, schema {identity.schema_hash:08x}, "
        f"{link.wire.transport.port}",
    )  # fmt: skip
    yield from judge_firmware(told)
    yield judge_parameters(board, vehicle)


def judge_parameters(board: Mapping[str, int], vehicle: Vehicle) -> Finding:
    """The board's parameters against the vehicle file: all that differ are named, those that safety rests on refuse."""
    bench = left_from_a_bench(board)
    if bench:
        return Finding("vehicle", False, f"left from a bench: {'; '.join(bench)}: rover vehicle push puts it right")
    found = differences(vehicle.parameters(), board)
    if not found:
        return Finding("vehicle", True, "the board's parameters are those of the vehicle file")
    refused = any(each.safety for each in found)
    named = f"on the board {'; '.join(map(str, found))}"
    return Finding("vehicle", not refused, f"{named}: rover vehicle push makes them equal" if refused else named)


def judge_firmware(told: Told) -> list[Finding]:
    """The self-test's findings, with state and faults judged for a rover that may have driven before."""
    state = told.state
    standing = [fault for fault in state.faults if not _taken_back(fault)]
    faults = ", ".join(state.faults) + (
        "" if not state.faults else ": mend it, then switch the rover off and on" if standing else ": of the last drive"
    )
    judged = {
        "state": Finding("state", state.state in READY, f"{state.state}, last stop: {state.cause}"),
        "faults": Finding("faults", not standing, faults or "none"),
    }
    return [judged.get(finding.name, finding) for finding in self_test(state, told.battery, told.sonars)]


def _taken_back(fault: str) -> bool:
    row = row_of(fault)
    return row is not None and row.start is not AtStart.REFUSED


def look_at_camera(parts: Parts, camera: CameraModel) -> Iterator[Finding]:
    """Waits for a few pictures."""
    taken: list[Frame] = []
    arrived: list[float] = []
    begin = parts.clock.now()
    try:
        while len(taken) < MIN_PICTURES and parts.clock.now() - begin < CAMERA_PATIENCE:
            taken += parts.camera.take()
            arrived += [parts.clock.now()] * (len(taken) - len(arrived))
            parts.clock.advance(parts.clock.now() + 0.01)
    except RoverError as error:
        yield Finding("camera", False, str(error))
        return
    ages = [at + parts.clock.origin - frame.time for at, frame in zip(arrived, taken, strict=True)]
    yield judge_pictures(taken, ages, camera)


def judge_pictures(taken: list[Frame], ages: list[float], camera: CameraModel) -> Finding:
    """`ages`: seconds from the exposure of each picture to its arrival."""
    if len(taken) < MIN_PICTURES:
        return Finding("camera", False, f"{len(taken)} pictures within {CAMERA_PATIENCE:g} s")
    doubt = doubts(taken)
    width, height = taken[-1].size
    if (width, height) != (camera.width, camera.height):
        wanted = f"{camera.width}×{camera.height}"
        also = f"; it gives {doubt}" if doubt else ""
        return Finding("camera", False, f"gives {width}×{height}, the mission's {camera.name} has {wanted}{also}")
    if doubt is not None:
        return Finding("camera", False, f"gives no picture to go by: {doubt}")
    span = taken[-1].time - taken[0].time
    rate = (len(taken) - 1) / span if span > 0.0 else 0.0
    if rate < MIN_PICTURE_RATE:
        return Finding("camera", False, f"{rate:.1f} pictures a second, {MIN_PICTURE_RATE:g} are needed")
    if not 0.0 <= min(ages) <= MAX_PICTURE_AGE:
        return Finding("camera", False, f"its pictures are {min(ages):.2f} s old: its clock is not the system's")
    return Finding(
        "camera", True, f"{camera.name}, {width}×{height}, {rate:.1f} pictures a second, {min(ages) * 1e3:.0f} ms old"
    )


def judge_hour(hour: float) -> Iterator[Finding]:
    """A line where hardly any contrast is expected at the mission's hour: no reason to refuse, the operator decides."""
    poor = warning(hour)
    if poor:
        yield Finding("hour", True, poor)


def judge_disk(free: int, duration: float, camera: CameraModel) -> Finding:
    """Room for the log of the longest mission that the file allows; `free` in bytes, `duration` in seconds."""
    needed = duration * (2 * camera.width * camera.height * PICTURE_RATE + LINK_BYTES_PER_SECOND)
    return Finding("disk", free >= needed, f"{free / 1e6:.0f} MB free, the log may need {needed / 1e6:.0f} MB")
