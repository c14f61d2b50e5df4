"""Listens to what the firmware says before any fault of the wire can touch it, and keeps the newest of each value."""

from __future__ import annotations

from rover_protocol import framing, messages

# First seven bytes of the line that the firmware logs when it has booted.
READY = b"rover f"

NO_ECHO_M = 65.535


class Probe:
    """Values by the names of `observation.py`, and events in words."""

    def __init__(self) -> None:
        self.values: dict[str, float | str | bool] = {
            "state": "Boot",
            "cause": "None",
            "reset_cause": "Unknown",
            "parameter_status": "None",
            "sonar_m": NO_ECHO_M,
            "boots": 0.0,
        }
        self.events: list[tuple[float, str]] = []
        self.arm_token = 0
        self._decoder = framing.Decoder()

    def feed(self, time: float, data: bytes) -> None:
        """Bytes of the serial line, the last of which came at `time`."""
        for identifier, _, payload in self._decoder.feed(data):
            self.take(time, identifier, payload)

    def take(self, time: float, identifier: int, payload: bytes) -> None:
        """One frame."""
        try:
            message, values = messages.decode(identifier, payload)
        except ValueError:
            return
        raw = {key: value for key, value in values.items() if isinstance(value, int)}
        match message.name:
            case "State":
                self._state(time, raw)
            case "MotionStatus":
                self.values.update(queued=raw["queued"], next_index=raw["next_index"], rejected=raw["rejected"])
            case "Fault":
                name = messages.VALUES["Fault"]["code"].get(raw["code"], str(raw["code"]))
                self.values[f"count.{name}"] = raw["count"]
                begun = "" if raw["active"] else " (over)"
                self.events.append((time, f"firmware: fault {name}{begun}, count {raw['count']}"))
            case "Velocity":
                self.values["commanded_speed"] = raw["reference_travel"] * 1e-4
                self.values["commanded_turn_rate"] = raw["reference_heading"] * 1e-3
            case "LinkStatistics":
                for key in ("lost", "checksum_errors", "malformed"):
                    self.values[key] = raw[key]
            case "Sonar":
                if raw["sensor"] == 1:
                    self.values["sonar_m"] = raw["range"] * 1e-3
            case "ParameterValue":
                self.values["parameter_status"] = messages.VALUES["ParameterValue"]["status"][raw["status"]]
            case "HelloBuild":
                self.values["reset_cause"] = messages.VALUES["HelloBuild"]["reset_cause"][raw["reset_cause"]]
            case "LogText":
                if raw["offset"] == 0 and values["text"] == READY:
                    self.values["boots"] = float(self.values["boots"]) + 1.0
                    self.events.append((time, "firmware: booted"))

    def _state(self, time: float, raw: dict[str, int]) -> None:
        state = messages.VALUES["State"]["state"][raw["state"]]
        cause = messages.VALUES["State"]["cause"][raw["cause"]]
        if (state, cause) != (self.values["state"], self.values["cause"]):
            self.events.append((time, f"firmware: {state}" + (f", {cause}" if cause != "None" else "")))
        self.arm_token = raw["arm_token"]
        self.values.update(
            state=state,
            cause=cause,
            cause_detail=float(raw["cause_detail"]),
            handshake=bool(raw["flags"] & 1),
            emergency_input=bool(raw["flags"] & 2),
            bumper=bool(raw["flags"] & 32),
        )
        for code, name in messages.VALUES["Fault"]["code"].items():
            self.values[f"fault.{name}"] = bool(raw["faults"] >> code & 1)
