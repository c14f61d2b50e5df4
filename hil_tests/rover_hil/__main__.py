"""The server of a lock-stepped rig, as a companion starts it; `rover hil serve` is a rig for any client.

python -m rover_hil serve --mission demo --rig sitl --seed 3 --control /tmp/rover.sock
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from rover.errors import RoverError

from rover_hil.serve import RIGS, WIRES, Options, serve


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m rover_hil", description=__doc__, formatter_class=raw)
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("serve", help="offer a rig to a companion: a serial port and a control socket")
    command.add_argument("--mission", required=True, type=Path, help="mission file, or the name of a shipped one")
    command.add_argument("--rig", default="sitl", help=f"one of {', '.join(RIGS)}")
    command.add_argument("--wire", default="serial", help=f"one of {', '.join(WIRES)}; CAN is slcan on the port")
    command.add_argument("--seed", type=int, default=0, help="fixes field, noise, slip and everything else random")
    command.add_argument("--control", required=True, type=Path, help="unix socket to listen on")
    command.add_argument("--out", type=Path, help="folder for truth.json and truth.tum")
    command.add_argument("--data", type=Path, help="folder with landmines/: ground of real thermal pictures")
    command.add_argument("--former", type=Path, help="folder of a run whose rover drives on from where it stands")
    command.add_argument("--linger", type=float, default=60.0, help="seconds to go on after a companion was lost")
    command.add_argument(
        "--no-camera", dest="pictures", action="store_false", help="take no pictures: the world without vision"
    )
    return parser.parse_args(argv)


def main(argv: list[str] | None = None) -> int:
    """Returns the exit code."""
    given = vars(_arguments(argv))
    given.pop("command")
    try:
        serve(Options(**given))
    except RoverError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        return 0
    except BrokenPipeError:
        # Whoever started the rig does not listen any more; nothing is left to say it to.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
