"""What the firmware tells, as typed values in SI units with times of the companion's clock."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rover_protocol import messages

from rover.link.clock_estimate import ClockEstimate
from rover.link.unwrap import unwrap


@dataclass(frozen=True)
class WheelMotion:
    """Encoder counts since the link came up, unwrapped, at `time`."""

    time: float
    left_counts: int
    right_counts: int


@dataclass(frozen=True)
class Turned:
    """What the gyroscope has turned by, radians, unwrapped: only differences mean anything. rate: radians a second."""

    time: float
    heading: float
    rate: float


@dataclass(frozen=True)
class Gravity:
    """The vertical on base_link, m/s². shake: greatest difference of what was felt since the last one, m/s².

    status: "Settling" until the gyroscope's bias is known, "Good", or "Lost".
    """

    time: float
    x: float
    y: float
    z: float
    shake: float
    status: str


@dataclass(frozen=True)
class SonarRange:
    """One ranging: sensor 0 left, 1 centre, 2 right; `status` "Ok", "NoEcho" or "Dead"; `range_m` None unless Ok."""

    time: float
    sensor: int
    range_m: float | None
    status: str


@dataclass(frozen=True)
class FirmwareState:
    """The firmware's heartbeat. `cause` says why it last stopped; `faults` names the active ones."""

    time: float
    state: str
    cause: str
    cause_detail: int
    faults: tuple[str, ...]
    arm_token: int
    handshake_done: bool
    emergency_input: bool
    moving: bool
    powered: bool
    bumper: bool = False


@dataclass(frozen=True)
class Battery:
    """Volts; `minimum` is the lowest since boot."""

    time: float
    voltage: float
    minimum: float


@dataclass(frozen=True)
class Velocity:
    """Reference and measured speed along (m/s) and about (rad/s)."""

    time: float
    reference_travel: float
    reference_heading: float
    measured_travel: float
    measured_heading: float


@dataclass(frozen=True)
class Odometry:
    """The firmware's own dead reckoning since boot: metres, radians (unwrapped)."""

    time: float
    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class ReferenceDistance:
    """Where along the commanded motion the firmware is: sums since boot, metres and radians."""

    time: float
    travel: float
    heading: float


@dataclass(frozen=True)
class MotionStatus:
    """Acknowledgement of segments; indexes as on the wire."""

    time: float
    next_index: int
    free_slots: int
    queued: int
    executing: int
    rejected: int


@dataclass(frozen=True)
class MotorDuty:
    """Duty of both motors, -1 to 1."""

    time: float
    left: float
    right: float


@dataclass(frozen=True)
class FaultReport:
    """A fault has come or its counter has changed."""

    time: float
    code: str
    active: bool
    count: int
    detail: int


@dataclass(frozen=True)
class LinkQuality:
    """What the firmware's receiver has seen since boot."""

    time: float
    frames: int
    checksum_errors: int
    malformed: int
    lost: int


@dataclass(frozen=True)
class LogLine:
    """A line of text from the firmware."""

    time: float
    text: str


@dataclass(frozen=True)
class ParameterValue:
    """Answer to a parameter request; `status` as named in the DBC."""

    time: float
    identifier: int
    value: int
    status: str


@dataclass(frozen=True)
class CrashPiece:
    """A part of the answer to CrashRequest, as it came: CrashCause, CrashTime or CrashEvent."""

    time: float
    name: str
    fields: dict[str, int]


Telemetry = (
    WheelMotion | Turned | Gravity | SonarRange | FirmwareState | Battery | Velocity | Odometry | ReferenceDistance
    | MotionStatus | MotorDuty | FaultReport | LinkQuality | LogLine | ParameterValue | CrashPiece
)  # fmt: skip


CRASH_PIECES = ("CrashCause", "CrashTime", "CrashEvent")


def fault_names(bits: int) -> tuple[str, ...]:
    """Names of the bits set in State.faults: bit n is fault code n."""
    return tuple(_name("Fault", "code", code) for code in range(16) if bits >> code & 1)


