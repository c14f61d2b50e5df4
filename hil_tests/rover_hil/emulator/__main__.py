"""The emulated board as a process, in the place of rover-sitl.

python -m rover_hil.emulator --serial-fd N [--baud 230400] [--wire serial] [--elf firmware/build/rover-pico.elf]

One 40-byte request on stdin is one millisecond, answered by one 16-byte reply on stdout. Ends when stdin ends.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from rover.errors import RoverError
from rover.link.baud import DEFAULT_BAUD

from rover_hil.emulator.process import Options, run
from rover_hil.firmware_process import BUILT_ELF


def main(argv: list[str] | None = None) -> int:
    """Returns the exit code."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m rover_hil.emulator", description=__doc__, formatter_class=raw)
    parser.add_argument("--serial-fd", required=True, type=int, help="descriptor of the serial line or slcan")
    parser.add_argument("--baud", type=int, default=DEFAULT_BAUD, help="bits per second of the host's end of the line")
    parser.add_argument("--wire", choices=("serial", "can"), default="serial", help="what the descriptor carries")
    parser.add_argument("--elf", type=Path, default=BUILT_ELF, help="firmware to run")
    given = parser.parse_args(argv)
    try:
        run(Options(given.serial_fd, given.baud, given.wire, given.elf), sys.stdin.buffer, sys.stdout.buffer)
    except RoverError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    except (KeyboardInterrupt, BrokenPipeError):
        return 0
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
