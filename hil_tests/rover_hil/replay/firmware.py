"""The firmware of a rig under recorded ticks and the host's recorded bytes; what it answers is held against the log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rover.link.port import SLCAN_BAUD
from rover.record.difference import NOTHING, Difference, first_field
from rover.record.rig_step import RigStep
from rover_protocol import framing, messages
from rover_protocol.rig_tick import BUZZER, LED, NO_SENSOR, POWERED, TickReply

from rover_hil.firmware_process import FirmwareProcess

REPLIES = "/rig/firmware"
# Where a difference of outputs, or of sent bytes, is said to be.
SENT = "/rig/firmware/sent"

# What tells one rig's firmware from another's; where a log meets another rig these may differ.
IDENTITY = {"HelloReply": ("board",), "HelloBuild": ("git_hash",)}

# The emulated board takes a byte in when its interrupt runs, rover-sitl when the byte is complete; and an edge of an
# echo that meets the UART's interrupt waits for it, up to 4 µs: a millimetre. µs and mm.
TOLERANCES = {
    "ClockReply": {"receive_time": 4, "turnaround": 4},
    "OdometryHeading": {"time": 4},
    "Sonar": {"time": 4, "range": 1},
}


@dataclass(frozen=True)
class Compared:
    """What came of a part of a replay: `count` of what was compared, and the first difference."""

    count: int
    difference: Difference | None


class FirmwareReplay:
    """One firmware process from its power-on. `feed` every step in order, then `finish`."""

    def __init__(self, command: Sequence[str], origin: dict[str, str], another: bool = False) -> None:
        """`command`: the firmware's program with its first arguments; `origin`: metadata of the log.

        `another`: it is another rig's firmware than the recorded one, so that what says who it is may differ. Needs a
        log of the serial line.
        """
        can = origin["transport"] == "can"
        baud = SLCAN_BAUD if can else int(origin["baud"])
        self._process = FirmwareProcess(list(command), baud, origin["transport"])
        self._decoders = None if can else (framing.Decoder(), framing.Decoder())
        self._another = another
        self._sent = 0
        self._ticks = 0
        self._difference: Difference | None = None
        self._introduced = Introduction(can)

    @property
    def identity(self) -> dict[str, str]:
        """What the firmware has said of itself; empty before a handshake."""
        return self._introduced.said

    def feed(self, step: RigStep) -> None:
        """One step; nothing after the first difference, for from there on the inputs are another rover's."""
        if self._difference is not None or not step.requests:
            return
        self._process.send(step.to_firmware)
        self._process.stdin.write(b"".join(step.requests))
        self._process.stdin.flush()
        replies = self._read(len(step.requests) * TickReply.SIZE)
        total = TickReply.unpack(replies[-1]).bytes_sent if replies else self._sent
        sent = self._process.receive(total - self._sent)
        self._sent = total
        self._introduced.hear(sent)
        self._difference = self._compare(step, replies, sent)

    def finish(self) -> Compared:
        """Ends the process."""
        self._process.close()
        return Compared(self._ticks, self._difference)

    def _read(self, length: int) -> list[bytes]:
        data = self._process.stdout.read(length)
        return [data[at : at + TickReply.SIZE] for at in range(0, len(data) - TickReply.SIZE + 1, TickReply.SIZE)]

    def _compare(self, step: RigStep, replies: list[bytes], sent: bytes) -> Difference | None:
        for index, recorded in enumerate(step.replies):
            time = (step.start_us + 1000 * (index + 1)) * 1e-6
            if index >= len(replies):
                return Difference(REPLIES, time, "reply", outputs(recorded), "the firmware has ended")
            if replies[index] != recorded:
                found = first_field(outputs(recorded), outputs(replies[index]))
                field, before, now = found or ("bytes", recorded.hex(), replies[index].hex())
                if field == "bytes_sent" and (frame := self._frame_difference(step, sent)) is not None:
                    return frame
                return Difference(REPLIES, time, field, before, now)
            self._ticks += 1
        if sent == step.from_firmware:
            for decoder in self._decoders or ():
                list(decoder.feed(sent))
            return None
        frame = self._frame_difference(step, sent)
        if frame is not None or self._another:
            return frame
        at = next((i for i, (a, b) in enumerate(zip(step.from_firmware, sent, strict=False)) if a != b), 0)
        return Difference(SENT, step.now_us * 1e-6, f"byte {at}", step.from_firmware.hex(), sent.hex())

    def _frame_difference(self, step: RigStep, sent: bytes) -> Difference | None:
        """The first frame of the serial wire that differs, by its name."""
        if self._decoders is None:
            return None
        recorded, replayed = (
            [self._named(identifier, payload) for identifier, _, payload in decoder.feed(data)]
            for decoder, data in zip(self._decoders, (step.from_firmware, sent), strict=True)
        )
        for index in range(max(len(recorded), len(replayed))):
            before = recorded[index] if index < len(recorded) else None
            now = replayed[index] if index < len(replayed) else None
            if before != now and not (self._another and _as_good_as_equal(before, now)):
                field, was, is_now = first_field(before, now) or ("message", before, now)
                time = step.now_us * 1e-6
                return Difference(
                    SENT, time, field, NOTHING if was is None else was, NOTHING if is_now is None else is_now
                )
        return None

    def _named(self, identifier: int, payload: bytes) -> dict[str, Any]:
        try:
            message, fields = messages.decode(identifier, payload)
        except ValueError:
            return {"message": hex(identifier), "data": payload.hex()}
        hidden = IDENTITY.get(message.name, ()) if self._another else ()
        plain = {
            key: value.hex() if isinstance(value, bytes) else value
            for key, value in fields.items()
            if key not in hidden
        }
        return {"message": message.name, message.name: plain}


