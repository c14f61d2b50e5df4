"""A rig out of a log: the mission's loop runs on it as on a real one, over a real port, with the recorded bytes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from rover.capture.source import RigFrames
from rover.errors import BadInput, LinkLost
from rover.link.lockstep import open_lockstep
from rover.link.port import CanPort
from rover.mission.loop import Control
from rover.record.comparison import RecordingOver
from rover.record.log_reader import Log, LoggedFrame, LogMessage
from rover.record.rig_step import RigStep
from rover.record.topics import OPERATOR, RIG_LOST

from rover_hil.pty import PseudoTerminal

OnStep = Callable[[RigStep], None]


class RecordedRig:
    """Time, frames, bytes and the operator of a log. Is the rig of `rover.mission.loop.MissionLoop`.

    Raises BadInput when the log does not begin with the rig's power-on.
    """

    def __init__(self, log: Log, control: Control, on_step: OnStep) -> None:
        """`on_step` gets every step when its time has come: it paces, and feeds the firmware."""
        origin = log.metadata["mission"]
        self._log = log
        self._control = control
        self._on_step = on_step
        self._steps: Iterator[RigStep] = log.steps()
        self._pictures = log.frames()
        self._picture = next(self._pictures, None)
        self._events = log.messages((OPERATOR, RIG_LOST))
        self._event = next(self._events, None)
        first = next(self._steps, None)
        if first is None or first.start_us != 0:
            raise BadInput(
                f"{log.path}: the log does not begin when the rig was switched on: there is nothing to start from"
            )
        self._next: RigStep | None = first
        self._now_us = 0
        self.frames = RigFrames()
        self.frames_fed = 0
        self._pty = PseudoTerminal()
        port = CanPort("slcan", self._pty.name).name if origin["transport"] == "can" else self._pty.name
        self.transport, self._announce = open_lockstep(port, int(origin["baud"]), float(origin["cycle_s"]))

    def now(self) -> float:
        """Virtual time of the recording, seconds."""
        return self._now_us * 1e-6

    def advance(self, to: float) -> None:
        """Hands over what the recorded rig did until `to`. Raises LinkLost where it was lost."""
        to_us = round(to * 1e6)
        while self._now_us < to_us:
            step = self._next
            if step is None:
                self._end()
            assert step is not None
            self._take(step)

    def drain(self) -> None:
        """Goes through the rest of the recording without the companion."""
        while self._next is not None:
            self._take(self._next)
            list(self.frames)

    def finish(self, zones: Sequence[dict[str, Any]] = (), detections: Sequence[dict[str, Any]] = ()) -> dict[str, Any]:
        """A recording has no referee."""
        return {}

    def close(self) -> None:
        """Lets go of the port."""
        self.transport.close()
        self._pty.close()

    def _take(self, step: RigStep) -> None:
        self._on_step(step)
        self._next = next(self._steps, None)
        while self._pty.read(4096):
            pass  # what the companion sends is compared as messages
        self._pty.write(step.from_firmware)
        self._now_us = step.now_us
        self._announce(step.marks())
        until_ns = step.now_us * 1000
        while self._picture is not None and self._picture.time_ns <= until_ns:
            self._deliver(self._picture)
            self._picture = next(self._pictures, None)
        while self._event is not None and self._event.time_ns <= until_ns and self._event.topic == OPERATOR:
            self._operate(self._event)
            self._event = next(self._events, None)

    def _deliver(self, picture: LoggedFrame) -> None:
        self.frames.accept([picture.header], picture.pixels)
        self.frames_fed += 1

    def _operate(self, event: LogMessage) -> None:
        wanted = json.loads(event.data)
        self._control.stop, self._control.emergency = wanted["stop"], wanted["emergency"]

    def _end(self) -> None:
        if self._event is not None and self._event.topic == RIG_LOST:
            raise LinkLost(json.loads(self._event.data)["text"])
        if self._log.cut:
            raise RecordingOver
        raise LinkLost("link lost: the recording ends here")