class TelemetryReader:
    """Turns raw fields into telemetry; remembers what a single message does not hold (wraps, halves, pieces)."""

    def __init__(self, clock: ClockEstimate) -> None:
        self._clock = clock
        self._left = 0
        self._right = 0
        self._position: tuple[int, int] | None = None
        self._heading = 0
        self._commanded_heading = 0
        self._turned = 0
        self._text = bytearray()

    def read(self, name: str, raw: dict[str, int | bytes], received: float) -> Telemetry | None:
        """The telemetry that message `name` completes, or None; `received` is companion time."""
        if name in CRASH_PIECES:
            return CrashPiece(received, name, {key: int(value) for key, value in raw.items()})
        if name == "LogText":
            return self._log_text(int(raw["offset"]), bytes(raw["text"]), received)
        values: dict[str, int] = {key: int(value) for key, value in raw.items()}
        builder = _BUILDERS.get(name)
        return builder(self, values, received) if builder is not None else None

    def _wheels(self, raw: dict[str, int], received: float) -> WheelMotion:
        self._left = unwrap(raw["left"], 24, self._left)
        self._right = unwrap(raw["right"], 24, self._right)
        time = self._clock.stamp(raw["time"], received, unit_us=1000, bits=16)
        return WheelMotion(time, self._left, self._right)

    def _turn(self, raw: dict[str, int], received: float) -> Turned:
        self._turned = unwrap(raw["heading"], 32, self._turned)
        time = self._clock.stamp(raw["time"], received, unit_us=1000, bits=16)
        return Turned(time, self._turned * 1e-6, raw["rate"] * 1e-3)

    def _gravity(self, raw: dict[str, int], received: float) -> Gravity:
        x, y, z = (raw[axis] * 1e-3 for axis in "xyz")
        return Gravity(received, x, y, z, raw["shake"] * 0.1, _name("Gravity", "status", raw["status"]))

    def _sonar(self, raw: dict[str, int], received: float) -> SonarRange:
        status = _name("Sonar", "status", raw["status"])
        distance = raw["range"] * 1e-3 if status == "Ok" else None
        return SonarRange(self._clock.stamp(raw["time"], received), raw["sensor"], distance, status)

    def _state(self, raw: dict[str, int], received: float) -> FirmwareState:
        flags = raw["flags"]
        return FirmwareState(
            time=received,
            state=_name("State", "state", raw["state"]),
            cause=_name("State", "cause", raw["cause"]),
            cause_detail=raw["cause_detail"],
            faults=fault_names(raw["faults"]),
            arm_token=raw["arm_token"],
            handshake_done=bool(flags & 1),
            emergency_input=bool(flags & 2),
            moving=bool(flags & 4),
            powered=bool(flags & 8),
            bumper=bool(flags & 32),
        )

    def _battery(self, raw: dict[str, int], received: float) -> Battery:
        return Battery(received, raw["voltage"] * 1e-3, raw["minimum"] * 1e-3)

    def _velocity(self, raw: dict[str, int], received: float) -> Velocity:
        return Velocity(
            received,
            raw["reference_travel"] * 1e-4,
            raw["reference_heading"] * 1e-3,
            raw["measured_travel"] * 1e-4,
            raw["measured_heading"] * 1e-3,
        )

    def _odometry_position(self, raw: dict[str, int], received: float) -> Telemetry | None:
        self._position = (raw["x"], raw["y"])
        return None

    def _odometry_heading(self, raw: dict[str, int], received: float) -> Odometry | None:
        if self._position is None:
            return None
        x, y = self._position
        self._heading = unwrap(raw["heading"], 32, self._heading)
        return Odometry(self._clock.stamp(raw["time"], received), x * 1e-5, y * 1e-5, self._heading * 1e-6)

    def _reference(self, raw: dict[str, int], received: float) -> ReferenceDistance:
        self._commanded_heading = unwrap(raw["heading"], 32, self._commanded_heading)
        return ReferenceDistance(received, raw["travel"] * 1e-5, self._commanded_heading * 1e-6)

    def _motion(self, raw: dict[str, int], received: float) -> MotionStatus:
        return MotionStatus(received, **raw)

    def _duty(self, raw: dict[str, int], received: float) -> MotorDuty:
        return MotorDuty(received, raw["left"] / 32768.0, raw["right"] / 32768.0)

    def _fault(self, raw: dict[str, int], received: float) -> FaultReport:
        code = _name("Fault", "code", raw["code"])
        return FaultReport(received, code, raw["active"] != 0, raw["count"], raw["detail"])

    def _quality(self, raw: dict[str, int], received: float) -> LinkQuality:
        return LinkQuality(received, **raw)

    def _parameter(self, raw: dict[str, int], received: float) -> ParameterValue:
        status = _name("ParameterValue", "status", raw["status"])
        return ParameterValue(received, raw["identifier"], raw["value"], status)

    def _log_text(self, offset: int, text: bytes, received: float) -> LogLine | None:
        if offset == 0:
            self._text.clear()
        if offset != len(self._text):
            return None  # a piece before this one is lost: the line cannot be whole
        end = text.find(0)
        self._text += text if end < 0 else text[:end]
        if end < 0:
            return None
        line = self._text.decode("utf-8", errors="replace")
        self._text.clear()
        return LogLine(received, line)


_BUILDERS: dict[str, Callable[[TelemetryReader, dict[str, int], float], Telemetry | None]] = {
    "WheelTicks": TelemetryReader._wheels,
    "InertialHeading": TelemetryReader._turn,
    "Gravity": TelemetryReader._gravity,
    "Sonar": TelemetryReader._sonar,
    "State": TelemetryReader._state,
    "Battery": TelemetryReader._battery,
    "Velocity": TelemetryReader._velocity,
    "OdometryPosition": TelemetryReader._odometry_position,
    "OdometryHeading": TelemetryReader._odometry_heading,
    "ReferenceDistance": TelemetryReader._reference,
    "MotionStatus": TelemetryReader._motion,
    "MotorDuty": TelemetryReader._duty,
    "Fault": TelemetryReader._fault,
    "LinkStatistics": TelemetryReader._quality,
    "ParameterValue": TelemetryReader._parameter,
}


def _name(message: str, field: str, raw: int) -> str:
    """Name of a value in the DBC; a number that this version does not know stays readable."""
    return messages.VALUES[message][field].get(raw, f"Unknown{raw}")