class Introduction:
    """What a firmware says of itself in its answers to Hello, over either wire."""

    def __init__(self, can: bool) -> None:
        self._can = can
        self._decoder = framing.Decoder()
        self._text = b""
        self._fields: dict[str, Any] = {}

    @property
    def said(self) -> dict[str, str]:
        """Version, commit and board, as a log's record `firmware` has them."""
        if not {"board", "git_hash"} <= set(self._fields):
            return {}
        f = self._fields
        return {
            "version": f"{f['version_major']}.{f['version_minor']}.{f['version_patch']}",
            "git_hash": f"{f['git_hash']:08x}",
            "board": messages.VALUES["HelloReply"]["board"].get(f["board"], f"Unknown{f['board']}"),
        }

    def hear(self, sent: bytes) -> None:
        """Bytes of the firmware, in order."""
        if self.said:
            return
        frames = self._of_text(sent) if self._can else [(i, p) for i, _, p in self._decoder.feed(sent)]
        for identifier, payload in frames:
            if identifier in (messages.HelloReply.ID, messages.HelloBuild.ID):
                self._fields |= messages.decode(identifier, payload)[1]

    def _of_text(self, sent: bytes) -> list[tuple[int, bytes]]:
        *lines, self._text = (self._text + sent).split(b"\r")
        return [(int(line[1:4], 16), bytes.fromhex(line[5:].decode())) for line in lines if line[:1] == b"t"]


def outputs(reply: bytes) -> dict[str, Any]:
    """A TickReply by name."""
    tick = TickReply.unpack(reply)
    return {
        "duty_left": tick.duty_left,
        "duty_right": tick.duty_right,
        "powered": bool(tick.flags & POWERED),
        "led": bool(tick.flags & LED),
        "buzzer": bool(tick.flags & BUZZER),
        "sonar_trigger": None if tick.sonar_trigger == NO_SENSOR else tick.sonar_trigger,
        "bytes_sent": tick.bytes_sent,
    }


def _as_good_as_equal(before: dict[str, Any] | None, now: dict[str, Any] | None) -> bool:
    """Whether two frames differ in nothing but what an interrupt's delay explains."""
    if before is None or now is None or before["message"] != now["message"]:
        return False
    name = before["message"]
    tolerances = TOLERANCES.get(name, {})
    return all(
        abs(value - now[name][key]) <= tolerances[key] if key in tolerances else value == now[name][key]
        for key, value in before.get(name, {}).items()
    )
