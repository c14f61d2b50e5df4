"""Answers a companion's requests over the control socket: the rig's time moves only when the companion says so."""

from __future__ import annotations

import socket
from collections.abc import Callable
from typing import Any

from rover_hil import wire_format
from rover_hil.rig import RigFailed, RigFrame, SteppedRig

Finish = Callable[[list[dict[str, Any]], list[dict[str, Any]]], dict[str, Any]]
"""Takes zones and detections, writes the truth files, returns the verdict."""


class Session:
    """One companion on one rig."""

    def __init__(self, rig: SteppedRig, finish: Finish) -> None:
        self._rig = rig
        self._finish = finish
        self.finished = False

    def serve(self, connection: socket.socket) -> bool:
        """Answers until the companion goes; True when it had finished its mission. Raises RigFailed."""
        try:
            while True:
                self._answer(connection)
        except wire_format.ClientGone:
            return self.finished

    def _answer(self, connection: socket.socket) -> None:
        try:
            header, blob = self._reply(wire_format.receive(connection))
        except (ValueError, KeyError, TypeError) as error:
            what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
            header, blob = {"error": f"bad request: {what}"}, b""
        except RigFailed as failure:
            wire_format.send(connection, {"error": str(failure)})
            raise
        wire_format.send(connection, header, blob)

    def _reply(self, request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
        rig = self._rig
        match request.get("op"):
            case "hello":
                rig.begin_session()
                if request.get("record"):
                    rig.record()
                return {"now_us": rig.now_us, "rig": rig.name, "camera": rig.camera}, b""
            case "advance":
                step = rig.advance(int(request["to_us"]), int(request["host_bytes"]))
                frames = [self._describe(frame) for frame in step.frames]
                header = {"now_us": step.now_us, "marks": step.marks, "frames": frames}
                blob = b"".join(frame.counts for frame in step.frames)
                if step.ticks:
                    header["recorded"] = [len(step.ticks), len(step.to_firmware), len(step.from_firmware)]
                    blob += step.ticks + step.to_firmware + step.from_firmware
                return header, blob
            case "inputs":
                rig.set_emergency_stop(bool(request["emergency_stop"]))
                return {"now_us": rig.now_us}, b""
            case "finish":
                verdict = self._finish(request.get("zones", []), request.get("detections", []))
                self.finished = True
                return verdict, b""
            case other:
                raise ValueError(f"op {other!r} is not known: hello, advance, inputs or finish")

    def _describe(self, frame: RigFrame) -> dict[str, Any]:
        return {
            "sequence": frame.sequence,
            "exposure_us": frame.exposure_us,
            "delivered_us": frame.delivered_us,
            "ffc": frame.ffc,
            "width": self._rig.camera["width"],
            "height": self._rig.camera["height"],
        }
