"""A rig out of a log: it speaks the control socket and the port of a real one, so the companion's end is the same code.

The companion asks it to run on, as it asks every rig; what comes back are the recorded bytes, marks and frames.
"""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rover.errors import BadInput
from rover.link.port import CanPort
from rover.mission.commands import Command, Word
from rover.mission.loop import Control
from rover.record.log_reader import Log
from rover.record.rig_step import RigStep
from rover.record.topics import OPERATOR, RIG_LOST

from rover_hil.client.rig import LockstepRig
from rover_hil.pty import PseudoTerminal
from rover_hil.rig import Advance, RigFailed, RigFrame
from rover_hil.session import Session

OnStep = Callable[[RigStep], None]
LOST = "link lost: the rig: "
HOST_TIMEOUT_S = 5.0


class RecordedRig:
    """The server's side; is a `rover_hil.rig.Rig` as far as a session asks for one.

    Raises BadInput when the log does not begin with the rig's power-on.
    """

    def __init__(self, log: Log, on_step: OnStep) -> None:
        """`on_step` gets every step, to feed the firmware."""
        self.name = log.metadata["mission"]["rig"]
        self.frames_fed = 0
        self.now_us = 0
        self._log = log
        self._on_step = on_step
        self._steps = log.steps()
        self._pictures = log.frames()
        self._picture = next(self._pictures, None)
        self._next = next(self._steps, None)
        if self._next is None or self._next.start_us != 0:
            raise BadInput(f"{log.path}: the log does not begin when the rig was switched on: nothing to start from")
        size = self._picture.header if self._picture is not None else {"width": 0, "height": 0}
        self.camera: dict[str, Any] = {"width": size["width"], "height": size["height"]}
        self._pty = PseudoTerminal()
        self.port = self._pty.name
        self._from_host = 0

    def begin_session(self) -> None:
        """There is one companion."""

    def record(self) -> None:
        """What is in a log need not be recorded again."""

    def set_emergency_stop(self, active: bool) -> None:
        """The button is in the recorded ticks."""

    def advance(self, to_us: int, host_bytes: int) -> Advance:
        """What the recorded rig did until `to_us`. Raises RigFailed where the recording ends."""
        # What the companion sends is compared as messages; it is read so that the port does not fill up.
        self._from_host += len(self._pty.read_exactly(host_bytes - self._from_host, HOST_TIMEOUT_S))
        marks: list[tuple[int, int]] = []
        frames: list[RigFrame] = []
        while self.now_us < to_us:
            step = self._next
            if step is None:
                raise RigFailed(self._end())
            marks += self._take(step)
            self._pty.write(step.from_firmware)
            frames += self._frames_until(step.now_us)
        return Advance(self.now_us, tuple(marks), tuple(frames))

    def drain(self) -> None:
        """Goes through the rest of the recording without a companion."""
        while self._next is not None:
            self._take(self._next)
        self._frames_until(self.now_us)

    def close(self) -> None:
        """Lets go of the port."""
        self._pty.close()

    def _take(self, step: RigStep) -> list[tuple[int, int]]:
        self._on_step(step)
        self._next = next(self._steps, None)
        self.now_us = step.now_us
        return step.marks()

    def _frames_until(self, time_us: int) -> list[RigFrame]:
        frames = []
        while self._picture is not None and self._picture.time_ns <= time_us * 1000:
            header = self._picture.header
            exposure_us = header["exposure_us"]
            frames.append(RigFrame(header["sequence"], exposure_us, time_us, header["ffc"], self._picture.pixels))
            self._picture = next(self._pictures, None)
        self.frames_fed += len(frames)
        return frames

    def _end(self) -> str:
        lost = next(self._log.messages((RIG_LOST,)), None)
        text = json.loads(lost.data)["text"] if lost is not None else "the recording ends here"
        return text.removeprefix(LOST)


class RecordedOperator:
    """Presses what the operator pressed, in the companion's own cycle."""

    def __init__(self, log: Log, control: Control) -> None:
        self._control = control
        self._events = log.messages((OPERATOR,))
        self._event = next(self._events, None)

    def act(self, now_us: int) -> None:
        """To be called when the companion's time is `now_us`."""
        while self._event is not None and self._event.time_ns <= now_us * 1000:
            wanted = json.loads(self._event.data)
            if "word" in wanted:
                self._control.commands.append(Command(Word(wanted["word"]), wanted["goal"]))
            else:
                self._control.stop, self._control.emergency = wanted["stop"], wanted["emergency"]
                self._control.attended = wanted.get("attended", False)
            self._event = next(self._events, None)


class RecordedWorld:
    """A recorded rig that is served by a thread, and the companion's end of it: `rig`."""

    def __init__(self, recorded: RecordedRig, log: Log, on_arrival: Callable[[int], None], folder: Path) -> None:
        """`on_arrival` is called on the companion's side with each time, µs, that it reaches: there it may be paced."""
        origin = log.metadata["mission"]
        self._recorded = recorded
        self._failure: BaseException | None = None
        address = str(folder / "control.sock")
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._listener.bind(address)
        self._listener.listen(1)
        self._thread = threading.Thread(target=self._serve, name="recorded-rig", daemon=True)
        self._thread.start()
        port = CanPort("slcan", recorded.port).name if origin["transport"] == "can" else recorded.port
        self.rig = LockstepRig(
            port, address, int(origin["baud"]), float(origin["cycle_s"]), lambda now_us, *_: on_arrival(now_us)
        )

    def close(self) -> None:
        """Lets the companion's end go and waits for the thread; raises what has gone wrong in it."""
        self.rig.close()
        self._thread.join()
        self._listener.close()
        if self._failure is not None:
            raise self._failure

    def _serve(self) -> None:
        try:
            connection, _ = self._listener.accept()
            with connection:
                Session(self._recorded, lambda zones, detections: {}).serve(connection)
        except RigFailed:
            return  # the end of the recording, which the companion has been told
        except BaseException as error:
            self._failure = error
