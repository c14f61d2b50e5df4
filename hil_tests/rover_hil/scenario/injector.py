"""Puts faults in and takes them out: each goes to the part that it belongs to."""

from __future__ import annotations

from collections.abc import Callable

from rover.motion.segment import FLAG_BEGIN, FLAG_REST
from rover_plant import Plant
from rover_protocol import messages

from rover_hil.scenario.board_faults import FaultyRig
from rover_hil.scenario.driver import Companion
from rover_hil.scenario.host import Host
from rover_hil.scenario.language import Injection
from rover_hil.scenario.probe import Probe
from rover_hil.scenario.wire_faults import FLIP, WireFaults
from rover_hil.scenario.world_faults import WorldFaults

ON_THE_WIRE = (
    "serial-cut", "bit-errors", "byte-loss", "noise", "frame-loss", "frame-delay", "frame-duplicate", "frame-reorder",
    "can-bus-off", "keep-alive-stuck", "wrong-schema",
)  # fmt: skip
RESTART = 0x5242_4F54


class Injector:
    """Knows every part of a run."""

    def __init__(
        self, plant: Plant, rig: FaultyRig, wire: WireFaults, host: Host, companion: Companion, probe: Probe
    ) -> None:
        self._world = WorldFaults(plant, rig)
        self._wire = wire
        self._host = host
        self._companion = companion
        self._probe = probe

    def begin(self, injection: Injection) -> None:
        """The fault begins."""
        if injection.fault in ON_THE_WIRE:
            self._wire.begin(injection)
        else:
            self._switch(injection, True)

    def end(self, injection: Injection) -> None:
        """A lasting fault is over."""
        if injection.fault in ON_THE_WIRE:
            self._wire.end(injection)
        else:
            self._switch(injection, False)

    def _switch(self, injection: Injection, on: bool) -> None:
        if self._world.switch(injection, on):
            return
        if injection.fault == "companion-frozen":
            self._host.frozen = on
        elif injection.fault == "motion-stops":
            self._companion.hold = on
        elif on:
            self._once(injection)

    def _once(self, injection: Injection) -> None:
        actions: dict[str, Callable[[Injection], None]] = {
            "companion-killed": lambda i: self._host.kill(),
            "host-clock-jump": lambda i: self._host.jump(i.number("jump_s")),
            "stop-command": lambda i: self._companion.link.stop(int(i.number("reason"))),
            "emergency-stop-command": lambda i: self._companion.link.emergency_stop(int(i.number("reason"))),
            "disarm-command": lambda i: self._send("Disarm"),
            "arm-command": self._arm,
            "re-arm": lambda i: setattr(self._companion, "re_arm", True),
            "hello-command": self._hello,
            "parameter-set": lambda i: self._send(
                "ParameterSet", identifier=int(i.number("identifier")), value=int(i.number("value"))
            ),
            "reboot-command": lambda i: self._send(
                "Reboot", magic=RESTART, session=self._companion.link.session_number
            ),
            "send": self._raw,
            "send-segments": self._segments,
        }
        actions[injection.fault](injection)

    def _send(self, name: str, **raw: int) -> None:
        self._companion.link.wire.send(name, self._host.now(), **raw)

    def _arm(self, injection: Injection) -> None:
        step = 1 if injection.parameters["token"] == "new" else 0
        token = (self._probe.arm_token + step) & 0xFFFF
        self._send("Arm", token=token, session=self._companion.link.session_number)

    def _hello(self, injection: Injection) -> None:
        flip = FLIP if injection.parameters["schema"] == "wrong" else 0
        self._send("Hello", schema_hash=messages.SCHEMA_HASH ^ flip, session=0xBAD)

    def _raw(self, injection: Injection) -> None:
        names, values = injection.parameters["message"], injection.parameters["values"]
        assert isinstance(names, tuple)
        assert isinstance(values, dict)
        message = messages.BY_NAME[str(names[0])]
        for _ in range(int(injection.number("count"))):
            self._send(message.name, **{name: values.get(name, 0) for name in message.FIELDS})

    def _segments(self, injection: Injection) -> None:
        first = int(float(self._probe.values.get("next_index", 0.0)) + injection.number("offset"))
        begin, rest = injection.parameters["begin"], injection.parameters["rest"] == "yes"
        if begin != "no":
            delay = 0.1 if begin == "soon" else -1.0
            start = self._companion.link.clock_estimate.to_firmware(self._host.now() + delay)
            self._send("SegmentStart", index=first & 0xFFFF, start_time=start & 0xFFFF_FFFF)
        for ahead in range(int(injection.number("count"))):
            index = (first + ahead) & 0xFFFF
            begins = begin != "no" and ahead == 0
            self._send(
                "SegmentTravel",
                index=index,
                duration=round(injection.number("duration_ms") * 1000.0),
                jerk_travel=round(injection.number("jerk_travel") * 1e6),
            )
            self._send("SegmentHeading", index=index, jerk_heading=0, flags=FLAG_BEGIN * begins | FLAG_REST * rest)
