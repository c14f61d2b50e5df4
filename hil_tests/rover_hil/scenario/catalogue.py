"""Every fault that a scenario can put in: where it can exist, what it takes, and what it is in the real world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

RIGS = ("sitl", "emulator", "device")
SIMULATED = ("sitl", "emulator")
TRANSPORTS = ("serial", "can")

DIRECTIONS = ("both", "to-firmware", "from-firmware")
WHEELS = ("left", "right")
SONARS = ("left", "centre", "right")
# Of a post that a scenario does not say more of.
POST_HEIGHT_M = 0.5


@dataclass(frozen=True)
class Number:
    """A number within bounds; `default` None means that it must be given."""

    doc: str
    low: float
    high: float
    default: float | None = None
    whole: bool = False


@dataclass(frozen=True)
class Word:
    """One of a few words."""

    doc: str
    choices: tuple[str, ...]
    default: str | None = None


@dataclass(frozen=True)
class Words:
    """A list of names of the protocol's messages; empty stands for all."""

    doc: str


@dataclass(frozen=True)
class Raw:
    """A table of raw values of a message."""

    doc: str


Parameter = Number | Word | Words | Raw


@dataclass(frozen=True)
class Fault:
    """`lasting`: it can end again after `duration_s`; `needs_mission`: a scripted drive does not notice it."""

    doc: str
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    rigs: tuple[str, ...] = SIMULATED
    transports: tuple[str, ...] = TRANSPORTS
    lasting: bool = True
    needs_mission: bool = False


DIRECTION = {"direction": Word("which way", DIRECTIONS, "both")}
MESSAGES = {"messages": Words("only these messages of the protocol; all when left out")}
WHEEL = {"wheel": Word("which wheel", WHEELS)}
SONAR = {"sensor": Word("which sensor", (*SONARS, "all"), "centre")}
REASON = {"reason": Number("echoed in cause_detail", 0, 255, 0, whole=True)}
ALL_RIGS = RIGS
SERIAL = ("serial",)
CAN = ("can",)

