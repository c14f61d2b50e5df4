"""Stands between plant and rover-sitl and records every tick with the host's bytes that belong to it.

ROVER_TICKS=ticks.bin ROVER_SITL=<a script that runs this module> rover run MISSION --rig sitl

The file holds, for each tick, the TickRequest (protocol/rig_tick.toml), a 16-bit count, and so many bytes of the host.
"""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rover_protocol.rig_tick import TickReply, TickRequest

from rover_hil.emulator.descriptor import Descriptor
from rover_hil.emulator.tick_pipe import Request
from rover_hil.firmware_process import BUILT, FirmwareProcess

COUNT = struct.Struct("<H")


@dataclass(frozen=True)
class Tick:
    """One recorded millisecond."""

    raw: bytes
    """The request as it was sent."""
    host: bytes

    @property
    def request(self) -> Request:
        """Decoded."""
        return Request.unpack(self.raw)


def read_ticks(path: Path) -> Iterator[Tick]:
    """Ticks in order; a last one that is cut is left out."""
    data = path.read_bytes()
    at = 0
    while at + TickRequest.SIZE + COUNT.size <= len(data):
        request = data[at : at + TickRequest.SIZE]
        (count,) = COUNT.unpack_from(data, at + TickRequest.SIZE)
        at += TickRequest.SIZE + COUNT.size
        if at + count > len(data):
            return
        yield Tick(request, data[at : at + count])
        at += count


def write_launcher(folder: Path, recording: Path) -> Path:
    """An executable that takes rover-sitl's place and records to `recording`."""
    launcher = folder / "recorded-sitl"
    launcher.write_text(
        f'#!/bin/sh\nROVER_TICKS="{recording}" exec "{sys.executable}" -m rover_hil.tick_recorder "$@"\n'
    )
    launcher.chmod(0o755)
    return launcher


def main() -> None:
    """Passes everything on in both directions until the requests end."""
    arguments = dict(zip(sys.argv[1::2], sys.argv[2::2], strict=True))
    line = Descriptor(int(arguments["--serial-fd"]))
    process = FirmwareProcess(BUILT, int(arguments["--baud"]), arguments.get("--wire", "serial"))
    forwarded = 0
    with Path(os.environ["ROVER_TICKS"]).open("wb") as recording:
        while len(data := sys.stdin.buffer.read(TickRequest.SIZE)) == TickRequest.SIZE:
            host = line.read(Request.unpack(data).host_bytes_due)
            if host is None:
                break
            recording.write(data + COUNT.pack(len(host)) + host)
            process.send(host)
            process.stdin.write(data)
            process.stdin.flush()
            reply = process.stdout.read(TickReply.SIZE)
            if len(reply) < TickReply.SIZE:
                break
            total = TickReply.unpack(reply).bytes_sent
            line.write(process.receive(total - forwarded))
            forwarded = total
            sys.stdout.buffer.write(reply)
            sys.stdout.buffer.flush()
    process.close()


if __name__ == "__main__":
    main()