FAULTS: dict[str, Fault] = {
    # The wire.
    "serial-cut": Fault("the cable is out; nothing comes through", DIRECTION, ALL_RIGS, SERIAL),
    "bit-errors": Fault(
        "bits flip on the wire", {"rate": Number("share of bits", 0, 0.5), **DIRECTION}, ALL_RIGS, SERIAL
    ),
    "byte-loss": Fault(
        "bytes get lost on the wire", {"rate": Number("share of bytes", 0, 1), **DIRECTION}, ALL_RIGS, SERIAL
    ),
    "noise": Fault(
        "an open wire: random bytes between the frames",
        {"bytes_per_second": Number("how many", 1, 20_000), **DIRECTION},
        ALL_RIGS,
        SERIAL,
    ),
    "frame-loss": Fault(
        "whole frames get lost", {"rate": Number("share of frames", 0, 1), **MESSAGES, **DIRECTION}, ALL_RIGS
    ),
    "frame-delay": Fault(
        "frames to the firmware come late",
        {"delay_s": Number("seconds", 0.001, 10), **MESSAGES},
        ALL_RIGS,
    ),
    "frame-duplicate": Fault("frames to the firmware come twice", MESSAGES, ALL_RIGS),
    "frame-reorder": Fault("neighbouring frames to the firmware change places", MESSAGES, ALL_RIGS),
    "can-bus-off": Fault("the companion's controller has left the bus", {}, ALL_RIGS, CAN),
    # The companion.
    "companion-killed": Fault("the companion's process is gone", {}, ALL_RIGS, lasting=False),
    "companion-frozen": Fault("the companion's process does not run for a while", {}, ALL_RIGS),
    "motion-stops": Fault("the companion lives but plans nothing more: no segments follow", {}, ALL_RIGS),
    "keep-alive-stuck": Fault("a keep-alive that always repeats the same counter", {}, ALL_RIGS),
    "host-clock-jump": Fault(
        "the companion's clock jumps", {"jump_s": Number("seconds, forwards or back", -60, 60)}, ALL_RIGS, lasting=False
    ),
    "wrong-schema": Fault(
        "one side was built from another rover.dbc",
        {"side": Word("which side", ("companion", "firmware"), "companion")},
        ALL_RIGS,
    ),
    # Commands, right and wrong.
    "stop-command": Fault("Stop comes", REASON, ALL_RIGS, lasting=False),
    "emergency-stop-command": Fault("EmergencyStop comes", REASON, ALL_RIGS, lasting=False),
    "disarm-command": Fault("Disarm comes", REASON, ALL_RIGS, lasting=False),
    "arm-command": Fault(
        "a bare Arm comes, not through the companion's checks",
        {"token": Word("a new one, or the one that was seen last", ("new", "same"), "new")},
        ALL_RIGS,
        lasting=False,
    ),
    "re-arm": Fault("the operator arms again through the companion", {}, ALL_RIGS, lasting=False),
    "hello-command": Fault(
        "a Hello of a stranger comes",
        {"schema": Word("his schema", ("right", "wrong"), "wrong")},
        ALL_RIGS,
        lasting=False,
    ),
    "parameter-set": Fault(
        "ParameterSet comes",
        {
            "identifier": Number("number of the parameter, see docs/reference/protocol.md", 0, 65535, whole=True),
            "value": Number("in its own unit", -(2**31), 2**31 - 1, whole=True),
        },
        ALL_RIGS,
        lasting=False,
    ),
    "reboot-command": Fault("Reboot comes", {}, ALL_RIGS, lasting=False),
    "send": Fault(
        "any message of the protocol comes",
        {
            "message": Words("its name, in a list of one"),
            "values": Raw("raw values of its fields; fields left out are 0"),
            "count": Number("how often", 1, 1000, 1, whole=True),
        },
        ALL_RIGS,
        lasting=False,
    ),
    "send-segments": Fault(
        "segments come that the companion did not plan",
        {
            "count": Number("how many", 1, 200, 1, whole=True),
            "offset": Number("index of the first, counted from the one that the firmware expects", -300, 300, 0, True),
            "duration_ms": Number("of each", 0, 16_000, 100, whole=True),
            "jerk_travel": Number("m/s³", -8.3, 8.3, 0.0),
            "begin": Word("the first begins a run, in 0.1 s or a second ago", ("no", "soon", "past"), "no"),
            "rest": Word("each claims to end at rest", ("no", "yes"), "no"),
        },
        ALL_RIGS,
        lasting=False,
    ),
    # The board.
    "emergency-stop-input": Fault("the red button is pressed, and released after the duration", {}),
    "bumper-pressed": Fault("a switch of the bumper closes, with nothing there, and opens after the duration"),
    "firmware-hang": Fault(
        "the firmware's loop hangs until the watchdog resets the board", {}, SIMULATED, SERIAL, lasting=False
    ),
    "firmware-stall": Fault(
        "the control loop misses its ticks for a while, less than the watchdog's time", {}, SIMULATED
    ),
    "can-interrupt-shorted": Fault("INT of the CAN controller lies on ground", {}, ("emulator",), CAN),
    "brown-out": Fault("the board's supply dips: reset, and a start once it is back", {}, SIMULATED, SERIAL),
    # Wheels and motors.
    "encoder-stuck": Fault("an encoder gives no edges", WHEEL),
    "encoder-reversed": Fault("phases A and B of an encoder are exchanged", WHEEL),
    "encoders-swapped": Fault("the plugs of both encoders are exchanged"),
    "encoder-jump": Fault(
        "an encoder jumps",
        {**WHEEL, "counts": Number("how far", -100_000, 100_000, whole=True)},
        ("sitl",),
        lasting=False,
    ),
    "wheel-slip": Fault("a wheel slips on the ground", {**WHEEL, "share": Number("of its travel that is lost", -1, 1)}),
    "motor-stalled": Fault("a wheel is jammed", WHEEL),
    "motor-open": Fault("a motor wire is off", WHEEL),
    # Sonar and what stands before it.
    "sonar-dead": Fault("a sensor says nothing, not even a timeout", SONAR),
    "sonar-near": Fault("a sensor always sees something near", {**SONAR, "range_m": Number("metres", 0.02, 4)}),
    "sonar-deaf": Fault("a sensor never hears an echo", SONAR),
    "obstacle-ahead": Fault(
        "a post appears before the rover",
        {
            "distance_m": Number("from the footprint's edge to the post's near side", 0.02, 4),
            "radius_m": Number("of the post", 0.01, 0.5, 0.05),
            "bearing_deg": Number("to the left of straight ahead", -90, 90, 0),
            "height_m": Number("of the post; the sonars see over what is lower than 0.1 m", 0.01, 2, POST_HEIGHT_M),
        },
        lasting=False,
    ),
    "carried-away": Fault(
        "somebody lifts the rover and sets it down elsewhere; no wheel turns",
        {
            "ahead_m": Number("from where it was", -20, 20, 0),
            "left_m": Number("from where it was", -20, 20, 0),
            "turn_deg": Number("to the left", -180, 180, 0),
        },
        lasting=False,
        needs_mission=True,
    ),
    # Supply.
    "battery-sag": Fault("the battery gives less", {"drop_v": Number("volts", 0, 8)}),
    # The camera; these need the whole companion.
    "camera-frozen": Fault("new frames with the old picture", needs_mission=True),
    "camera-dead": Fault("no frames come", needs_mission=True),
    "camera-ffc": Fault("the shutter closes for a calibration", needs_mission=True),
    "operator-stop": Fault("the operator presses Ctrl-C at `rover run`", lasting=False, needs_mission=True),
}
# Faults for whole missions: of the world and of processes. Wire and commands belong to scripted drives.
IN_MISSIONS = (
    "companion-killed", "companion-frozen", "operator-stop", "camera-frozen", "camera-dead", "camera-ffc",
    "emergency-stop-input", "bumper-pressed", "firmware-hang", "firmware-stall", "brown-out", "encoder-stuck",
    "encoder-reversed", "encoders-swapped", "encoder-jump", "wheel-slip", "motor-stalled", "motor-open", "sonar-dead",
    "sonar-near", "sonar-deaf", "obstacle-ahead", "battery-sag", "carried-away",
)  # fmt: skip

OF_PROCESSES = ("companion-killed", "companion-frozen", "operator-stop")
# Faults of the rover and of what is around it: they need no companion that the rig knows.
OF_THE_WORLD = tuple(fault for fault in IN_MISSIONS if fault not in OF_PROCESSES)
